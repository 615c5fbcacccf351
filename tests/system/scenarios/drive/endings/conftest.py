"""What the tests of endings share: a drive from the command line, and a bound on its wall time."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result as Invoked
from mission_specs import SECOND, Ground

import codesign
from codesign.ground.records import MissionRecord, PoseRecord, SummaryRecord
from codesign.system import Result
from codesign.system.results.mission import Mission
from codesign.system.verdicts import RunDocument

Hwsw = Callable[..., Invoked]
Drives = Callable[..., tuple[Result, Mission]]


@pytest.fixture(autouse=True)
def bounded() -> Iterator[None]:
    """No case takes longer than a minute of wall time: none hangs."""

    def give_up(*_: object) -> None:
        raise TimeoutError("the drive hangs")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def drives(tmp_path: Path, hwsw: Hwsw) -> Drives:
    """Run a drive from the command line, look into its trace, and give its result."""

    def run(placement: str = "breadth-first", **settings: Any) -> tuple[Result, Mission]:
        files = Ground(tmp_path).files(placement, **settings)
        trace = tmp_path / "drive.mcap"
        done = hwsw("run", *files, "--trace", trace, "--no-levers", "--json")
        assert done.exit_code == 0, done.output[:500]
        result = RunDocument.model_validate(json.loads(done.stdout))
        mission = result.mission
        assert mission is not None
        assert mission.ended
        opened = codesign.open_trace(trace)
        assert opened.complete
        records = list(opened.records())
        (summary,) = [record for record in records if isinstance(record, SummaryRecord)]
        beside = {"provenance", "intervals", "fit"}
        printed = {key: value for key, value in result.model_dump(mode="json").items() if key not in beside}
        assert {key: value for key, value in summary.result.items() if key not in beside} == printed
        end = round(mission.mission_time_s * SECOND)
        assert summary.time == max(record.time for record in records) == end
        last = [record for record in records if isinstance(record, MissionRecord)][-1]
        assert (last.time, last.event, last.text) == (end, "ended", mission.ended)
        poses = [record for record in records if isinstance(record, PoseRecord)]
        assert len(poses) in {mission.turns, mission.turns + 1}
        return result, mission

    return run


# No way
