"""What the tests of calibrations share."""

from __future__ import annotations

from pathlib import Path

import pytest
from fpga_reports import DESIGN, Run, nextpnr


@pytest.fixture
def calibrated(tmp_path: Path, hwsw: Run, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a calibration ``mine`` of breadth-first search on an ULX3S."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "calibrations").mkdir()
    nextpnr(tmp_path)
    done = hwsw("calibrate", "fpga", *DESIGN, "--report", "report.json", "-o", "calibrations/mine.yaml")
    assert done.exit_code == 0, done.output
    return tmp_path
