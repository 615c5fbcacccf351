"""How much a command prints: -q, -v, --debug, unexpected errors, and a trace that is not written."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

Run = Callable[..., Result]
Specs = tuple[Path, Path]
SMALL = ("--set", "fpga.part=XC3S500E-4", "--set", "fpga.clock=50 MHz", "--set", "relax.block=[24, 36]")


def test_run_leads_with_the_answer_and_keeps_all_tables(hwsw: Run, specs: Specs) -> None:
    plain, quiet, all_of_it = (hwsw("run", *specs, *words).stdout for words in ((), ("-q",), ("-v",)))
    assert quiet == plain.splitlines()[0] + "\n"
    assert quiet.startswith("two-rooms on small-board (harmonic, bit_serial on fpga) ")
    assert plain.count("\n") < 12
    assert all_of_it.startswith(plain)
    for title in ("Design point", "Clock cycles by phase", "Stages", "Plan quality", "Resources", "Clock and power"):
        assert f"\n{title}\n" in all_of_it
        assert f"\n{title}\n" not in plain


def test_the_time_stands_against_the_constraint_of_the_file(hwsw: Run, specs: Specs) -> None:
    limits = "  constraints: [{figure: plan_time_worst_s, at_most: 1 s}, {figure: power, at_most: 1 uW}]\n"
    specs[1].write_text(specs[1].read_text(encoding="utf-8") + limits, encoding="utf-8")
    for words in ((), ("--set", "relax.iterations=1")):
        done = hwsw("run", *specs, "-q", *words)
        assert " where at most 1 s is asked for; " in done.stdout
        assert "fits, but misses what is asked for (FPGA power at most: " in done.stdout
        assert done.exit_code == 0


def test_json_is_the_same_at_any_detail(hwsw: Run, specs: Specs) -> None:
    texts = {hwsw("run", *specs, "--json", *words).stdout for words in ((), ("-q",), ("-v",))}
    assert len(texts) == 1
    assert json.loads(texts.pop())["feasible"] is True


def test_of_quiet_and_verbose_the_last_one_counts(hwsw: Run, specs: Specs) -> None:
    assert hwsw("run", *specs, "-q", "-v").stdout.count("\n") > 50
    assert hwsw("run", *specs, "-v", "-q").stdout.count("\n") == 1


def test_a_trace_of_a_design_that_is_out_is_reported_as_not_written(hwsw: Run, specs: Specs, tmp_path: Path) -> None:
    trace = tmp_path / "no.mcap"
    for words in ((), ("-q",), ("--json",)):
        done = hwsw("run", *specs, *SMALL, "--trace", trace, *words)
        assert done.exit_code == 3
        assert "no.mcap is not written, as the design is not feasible and was not run" in done.stderr
        assert not list(tmp_path.glob("no.mcap*"))
    assert "Why it is not feasible" in hwsw("run", *specs, *SMALL).stdout


def test_the_page_does_not_depend_on_the_detail(hwsw: Run, specs: Specs, tmp_path: Path) -> None:
    hwsw("run", *specs, "--html", tmp_path / "a.html")
    plain = (tmp_path / "a.html").read_text(encoding="utf-8")
    hwsw("run", *specs, "--html", tmp_path / "a.html", "-v", "--debug")
    assert (tmp_path / "a.html").read_text(encoding="utf-8") == plain


def test_debug_prints_the_time_of_each_step(hwsw: Run, specs: Specs) -> None:
    done = hwsw("run", *specs, "--debug", "-q")
    assert done.stdout.count("\n") == 1
    lines = [line for line in done.stderr.splitlines() if line.startswith("debug: ")]
    for step in ("files read and checked", "simulated", "compiled kernels in"):
        assert any(step in line for line in lines), step
    assert "debug" not in hwsw("run", *specs, "-q").stderr


@pytest.mark.parametrize("words", [("run", "--debug"), ("--debug", "run")])
def test_an_unexpected_error_has_a_traceback_only_for_debug(
    specs: Specs, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    from codesign.cli import main
    from codesign.system import scenarios

    def broken(*_arguments: object, **_options: object) -> None:
        raise KeyError("no such thing")

    monkeypatch.setattr(scenarios, "simulate", broken)
    files = [str(each) for each in specs]
    for words_of_one, shows in ((("run",), False), (words, True)):
        done = CliRunner().invoke(main, [*words_of_one, *files])
        assert done.exit_code == 1
        assert "unexpected error, a fault of hwsw: KeyError: 'no such thing'\n  hint: hwsw --debug" in done.stderr
        assert ("Traceback" in done.stderr) == shows


def test_an_exploration_leads_with_its_sentence(hwsw: Run, specs: Specs) -> None:
    pins = [f"--set={axis}" for axis in ("relax.iterations=4", "relax.termination=sound", "relax.schedule=[15, 63]")]
    words = ("explore", *specs, *pins, "--workers", "1", "--store", "kept.sqlite")
    plain, quiet, all_of_it = (hwsw(*words, *more).stdout for more in ((), ("-q",), ("-v",)))
    assert quiet == plain.splitlines()[0] + "\n"
    assert quiet.startswith("two-rooms on small-board, 12 design points: ")
    assert all_of_it.startswith(plain.rpartition("points kept")[0])
    assert "Where the figures come from" in all_of_it
    assert hwsw("report", "kept.sqlite", "-q").stdout == quiet
    assert "12/12" not in hwsw(*words, "-q").stderr


def test_designs_are_compared_in_a_sentence_each(hwsw: Run) -> None:
    design = "virtex4-pci:wavefront-tiles"
    quiet, all_of_it = (hwsw("compare", design, word).stdout for word in ("-q", "-v"))
    assert quiet.count("\n") == 1
    assert all_of_it.startswith("Comparison, asked: task path")
    assert quiet in all_of_it
    assert "\nResources\n" in all_of_it
