"""Compiled circuits of the tests stay out of the user's cache."""

from __future__ import annotations

import pytest
from toy_styles import installed

__all__ = ["installed"]


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path_factory.getbasetemp() / "cache"))
