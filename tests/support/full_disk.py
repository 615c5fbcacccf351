"""A disk that is full."""

from __future__ import annotations

from pathlib import Path

import pytest

from codesign.ground import files


def full_disk(monkeypatch: pytest.MonkeyPatch, after: int) -> None:
    """A disk that is full after so many files."""
    made = []
    real = files.part_of

    def part_of(target: Path) -> Path:
        made.append(target)
        if len(made) > after:
            raise OSError(28, "No space left on device")
        return real(target)

    monkeypatch.setattr(files, "part_of", part_of)
