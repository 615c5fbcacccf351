"""Output whose reader may go away before the end, as in ``hwsw ... | head``."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from typing import Any, TextIO, cast


class _Heedless:
    """A text stream that takes no notice of a reader who went away: what is written from then on is lost."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write, or lose, ``text``."""
        try:
            return self._stream.write(text)
        except BrokenPipeError:
            self._lose_the_rest()
            return len(text)

    def flush(self) -> None:
        """Flush, or lose, what was written."""
        try:
            self._stream.flush()
        except BrokenPipeError:
            self._lose_the_rest()

    def _lose_the_rest(self) -> None:
        # The descriptor, not the stream: what stands in its buffer is flushed once more when Python ends.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(nowhere, self._stream.fileno())
        finally:
            os.close(nowhere)


@contextmanager
def readers_may_leave() -> Iterator[None]:
    """Let a command end its work, and with its own exit code, whoever still reads its output."""
    with ExitStack() as stack:
        stack.enter_context(redirect_stdout(cast("TextIO", _Heedless(sys.stdout))))
        stack.enter_context(redirect_stderr(cast("TextIO", _Heedless(sys.stderr))))
        yield
