"""All commands: unknown names, a current folder that is gone, a broken cache of kernels."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from codesign.cli import main
from codesign.hardware.calibrate.reports import TOOLS
from codesign.inputs.exploration import SAMPLERS

Run = Callable[..., Result]


def test_unknown_names_get_the_nearest(hwsw: Run) -> None:
    result = hwsw("run", "virtex4-pcy", "labyrinth")
    assert result.exit_code == 2
    assert "virtex4-pci" in result.output
    assert hwsw("run", "virtex4-pci", "missing.yaml").exit_code == 2
    assert hwsw("trace", "info", __file__).exit_code in (1, 2)
    assert hwsw("explode").exit_code == 2


def test_a_deleted_current_folder_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hwsw: Run) -> None:
    def gone() -> str:
        raise FileNotFoundError(2, "No such file or directory")

    monkeypatch.setattr(os, "getcwd", gone)
    result = hwsw("list")
    assert result.exit_code == 2
    assert "the current folder does not exist any more" in result.stderr


@pytest.mark.parametrize("kind", ["EOFError()", "__import__('pickle').UnpicklingError('truncated')"])
def test_a_broken_kernel_cache_is_told(hwsw: Run, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    names: dict[str, Callable[..., None]] = {}
    exec(compile(f"def load(*a):\n    raise {kind}\n", "/x/numba/core/caching.py", "exec"), names)
    monkeypatch.setattr("codesign.system.at_hand", names["load"])
    result = hwsw("list")
    assert result.exit_code == 1
    assert "cache of compiled kernels" in result.stderr
    assert "NUMBA_CACHE_DIR" in result.stderr


def test_the_help_names_every_search_and_every_tool_of_reports() -> None:
    assert set(SAMPLERS) <= set(re.findall(r"\w+", help_of("explore")))
    told = set(re.findall(r"\w+", help_of("calibrate", "fpga")))
    assert {word for tool in TOOLS for word in re.findall(r"[A-Z]\w+|nextpnr", tool.name)} <= told


def help_of(*words: str) -> str:
    done = CliRunner().invoke(main, [*words, "--help"])
    assert done.exit_code == 0
    return done.output
