"""Output that cannot be delivered: a reader who went away, as in ``hwsw ... | head``, or a full disk."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from io import TextIOWrapper
from typing import Any, TextIO, cast


class Heedless:
    """A text stream that never fails: from the first failure on, what is written is lost.

    ``fault`` is that failure, or None; a reader who went away is none, as he wants no more.
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
        # The descriptor, not the stream: what stands in its buffer is flushed once more when Python ends.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(nowhere, self._stream.fileno())
        finally:
            os.close(nowhere)


@contextmanager
def output_may_fail() -> Iterator[Heedless | None]:
    """Let a command end its work, and with its own exit code, whatever becomes of its output.

    Yields standard output, or None where there is none. A character that the terminal's encoding lacks becomes "?".
    """
    with ExitStack() as stack:
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper) and stream.errors == "strict":
                stream.reconfigure(errors="replace")
        out = None if sys.stdout is None else Heedless(sys.stdout)
        if out is not None:
            stack.enter_context(redirect_stdout(cast("TextIO", out)))
        if sys.stderr is not None:
            stack.enter_context(redirect_stderr(cast("TextIO", Heedless(sys.stderr))))
        yield out
