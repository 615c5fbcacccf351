"""A study that a process is computing, read meanwhile: what is there, and how much is missing."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

from codesign.ground.errors import StoreError
from codesign.study import load_study

Run = Callable[..., Result]

EXPLORE = (
    *("-m", "codesign", "explore", "virtex4-pci", "labyrinth", "--workers", "1", "--quiet"),
    *("--axis", "relax.iterations=1..2", "--axis", "fabric.clock=50MHz..70MHz:10MHz"),
    *("--set", "workload.problem.arrive=0", "--set", "relax.termination=sound"),
)
POINTS = 7 * 2 * 9 * 2 * 3
SECONDS = 1200
"""A run that takes longer hangs."""


@pytest.mark.skipif(os.name != "posix", reason="the run is stopped by a signal of POSIX")
def test_a_report_beside_a_run_says_how_many_points_are_missing(hwsw: Run, tmp_path: Path) -> None:
    file = tmp_path / "study.sqlite"
    with subprocess.Popen([sys.executable, *EXPLORE, "--store", str(file)], stdout=subprocess.PIPE) as run:
        try:
            while not 0 < (left := missing(file)) < POINTS:
                assert run.poll() is None, "the run ended before it was looked at"
                time.sleep(0.05)
            run.send_signal(signal.SIGSTOP)
            before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
            left = missing(file)
            shown = hwsw("report", file)
            # So far none may be feasible.
            assert shown.exit_code in (0, 3), shown.output
            assert f"{left:,} not computed" in re.sub(r"\s+", " ", shown.output)
            assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
            run.send_signal(signal.SIGCONT)
            # Reading goes on while it writes, and sees ever more of it.
            end = time.monotonic() + SECONDS
            while run.poll() is None:
                assert time.monotonic() < end, "the run takes too long"
                now = missing(file)
                assert now <= left
                left = now
                time.sleep(0.05)
        finally:
            run.send_signal(signal.SIGCONT)
            run.terminate()
    assert run.returncode == 0
    assert missing(file) == 0
    assert "not computed" not in hwsw("report", file).output


def missing(file: Path) -> int:
    """How many points a store lacks; all of them as long as there is no study in it."""
    try:
        return len(load_study(file).missing)
    except StoreError:
        return POINTS
