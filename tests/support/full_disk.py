"""A disk that is full."""

from __future__ import annotations

import pytest

from codesign import files


def full_disk(monkeypatch: pytest.MonkeyPatch, after: int) -> None:
    """A disk that is full after so many files."""
    made = []
    real = files.tempfile.mkstemp

    def mkstemp(**words: object) -> tuple[int, str]:
        made.append(words)
        if len(made) > after:
            raise OSError(28, "No space left on device")
        return real(**words)  # type: ignore[call-overload,no-any-return]

    monkeypatch.setattr(files.tempfile, "mkstemp", mkstemp)
