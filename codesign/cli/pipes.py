"""Output that cannot be written: the reader ended, as in ``hwsw ... | head``, or the disk is full."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from io import TextIOWrapper
from typing import Any, TextIO, cast


class UnfailingStream:
    """A text stream that never raises. After the first failure all output is lost.

    ``fault`` is that failure, or None. A reader that ended is no failure: it needs no more output.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.fault: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write, or lose, ``text``."""
        try:
            return self._stream.write(text)
        except OSError as fault:
            self._lose_the_rest(fault)
            return len(text)

    def flush(self) -> None:
        """Flush, or lose, what was written."""
        try:
            self._stream.flush()
        except OSError as fault:
            self._lose_the_rest(fault)

    def _lose_the_rest(self, fault: OSError) -> None:
        if not isinstance(fault, BrokenPipeError):
            self.fault = self.fault or fault
        # Redirect the descriptor and not the stream: Python flushes the stream's buffer once more at exit.
        null_device = os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(null_device, self._stream.fileno())
        finally:
            os.close(null_device)


@contextmanager
def output_may_fail() -> Iterator[UnfailingStream | None]:
    """Let a command complete its work, with its own exit code, even if its output fails.

    Yields standard output, or None without one. A character that the terminal cannot encode becomes "?".
    """
    with ExitStack() as stack:
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper) and stream.errors == "strict":
                stream.reconfigure(errors="replace")
        out = None if sys.stdout is None else UnfailingStream(sys.stdout)
        if out is not None:
            stack.enter_context(redirect_stdout(cast("TextIO", out)))
        if sys.stderr is not None:
            stack.enter_context(redirect_stderr(cast("TextIO", UnfailingStream(sys.stderr))))
        yield out
