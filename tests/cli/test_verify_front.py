"""Certificates on the command line: written by ``explore`` and ``report``, checked by ``verify-front``."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest
import tampering
from click.testing import Result

from codesign.ground.units import counted
from codesign.study import load_study

Run = Callable[..., Result]
Specs = tuple[Path, Path]


@pytest.fixture
def explored(hwsw: Run, specs: Specs) -> Run:
    """A store ``s`` of 32 of the 96 points, and their certificate ``c``."""
    options = ("--store", "s", "--workers", 1, "--certify", "c", "--set", "relax.block=[12,18]")
    result = hwsw("explore", *specs, *options)
    assert result.exit_code == 0, result.output
    assert "certificate: c" in result.output
    return hwsw


def test_the_certificate_of_an_exploration_is_accepted(explored: Run) -> None:
    result = explored("verify-front", "c", "--store", "s", "--complete")
    assert result.exit_code == 0, result.output
    study = load_study("s")
    count = counted(len(study.front), "design")
    assert result.output.startswith(f"Accepted: of two-rooms on small-board, {count} of 32 ")
    verdict = json.loads(explored("verify-front", "c", "--json").stdout)
    assert verdict["front"] == list(study.front)
    assert sum(verdict["designs"].values()) == len(study.designs)
    assert verdict["designs"]["unfit"] == int((~study.judged.feasible).sum())
    assert verdict["content"] in result.output
    given, *claims = verdict["trusted"]
    assert given == {"what": "figures, tasks and budgets", "designs": len(study.designs), "eligible": None}
    assert sum(claim["designs"] for claim in claims) == verdict["designs"]["unfit"] + verdict["designs"]["same"]
    printed = [" ".join(line.split()) for line in result.output.splitlines()]
    assert "taken on trust designs eligible by figures" in printed
    for claim in claims:
        assert f"{claim['what']} {claim['designs']} {claim['eligible']}" in printed


def test_a_report_writes_the_same_certificate(explored: Run, tmp_path: Path) -> None:
    assert explored("report", "s", "--certify", "again").exit_code == 0
    assert (tmp_path / "again").read_bytes() == (tmp_path / "c").read_bytes()


def test_the_certificate_of_another_study_is_refused(explored: Run, tmp_path: Path) -> None:
    need = ("--need", "slices < 9000")
    assert explored("report", "s", *need, "--certify", "other").exit_code in (0, 3)
    assert explored("verify-front", "other").exit_code == 0
    result = explored("verify-front", "other", "--store", "s")
    assert result.exit_code == 3
    assert "other: refused: it is not of the exploration in s: they differ in constraints" in result.stderr
    assert "hwsw report s --certify FILE" in result.stderr
    assert explored("verify-front", "other", "--store", "s", *need).exit_code == 0


def test_what_was_not_computed_is_said(hwsw: Run, specs: Specs) -> None:
    options = ("--store", "s", "--workers", 1, "--certify", "c", "--points", 8)
    assert hwsw("explore", *specs, *options).exit_code in (0, 3)
    result = hwsw("verify-front", "c", "--store", "s")
    assert result.exit_code == 0
    assert "of 96 are the front of those computed (88 were not)." in result.output.replace(" is the", " are the")
    assert "not computed" in result.output
    result = hwsw("verify-front", "c", "--complete")
    assert result.exit_code == 3
    assert "c: refused: 88 designs not computed" in result.stderr


def test_a_file_that_was_changed_is_refused(explored: Run, tmp_path: Path) -> None:
    content = (tmp_path / "c").read_bytes()
    (tmp_path / "d").write_bytes(content[:99] + b"!" + content[100:])
    result = explored("verify-front", "d")
    assert result.exit_code == 1
    assert "d: was changed or cut off since it was written: its seal is broken" in result.stderr
    for around in (tampering.bytes_before, tampering.bytes_after):
        (tmp_path / "d").write_bytes(around(content, Random(1)))
        result = explored("verify-front", "d")
        assert result.exit_code == 1
        assert "d: is no certificate of version 1: bytes of no member stand" in result.stderr
    result = explored("verify-front", "s")
    assert result.exit_code == 1
    assert "s: is no certificate" in result.stderr
    assert explored("verify-front", "missing").exit_code == 2
    result = explored("verify-front", "c", "--need", "slices < 9000")
    assert result.exit_code == 2
    assert "--need: needs a store" in result.stderr


def test_a_certificate_may_not_overwrite_the_store(hwsw: Run, specs: Specs) -> None:
    result = hwsw("explore", *specs, "--store", "s", "--certify", "s")
    assert result.exit_code == 2
    assert "--certify" in result.stderr


def test_the_command_imports_no_exploration(explored: Run, tmp_path: Path) -> None:
    script = (
        "import sys\n"
        "from click.testing import CliRunner\n"
        "from codesign.cli import main\n"
        f"result = CliRunner().invoke(main, ['verify-front', {str(tmp_path / 'c')!r}])\n"
        "assert result.exit_code == 0, result.output\n"
        "names = ('exploration', 'scenarios', 'system', 'planners', 'inputs', 'results')\n"
        "print([name for name in names if f'codesign.{name}' in sys.modules])\n"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert ran.stdout == "[]\n"
