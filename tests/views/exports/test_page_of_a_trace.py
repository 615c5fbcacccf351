"""The page of a run, made of its trace."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from page_data import Page
from report_samples import a_result
from runs_over_time import SECOND, a_drive, a_fleet, a_plan
from trace_samples import write

from codesign.cli import main
from codesign.ground.records import Record, SummaryRecord
from codesign.views.report.result_page import scrub_data
from codesign.views.report.scrub import SCRUB_KINDS, scrub_of
from codesign.views.trace import open_trace


@pytest.mark.parametrize("records", [a_drive(), a_fleet(8), a_plan()], ids=["drive", "fleet", "plan"])
def test_a_trace_shows_what_the_records_in_memory_show(tmp_path: Path, records: list[Record]) -> None:
    path = write(tmp_path / "run.mcap", sorted(records, key=lambda record: record.time))
    read, kept = (scrub_of(each) for each in (open_trace(path).records(kinds=SCRUB_KINDS), records))
    assert read is not None
    assert kept is not None
    assert scrub_data(read) == scrub_data(kept)


def export(path: Path, page: Path) -> str:
    done = CliRunner().invoke(main, ["trace", "export", str(path), "--html", str(page)])
    assert done.exit_code == 0, done.output
    return page.read_text(encoding="utf-8")


def test_the_page_has_the_result_of_the_trace_and_its_course(tmp_path: Path) -> None:
    result = a_result().model_dump(mode="json")
    path = write(tmp_path / "run.mcap", [*a_drive(), SummaryRecord(20 * SECOND, "result", result)])
    html = export(path, tmp_path / "page.html")
    text = Page(html).text
    assert "labyrinth on virtex2-pci" in text
    assert '<canvas id="stage"' in html
    assert f"hwsw trace export {path} --html" in text


def test_the_page_of_a_cut_trace_has_its_course_alone(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", a_drive())
    whole = path.read_bytes()
    seen = set()
    for percent in range(0, 100, 14):
        cut, page = tmp_path / "cut.mcap", tmp_path / "page.html"
        cut.write_bytes(whole[: len(whole) * percent // 100])
        page.unlink(missing_ok=True)
        done = CliRunner().invoke(main, ["trace", "export", str(cut), "--html", str(page)])
        assert done.exit_code in (0, 1, 2), done.output
        assert done.exception is None or isinstance(done.exception, SystemExit)
        assert page.exists() == (done.exit_code == 0)
        seen.add(page.exists())
    assert True in seen


def test_a_result_of_another_version_is_left_out(tmp_path: Path) -> None:
    summary = SummaryRecord(20 * SECOND, "result", {"schema_version": 99, "<b>": 1})
    html = export(write(tmp_path / "run.mcap", [*a_drive(), summary]), tmp_path / "page.html")
    assert "run.mcap" in Page(html).text
    data = re.search(r'<script type="application/json" id="run-data">(.*?)</script>', html, re.S)
    assert data is not None
    assert json.loads(data[1])["end"] > 0


def test_a_page_overwrites_no_trace(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", a_drive())
    before = path.read_bytes()
    assert CliRunner().invoke(main, ["trace", "export", str(path), "--html", str(path)]).exit_code == 2
    assert path.read_bytes() == before
