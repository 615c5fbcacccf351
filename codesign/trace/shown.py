"""What views hand to the writer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple


class Encoded(NamedTuple):
    """A message that is encoded already, and its class in Foxglove's SDK."""

    kind: Any
    data: bytes


Show = Callable[[str, Any, int], None]
"""Takes a topic, a message of Foxglove's SDK or an ``Encoded`` one, and its time, ps."""
