"""Budgets of points and of time."""

from __future__ import annotations

import click
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codesign.cli.request import command_of
from codesign.cli.requests import COMMANDS
from codesign.ground.errors import InputError
from codesign.study.budget import Budget


@given(st.lists(st.integers(1, 5), max_size=8), st.integers(1, 30))
def test_a_budget_of_points_is_kept_and_batches_are_whole(sizes: list[int], points: int) -> None:
    batches = [list(range(size)) for size in sizes]
    budget = Budget(points)
    granted = list(budget.within(batches))
    assert granted == batches[: len(granted)]
    assert sum(map(len, granted)) == budget.used <= points
    assert bool(budget.ended) == (len(granted) < len(batches)) == (points < sum(sizes))


def test_a_budget_of_time_begins_nothing_after_it() -> None:
    now = [0.0]
    budget = Budget(seconds=2.5, clock=lambda: now[0])
    begun = []
    for batch in budget.within([[1], [2], [3], [4], [5]]):
        begun.append(batch[0])
        now[0] += 1
    assert begun == [1, 2, 3]
    assert budget.ended == "the time of 2.5 s was over"


def test_what_is_not_asked_for_is_not_drawn() -> None:
    drawn = []

    def batches() -> object:
        for number in range(9):
            drawn.append(number)
            yield [number]

    budget = Budget(points=3)
    assert len(list(budget.within(batches()))) == 3  # type: ignore[type-var,arg-type]
    assert budget.ended == "the budget of 3 points was used up"
    assert drawn == [0, 1, 2, 3]


def test_no_budget_is_all() -> None:
    budget = Budget()
    assert list(budget.within([[1, 2], [3]])) == [[1, 2], [3]]
    assert (budget.ended, budget.left, budget.used) == ("", None, 3)


@pytest.mark.parametrize("wrong", [{"points": 0}, {"points": -1}, {"seconds": 0.0}])
def test_an_empty_budget_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError, match="is none"):
        Budget(**wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("written", "read"),
    [
        (["--points", "20"], (20, None)),
        (["--time", "10min"], (None, 600_000)),
        (["--time", "1.5 s", "--points", "1"], (1, 1500)),
        ([], (None, None)),
        (["--points", "0"], None),
        (["--points", "x"], None),
        (["--time", "10m"], None),
        (["--time", "0 s"], None),
        (["--time", "10"], None),
    ],
)
def test_the_options_of_a_budget(written: list[str], read: tuple[int | None, int | None] | None) -> None:
    explore = command_of("explore", COMMANDS)
    if read is None:
        with pytest.raises((InputError, click.ClickException)):
            explore.make_context("explore", ["labyrinth", *written])
        return
    given = explore.make_context("explore", ["labyrinth", *written]).params
    assert (given["points"], given["time_ms"]) == read
