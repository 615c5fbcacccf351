"""Traces keep the bounds that they promise: the largest map, the longest time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from codesign.errors import TraceError
from codesign.records import StageRecord, TaskRecord
from codesign.trace import McapListener, open_trace


def test_a_potential_of_the_largest_map_is_written_and_read_back(tmp_path: Path) -> None:
    """2^24 float64 cells, as base64 in JSON above the 2^27 bytes that once were the bound."""
    potential = np.zeros((4096, 4096))
    potential[0, 1] = 0.25
    potential[-1, -1] = 1.0
    with McapListener(tmp_path / "large.mcap") as listener:
        listener(TaskRecord(0, "fpga", "load", 5, 1))
        listener(StageRecord(9, "fpga", 0, 0, 7, 1, 1, 1, 1, 0, potential))
    trace = open_trace(tmp_path / "large.mcap")
    assert trace.complete
    _, stage = trace.records()
    assert isinstance(stage, StageRecord)
    assert np.array_equal(stage.potential, potential)


@pytest.mark.parametrize("time", [2**63, 2**64 * 1000, -1])
def test_a_time_that_no_trace_holds_is_refused_with_a_remedy(tmp_path: Path, time: int) -> None:
    with (
        pytest.raises(TraceError, match="no TaskRecord: time") as caught,
        McapListener(tmp_path / "late.mcap") as listener,
    ):
        listener(TaskRecord(time, "fpga", "load", 5, 1))
    assert time < 0 or "shorter run" in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_the_latest_time_that_is_written_is_read_back(tmp_path: Path) -> None:
    """Writer and reader share one bound."""
    record = TaskRecord(2**63 - 1, "fpga", "load", 2**63 - 1, 1)
    with McapListener(tmp_path / "late.mcap") as listener:
        listener(record)
    assert list(open_trace(tmp_path / "late.mcap").records()) == [record]
