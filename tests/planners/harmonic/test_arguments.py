"""What the relaxation takes and gives: stages, their costs, batches, fields, and arguments that cannot be used."""

from __future__ import annotations

import pickle
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.ground.errors import InputError, MapError
from codesign.planners.harmonic.plan import Field, VisitBatch, relax, stage_cost, work


def random_map(seed: int, rows: int, columns: int, share: float) -> np.ndarray:
    free = np.random.default_rng(seed).random((rows, columns)) >= share
    free[0, 0] = True
    return free


def test_stages_may_end_at_the_first_without_local_maxima() -> None:
    free, goals = random_map(3, 10, 10, 0.1), [(0, 0)]
    schedule = list(range(2, 60, 3))
    whole = relax(free, goals, block=(5, 5), iterations=4, schedule=schedule)
    early = relax(free, goals, block=(5, 5), iterations=4, schedule=schedule, stop_without_local_maxima=True)
    count = next(i for i, stage in enumerate(whole.stages) if stage.local_maxima == 0) + 1
    assert 1 < count < len(schedule)
    assert early.stages == whole.stages[:count]


def test_stage_costs_add_up_over_endpoints() -> None:
    free, goals = random_map(8, 30, 20, 0.2), [(0, 0)]
    settings_ = {"block": (11, 7), "iterations": 5}
    whole = relax(free, goals, schedule=[5, 9, 33], **settings_)
    field = None
    for stage in whole.stages:
        cost, field = stage_cost(free, goals, field, stage.precision, **settings_)
        assert cost == stage
    assert field == whole.field


def test_work_is_bounded_and_may_be_abandoned() -> None:
    items = work(np.ones((40, 40), bool), [(0, 0)], block=(1, 1), iterations=1, schedule=[20])
    first = next(items)
    assert isinstance(first, VisitBatch)
    assert len(first.block) <= 1 << 14
    items.close()
    with pytest.raises(InputError):
        work(np.ones((4, 4), bool), [(0, 0)], block=(1, 1), iterations=0, schedule=[20])


@st.composite
def integers_and_precision(draw: st.DrawFn) -> tuple[np.ndarray, int]:
    precision = draw(st.integers(1, 200))
    values = draw(st.lists(st.integers(0, 1 << precision), min_size=6, max_size=6))
    return np.array(values, object).reshape(2, 3), precision


@settings(max_examples=60)
@given(integers_and_precision(), st.integers(0, 150))
def test_field_holds_integers_exactly(given_: tuple[np.ndarray, int], more: int) -> None:
    values, precision = given_
    field = Field.from_ints(values, precision)
    assert (field.to_ints() == values).all()
    raised = field.shifted(precision + more)
    assert (raised.to_ints() == values << more).all()
    assert (raised == field) == (more == 0) == (raised.digest() == field.digest())
    assert pickle.loads(pickle.dumps(field)) == field
    exact = [[Fraction(value, 1 << precision) for value in row] for row in values]
    assert np.allclose(field.to_float(), np.array(exact, float), rtol=1e-15, atol=0)
    assert not field.limbs.flags.writeable


FREE = np.ones((4, 6), bool)


@pytest.mark.parametrize(
    ("change", "kind", "words"),
    [
        ({"free": np.ones((0, 5), bool)}, MapError, "empty"),
        ({"free": np.ones(5, bool)}, MapError, "1 dimensions"),
        ({"free": np.full((4, 6), 2)}, MapError, "not bool"),
        ({"free": np.ones((4, 6))}, MapError, "not bool"),
        ({"free": np.broadcast_to(True, (32000, 32000))}, MapError, "32000 × 32000 cells, more than"),
        ({"goals": []}, MapError, "no goal"),
        ({"goals": [(4, 0)]}, MapError, r"goal \(4, 0\) is outside of the map of 4 × 6 cells\n  hint: \(row"),
        ({"goals": [(-1, 0)]}, MapError, "outside"),
        ({"goals": [(1, 1)]}, MapError, r"goal \(1, 1\) is on an obstacle"),
        ({"goals": [(0, 0.5)]}, InputError, "0.5 is not a whole number"),
        ({"goals": [3]}, MapError, "not a .row, column. pair"),
        ({"goals": 3}, MapError, "not a list"),
        ({"block": (0, 6)}, InputError, "no nodes"),
        ({"block": 7}, InputError, "pair"),
        ({"free": np.ones((1024, 512), bool), "block": (1, 1)}, InputError, "524288 blocks of 1 × 1 nodes are more"),
        ({"iterations": 0}, InputError, "0 iterations"),
        ({"iterations": 1 << 31}, InputError, "outside"),
        ({"iterations": 2.5}, InputError, "whole number"),
        ({"schedule": []}, InputError, "empty"),
        ({"schedule": [8, 8]}, InputError, "precision 8 follows 8"),
        ({"schedule": [9, 8]}, InputError, "precision 8 follows 9"),
        ({"schedule": [0]}, InputError, "outside 1..1023"),
        ({"schedule": [1024]}, InputError, "outside 1..1023"),
        ({"schedule": 8}, InputError, "list"),
        ({"termination": "sond"}, InputError, "did you mean sound"),
        ({"start": np.zeros((4, 5), int)}, InputError, "start"),
        ({"start": np.full((4, 6), 257)}, InputError, "value 257 is outside"),
        ({"start": np.full((4, 6), -1)}, InputError, "value -1 is outside"),
        ({"start": np.zeros((4, 6))}, InputError, "not integers"),
        ({"start": Field(np.zeros((4, 6, 1), np.uint64), 9)}, InputError, "below"),
    ],
)
def test_what_cannot_be_used_is_told(change: dict[str, Any], kind: type[InputError], words: str) -> None:
    free = FREE.copy()
    free[1, 1] = False
    given_ = {"free": free, "goals": [(0, 0)], "block": (2, 3), "iterations": 3, "schedule": [8]} | change
    with pytest.raises(kind, match=words) as caught:
        relax(**given_)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_friendly_forms_are_taken() -> None:
    expected = relax(FREE, [(0, 0)], block=(2, 3), iterations=3, schedule=[8]).field
    given_ = np.ones((4, 6), np.uint8), np.array([[0, 0], [0, 0]])
    result = relax(*given_, block=np.array([2, 3]), iterations=np.int64(3), schedule=range(8, 9))
    assert result.field == expected
    assert relax(FREE, [(0, 0)], block=(2, 3), iterations=3, schedule=[8], start=expected).field == expected


def test_pockets_stay_zero_and_are_local_maxima_for_ever() -> None:
    free = np.ones((3, 9), bool)
    free[:, 4] = False
    result = relax(free, [(1, 1)], block=(3, 4), iterations=5, schedule=[16])
    assert not result.reachable[:, 4:].any()
    assert (result.values[:, 4:] == 0).all()
    assert result.local_maxima == 3 * 4
