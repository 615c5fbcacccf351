"""docs/traces.md: its Python reads the trace of a plan and that of a mission."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

from click.testing import Result
from mission_specs import Ground
from places import ROOT

import codesign
from codesign.ground.records import MissionRecord

Run = Callable[..., Result]

PAGE = ROOT / "docs" / "traces.md"


def read_as_the_page_does() -> list[str]:
    """What its snippet prints of ``run.mcap`` in the current folder."""
    (snippet,) = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)
    printed = StringIO()
    with redirect_stdout(printed):
        exec(compile(snippet, "traces.md", "exec"), {})
    return printed.getvalue().splitlines()


def test_the_snippet_reads_the_trace_of_a_plan(hwsw: Run, specs: tuple[Path, Path]) -> None:
    told = json.loads(hwsw("run", *specs, "--trace", "run.mcap", "--json").stdout)
    *stages, last = read_as_the_page_does()
    assert stages[::2] == [f"{stage['precision']} {stage['cycles']}" for stage in told["stages"]]
    assert all(0 < float(greatest) <= 1 for greatest in stages[1::2])
    assert last.startswith("True {")


def test_the_snippet_reads_the_trace_of_a_mission(hwsw: Run, tmp_path: Path) -> None:
    """Its stages are without their potentials."""
    point = Ground(tmp_path).point("harmonic", limit="1 s", patience="1 s")
    result = codesign.simulate(*point, trace=tmp_path / "run.mcap")
    assert result.mission is not None
    *stages, last = read_as_the_page_does()
    assert stages
    assert all(re.fullmatch(r"\d+ \d+", line) for line in stages)
    assert last.startswith("True {")


def test_how_long_a_plan_took_is_told_in_a_unit_that_suits(tmp_path: Path) -> None:
    result, records = Ground(tmp_path).watched("harmonic", limit="1 s", patience="1 s")
    assert result.mission is not None
    texts = [each.text for each in records if isinstance(each, MissionRecord) and each.event == "plan_ready"]
    assert len(texts) == result.mission.plans > 0
    assert all(re.search(r": answered after \d{1,4}(\.\d{1,4})? (us|ms)$", text) for text in texts)
