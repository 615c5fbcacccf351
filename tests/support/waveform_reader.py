"""A parser of VCD that is not the one that writes them."""

from __future__ import annotations

import signal

# At its import the package gives SIGPIPE its default action: then a process that writes to a worker that died dies too.
_before = signal.getsignal(signal.SIGPIPE)
from vcdvcd import VCDVCD  # noqa: E402

signal.signal(signal.SIGPIPE, _before)

__all__ = ["VCDVCD"]
