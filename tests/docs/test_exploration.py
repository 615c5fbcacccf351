"""The commands of docs/exploration.md are run."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from places import ROOT

from codesign.ground.figures import FIGURES

PAGE = ROOT / "docs" / "exploration.md"


def test_the_front_over_rooms_and_seeds_is_as_the_page_says(tmp_path: Path) -> None:
    import codesign
    from codesign.views.report import front_table, render_text

    page = PAGE.read_text(encoding="utf-8")
    block = re.search(r"^```yaml\n(# seeds\.yaml\n.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert block is not None
    (tmp_path / "seeds.yaml").write_text(block[1], encoding="utf-8")
    platform = codesign.load_platform("virtex4-pci")
    study = codesign.explore(platform, codesign.load_workload(tmp_path / "seeds.yaml"))
    stated = page.partition("```text\nFront\n")[2].partition("```")[0]
    assert render_text(front_table(study)).split() == ["Front", *stated.split()]
    spread = study.designs[1].spread(FIGURES["clearance_mean"])
    assert spread is not None
    assert spread.interval is not None
    assert f"begins at {100 * spread.interval[0]:.2f} %" in " ".join(page.split())


def test_the_study_of_spaces_prints_what_the_page_says(
    hwsw: Callable[..., Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = PAGE.read_text(encoding="utf-8")
    block = re.search(r"^```yaml\n(# spaces\.yaml\n.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert block is not None
    (tmp_path / "spaces.yaml").write_text(block[1], encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    first, reasons, cut = re.findall(r"^```text\n(.*?)^```", page[block.end() :], re.MULTILINE | re.DOTALL)[:3]
    ran = hwsw("explore", "virtex2-pci", "spaces.yaml", "--points", 20, "-q", "--workers", 1, "--store", "cut.sqlite")
    assert ran.stdout.split() == cut.split()
    ran = hwsw("explore", "virtex2-pci", "spaces.yaml", "--workers", 1)
    assert ran.stdout.split() == first.split()
    ran = hwsw("report", "virtex2-pci-spaces.sqlite", "--need", "spread > 0 Hz")
    assert ran.stdout.split()[-len(reasons.split()) :] == reasons.split()


def test_platforms_of_the_page(tmp_path: Path) -> None:
    import codesign

    page = PAGE.read_text(encoding="utf-8")
    (text,) = re.findall(r"```yaml\n(kind: workload\nname: boards\n.*?)```", page, re.S)
    (tmp_path / "boards.yaml").write_text(text, encoding="utf-8")
    for name in ("hall.txt", "yard.txt"):
        (tmp_path / name).write_text(f"{'.' * 28}\n" * 20, encoding="utf-8")
    study = codesign.explore(None, codesign.load_workload(tmp_path / "boards.yaml"))
    assert (len(study.points), study.failed) == (32, ())
    rows = [f"| {reason.kind} | {reason.name} | {reason.designs} |" for reason in study.reasons]
    assert re.findall(r"^\| mapping \| .*\|$", page, re.M) == rows


def test_the_needs_of_the_page_are_met_and_missed_as_it_says(hwsw: Callable[..., Result]) -> None:
    page = PAGE.read_text(encoding="utf-8")
    command, *lines = next(
        block for block in re.findall(r"^```text\n\$ hwsw run (.*?)^```", page, re.M | re.S) if "--need" in block
    ).splitlines()
    done = hwsw("run", *shlex.split(command))
    assert done.exit_code == 3
    assert len(lines) == 5
    assert set(lines) - {"..."} <= set(done.stdout.splitlines())
