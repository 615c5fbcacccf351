"""What the tests of board questions share."""

from __future__ import annotations

from pathlib import Path

import pytest
from advice_boards import CELLS


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of its own for each test."""
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def corridor(tmp_path: Path) -> Path:
    path = tmp_path / "corridor.txt"
    path.write_text("." * CELLS + "\n", encoding="utf-8")
    return path
