"""Exit code 3 is "the answer is no" in every command that judges; the table in docs/spec.md has every command."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import click
import pytest
from click.testing import Result

from codesign.cli import main
from codesign.study.advice.certificate import Certificate

Run = Callable[..., Result]
Specs = tuple[Path, Path]
PAGE = Path(__file__).parents[2] / "docs" / "spec.md"


def rows() -> list[tuple[list[str], str]]:
    table = PAGE.read_text(encoding="utf-8").partition("| command | 3 means |\n|---|---|\n")[2].partition("\n\n")[0]
    cells = [line.strip("|").split(" | ") for line in table.splitlines()]
    return [(re.findall(r"`([^`]+)`", commands), meaning) for commands, meaning in cells]


JUDGING = {name for names, meaning in rows() if not meaning.startswith("never") for name in names}
OTHERS = {name for names, meaning in rows() if meaning.startswith("never") for name in names}


def commands(group: click.Group = main, before: str = "") -> Iterator[tuple[str, click.Command]]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        if isinstance(command, click.Group):
            yield from commands(command, f"{before}{name} ")
        else:
            yield f"{before}{name}", command


def test_the_table_has_every_command_and_its_help_says_the_same() -> None:
    found = dict(commands())
    assert {*found} >= JUDGING
    assert {name.partition(" ")[0] for name in {*found} - JUDGING} | {"trace"} == OTHERS
    for name, command in found.items():
        says = " ".join((command.help or "").split())
        assert ("xit code is 3" in says or "and 3 where" in says) is (name in JUDGING), name


@pytest.fixture
def answered(hwsw: Run, specs: Specs, corridor: Path) -> dict[str, tuple[list[object], list[object]]]:
    """For each command that judges, words of a question whose answer is yes, and of one whose answer is no."""
    never, always = ("--need", "time < 1 ps"), ("--need", "time < 1 h")
    small = ("--set", "relax.block=[24, 36]", "--set", "fpga.part=XC3S500E-4")
    assert hwsw("explore", *specs, "--workers", 1, "--store", "s", "--certify", "c").exit_code == 0
    assert hwsw("report", "s", *never, "--certify", "none").exit_code == 3
    for name, more in (("one", ()), ("other", ("--set", "relax.iterations=1"))):
        assert hwsw("run", *specs, *more, "--trace", f"{name}.mcap").exit_code == 0
    pair = "virtex4-pci:labyrinth"
    place = ("advise", corridor, "--goal", "0,0", "--start", "0,9", "--boards", "zynq", "--rate")
    assert hwsw(*place, "1 Hz", "--certify", "a").exit_code == 0
    content = json.loads(Path("a").read_text(encoding="utf-8"))
    content["winner"]["time_s"] = 100.0
    certificate = Certificate.model_validate(content)
    changed = certificate.model_copy(update={"digest": certificate.content})
    Path("changed").write_text(changed.model_dump_json(), encoding="utf-8")
    host = ("advise", corridor, "--goal", "0,0", "--start", "0,9", "--boards", "raspberry-pi-4", "--rate", "1 Hz")
    assert hwsw(*host, "--write", "design").exit_code == 0
    design = "raspberry-pi-4", "design/raspberry-pi-4.yaml"
    time = json.loads(hwsw("run", *design, "--json").stdout)["task"]["plan_time_worst_s"]
    for name, seconds in (("inside", time), ("outside", 10 * time)):
        took = f"time_of_a_plan: {{median: {seconds} s, p99: {seconds} s}}"
        of = f"platform: {design[0]}\nworkload: {design[1]}"
        Path(f"{name}.yaml").write_text(f"kind: measured\n{of}\ndate: 2026-11-20\nruns: 100\n{took}\n")
    unfit = hwsw("report", "s", "--json").stdout
    index = next(i for i, text in enumerate(unfit.split('"feasible": ')[1:]) if text.startswith("false"))
    best = next(i for i, text in enumerate(unfit.split('"feasible": ')[1:]) if text.startswith("true"))
    return {
        "run": (["run", *specs], ["run", *specs, *never]),
        "explore": (["explore", *specs, "--store", "s"], ["explore", *specs, "--store", "t", *never]),
        "report": (["report", "s", *always], ["report", "s", *never]),
        "explain": (["explain", "s", best], ["explain", "s", index]),
        "explain of a run": (["explain", *specs], ["explain", *specs, *small]),
        "compare": (["compare", pair, pair, *always], ["compare", pair, pair, *never]),
        "advise": ([*place, "1 Hz"], [*place, "1 Hz", "--power", "1 mW"]),
        "measured": (["measured", "inside.yaml"], ["measured", "outside.yaml"]),
        "verify-advice": (["verify-advice", "a"], ["verify-advice", "changed"]),
        "verify-front": (["verify-front", "c"], ["verify-front", "none", "--store", "s"]),
        "trace diff": (["trace", "diff", "one.mcap", "one.mcap"], ["trace", "diff", "one.mcap", "other.mcap"]),
    }


@pytest.fixture
def corridor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "corridor.txt").write_text("." * 10 + "\n", encoding="utf-8")
    return tmp_path / "corridor.txt"


def test_no_is_3_and_is_told_as_yes_is(hwsw: Run, answered: dict[str, tuple[list[object], list[object]]]) -> None:
    # Circuits differ in rtl/test_verify.py.
    assert {name.partition(" of ")[0] for name in answered} == JUDGING - {"verify"}
    for name, words in answered.items():
        for code, asked in zip((0, 3), words, strict=True):
            result = hwsw(*asked)
            assert (name, result.exit_code) == (name, code), result.output
            assert "Traceback" not in result.output
            assert result.stdout or result.stderr
