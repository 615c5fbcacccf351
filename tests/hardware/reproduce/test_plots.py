"""Plots of a reproduction are written as files."""

from __future__ import annotations

from pathlib import Path

import pytest
from full_disk import full_disk

from codesign.ground.errors import RunError
from codesign.hardware import reproduce as plots


def test_plots_on_a_full_disk_are_a_failed_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plots, "plot_svg", lambda plot: "<svg/>")
    plot = type("Plot", (), {"name": "one"})()
    reproduction = type("Found", (), {"figures": (plot,)})()
    full_disk(monkeypatch, 0)
    with pytest.raises(RunError, match="No space left"):
        plots.write_plots(reproduction, tmp_path / "plots")  # type: ignore[arg-type]
    assert list((tmp_path / "plots").iterdir()) == []
