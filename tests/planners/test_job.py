"""The one argument of what planners and styles are asked."""

from __future__ import annotations

import pytest

from codesign.ground.memo import Memo
from codesign.inputs import load_part
from codesign.planners.job import Job


def test_every_task_is_inside_unless_some_are_named() -> None:
    assert Job(None, None).does("track")
    assert not Job(None, None, inside=frozenset({"search"})).does("track")


def test_work_is_shared_through_the_memo_alone() -> None:
    computed: list[int] = []

    def compute() -> int:
        computed.append(1)
        return 7

    alone, memo = Job(None, None), Memo()
    together = Job(None, None, memo=memo)
    for job in (alone, alone, together, together):
        assert job.shared(("seven",), compute) == 7
    assert (len(computed), memo.hits) == (3, 1)


def test_a_style_on_an_fpga_has_a_chip() -> None:
    part = load_part("XC2VP30-6")
    assert Job(None, None, part=part).chip is part
    with pytest.raises(AssertionError, match="needs a part"):
        _ = Job(None, None).chip
