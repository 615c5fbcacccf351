"""Relaxation: the bit-plane engine against plain integers, and the facts of the method as properties."""

from __future__ import annotations

import itertools
import pickle
import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from codesign.errors import InputError, MapError, RunError
from codesign.planners.harmonic import Field, StageEnd, VisitBatch, relax, stage_cost, work
from codesign.planners.harmonic.arguments import check_arguments
from codesign.planners.harmonic.engine import Engine
from codesign.planners.harmonic.reference import relax_reference, relax_stage

quick = settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))


@st.composite
def problems(draw: st.DrawFn, most_bits: int = 300, with_start: bool = False) -> dict[str, Any]:
    """A small map, sometimes wider or taller than a word, and all that relax takes besides."""
    rows, columns = draw(
        st.one_of(
            st.tuples(st.integers(1, 11), st.integers(1, 11)),
            st.sampled_from([(2, 70), (70, 2), (3, 130), (65, 3), (17, 9)]),
        )
    )
    generator = np.random.default_rng(draw(st.integers(0, 2**32)))
    free = generator.random((rows, columns)) >= draw(st.sampled_from([0.0, 0.15, 0.4]))
    goal = (int(generator.integers(rows)), int(generator.integers(columns)))
    free[goal] = True
    cells = np.argwhere(free)
    more = cells[generator.integers(len(cells), size=draw(st.integers(0, 2)))]
    # Wide first stages on long maps take the reference too long.
    bits = most_bits if rows * columns < 40 else min(most_bits, 40)
    schedule = sorted(draw(st.sets(st.integers(1, bits), min_size=1, max_size=3)))
    start = None
    if with_start:
        highest = 1 << schedule[0]
        start = np.array(
            [[draw(st.integers(0, highest)) for _ in range(columns)] for _ in range(rows)], object
        )
    return {
        "free": free,
        "goals": [goal, *map(tuple, more.tolist())],
        "block": (draw(st.integers(1, rows)), draw(st.integers(1, columns))),
        "iterations": draw(st.sampled_from([1, 2, 3, 4, 5, 8, 9, 40])),
        "schedule": schedule,
        "termination": draw(st.sampled_from(["sound", "published"])),
        "start": start,
    }


def outcome(items: Any) -> tuple[Any, ...]:
    """All that a run says: stages, fields at their ends, and every visit."""
    ends, visits = [], []
    for item in items:
        if isinstance(item, StageEnd):
            ends.append((item.stage_index, item.stage, item.field.digest()))
        else:
            assert item.block.dtype == item.iterations.dtype == np.int32
            visits += [
                (item.stage_index, item.precision, *visit)
                for visit in zip(item.block.tolist(), item.iterations.tolist(), strict=True)
            ]
    return ends, visits


def engine_items(problem: dict[str, Any], **policy: Any) -> Any:
    arguments = check_arguments(**problem)
    engine = Engine(arguments, **policy)
    for index, precision in enumerate(arguments.schedule):
        yield from engine.run(index, precision)


def reference_items(problem: dict[str, Any]) -> Any:
    arguments = check_arguments(**problem)
    field = arguments.start
    for index, precision in enumerate(arguments.schedule):
        for item in relax_stage(arguments, index, field.shifted(precision)):
            if isinstance(item, StageEnd):
                field = item.field
            yield item


@quick
@given(problems())
def test_engine_is_the_reference(problem: dict[str, Any]) -> None:
    expected = outcome(reference_items(problem))
    assert outcome(work(**problem)) == expected


@quick
@given(problems(most_bits=70), st.booleans(), st.sampled_from([1, 3, 48]), st.sampled_from([1, 40, 1 << 25]))
def test_storage_and_interruptions_change_nothing(
    problem: dict[str, Any], transposed: bool, spare: int, budget: int
) -> None:
    expected = outcome(reference_items(problem))
    items = engine_items(problem, transposed=transposed, spare_planes=spare, budget=budget)
    assert outcome(items) == expected


@quick
@given(
    problems(most_bits=90, with_start=True),
    st.booleans(),
    st.sampled_from([1, 48]),
    st.sampled_from([1, 1 << 25]),
)
def test_any_start(problem: dict[str, Any], transposed: bool, spare: int, budget: int) -> None:
    policy = {"transposed": transposed, "spare_planes": spare, "budget": budget}
    try:
        actual = outcome(engine_items(problem, **policy))
    except RunError:
        # The reference must not end either: many sweeps, and the same field comes back.
        arguments = check_arguments(**problem)
        field, sweeps = arguments.start, 0
        for index, precision in enumerate(arguments.schedule):
            for item in itertools.islice(relax_stage(arguments, index, field.shifted(precision)), 3000):
                sweeps += 1
                if isinstance(item, StageEnd):
                    field, sweeps = item.field, 0
            if sweeps:
                break
        assert sweeps == 3000
    else:
        assert actual == outcome(reference_items(problem))


def test_relax_collects_what_work_yields() -> None:
    generator = np.random.default_rng(5)
    problem = {
        "free": generator.random((20, 30)) > 0.2,
        "goals": [(4, 4)],
        "block": (7, 9),
        "iterations": 5,
        "schedule": [6, 11, 70],
    }
    problem["free"][4, 4] = True
    result = relax(**problem)
    reference = relax_reference(**problem)
    assert result.stages == reference.stages
    assert result.field == reference.field
    assert (result.values == reference.values).all()
    assert all(type(value) is int for value in result.values.flat)
    for name in ("stage", "block", "iterations"):
        assert np.array_equal(getattr(result.visits, name), getattr(reference.visits, name))
    assert result.precision == 70
    assert result.total_iterations == int(result.visits.iterations.sum())
    assert result.total_visits == len(result.visits.block) == result.total_sweeps * 3 * 4
    assert result.total_cycles == sum(stage.iterations * (stage.precision + 2) for stage in result.stages)
    assert result.reachable[4, 4]
    assert not result.reachable[~problem["free"]].any()
    assert relax(**problem, record_visits=False).visits is None


def test_a_stage_ends_with_a_sweep_of_single_iterations() -> None:
    result = relax(np.ones((9, 9), bool), [(4, 4)], block=(4, 4), iterations=6, schedule=[12])
    assert (result.visits.iterations[-9:] == 1).all()
    assert (result.visits.iterations[-18:-9] > 1).any()


# --- the facts of the method -------------------------------------------------------------------------------------


def random_map(seed: int, rows: int, columns: int, share: float) -> np.ndarray:
    free = np.random.default_rng(seed).random((rows, columns)) >= share
    free[0, 0] = True
    return free


@quick
@given(problems(most_bits=40))
def test_values_never_fall_from_zero(problem: dict[str, Any]) -> None:
    arguments = check_arguments(**problem)
    earlier = arguments.start
    for item in work(**problem):
        if isinstance(item, StageEnd):
            assert (item.field.to_ints() >= earlier.shifted(item.field.precision).to_ints()).all()
            earlier = item.field


@quick
@given(st.integers(0, 1000), st.data())
def test_partition_iterations_and_schedule_cannot_change_the_answer(seed: int, data: st.DataObject) -> None:
    free = random_map(seed, 23, 70, 0.25)
    expected = relax(free, [(0, 0)], block=(23, 70), iterations=50, schedule=[45])
    block = (data.draw(st.integers(1, 23)), data.draw(st.integers(1, 70)))
    schedule = [*sorted(data.draw(st.sets(st.integers(1, 44), max_size=4))), 45]
    iterations = data.draw(st.integers(1, 80))
    result = relax(free, [(0, 0)], block=block, iterations=iterations, schedule=schedule)
    assert result.field == expected.field
    assert result.local_maxima == expected.local_maxima


@quick
@given(st.integers(0, 1000), st.sampled_from(["sound", "published"]), st.integers(1, 30))
def test_any_start_below_the_answer_ends_there(seed: int, termination: str, iterations: int) -> None:
    free = random_map(seed, 12, 14, 0.2)
    final = relax(free, [(0, 0)], block=(12, 14), iterations=30, schedule=[33]).values
    generator = random.Random(seed)
    start = np.array([[generator.randint(0, int(value)) for value in row] for row in final], object)
    stage = relax(
        free,
        [(0, 0)],
        block=(5, 6),
        iterations=iterations,
        schedule=[33],
        start=start,
        termination=termination,
    )
    if termination == "sound":
        assert (stage.values == final).all()
    else:
        assert (stage.values <= final).all()


def maze(side: int, seed: int) -> np.ndarray:
    """A perfect maze with corridors and walls one cell wide."""
    generator, free = random.Random(seed), np.zeros((side, side), bool)
    stack = [(1, 1)]
    free[1, 1] = True
    while stack:
        row, column = stack[-1]
        ways = [
            (row + 2 * i, column + 2 * j, row + i, column + j)
            for i, j in ((0, 1), (1, 0), (0, -1), (-1, 0))
            if 0 < row + 2 * i < side and 0 < column + 2 * j < side and not free[row + 2 * i, column + 2 * j]
        ]
        if not ways:
            stack.pop()
            continue
        next_row, next_column, wall_row, wall_column = generator.choice(ways)
        free[wall_row, wall_column] = free[next_row, next_column] = True
        stack.append((next_row, next_column))
    return free


@pytest.mark.parametrize("run", [relax, relax_reference])
def test_the_published_test_ends_a_stage_early_with_27_wrong_cells(run: Any) -> None:
    free = maze(51, seed=2)
    problem = {"block": (17, 17), "iterations": 64, "schedule": [32]}
    sound = run(free, [(25, 25)], termination="sound", **problem)
    published = run(free, [(25, 25)], termination="published", **problem)
    assert (published.values <= sound.values).all()
    assert int((published.values != sound.values).sum()) == 27
    assert (sound.total_iterations, published.total_iterations) == (154, 48)
    assert sound.field == relax(free, [(25, 25)], block=(51, 51), iterations=9, schedule=[8, 32]).field


@pytest.mark.parametrize("precision", [8, 63, 64, 1023])
def test_corridor_against_its_closed_form(precision: int) -> None:
    # Between walls u(k - 1) + u(k + 1) = 4 u(k), so u(k) = a(n - k) / a(n) with a(0) = 0, a(1) = 1, a(k + 1) =
    # 4 a(k) - a(k - 1). Floors cost at most w = w / 2 + 1, so less than 2 units.
    length = 20
    a = [0, 1]
    while len(a) <= length:
        a.append(4 * a[-1] - a[-2])
    result = relax(np.ones((1, length), bool), [(0, 0)], block=(1, 6), iterations=7, schedule=[precision])
    for column, value in enumerate(result.values[0]):
        exact = Fraction(a[length - column], a[length]) * (1 << precision)
        assert 0 <= exact - value < 2


def test_goals_on_all_sides() -> None:
    free = np.ones((3, 3), bool)
    for count in range(1, 5):
        goals = [(0, 1), (2, 1), (1, 0), (1, 2)][:count]
        only = free.copy()
        only[0, 0] = only[0, 2] = only[2, 0] = only[2, 2] = False
        for goal in [(0, 1), (2, 1), (1, 0), (1, 2)][count:]:
            only[goal] = False
        assert relax(only, goals, block=(2, 2), iterations=1, schedule=[1]).values[1, 1] == count * 2 // 4


def test_a_start_that_never_settles_is_told() -> None:
    # Goals all around, and a chessboard that changes sides at every iteration.
    free = np.ones((8, 8), bool)
    goals = [(row, column) for row in range(8) for column in range(8) if row in (0, 7) or column in (0, 7)]
    start = np.add.outer(np.arange(8), np.arange(8)) % 2 + 15
    with pytest.raises(RunError, match="never settle") as caught:
        relax(free, goals, block=(8, 8), iterations=9, schedule=[4], start=start)
    assert pickle.loads(pickle.dumps(caught.value)).hint == caught.value.hint


# --- the interface -----------------------------------------------------------------------------------------------


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


@quick
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
        ({"goals": [(4, 0)]}, MapError, r"goal \(4, 0\) is outside the map of 4 × 6"),
        ({"goals": [(-1, 0)]}, MapError, "outside"),
        ({"goals": [(1, 1)]}, MapError, r"goal \(1, 1\) is on an obstacle"),
        ({"goals": [(0, 0.5)]}, InputError, "0.5 is not a whole number"),
        ({"goals": [3]}, MapError, "not a .row, column. pair"),
        ({"goals": 3}, MapError, "not a list"),
        ({"block": (5, 6)}, InputError, "block of 5 × 6 nodes is larger than the map of 4 × 6"),
        ({"block": (0, 6)}, InputError, "no nodes"),
        ({"block": 7}, InputError, "pair"),
        (
            {"free": np.ones((1024, 512), bool), "block": (1, 1)},
            InputError,
            "524288 blocks of 1 × 1 nodes are more",
        ),
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


def test_unreachable_cells_stay_zero_and_count_for_nothing() -> None:
    free = np.ones((3, 9), bool)
    free[:, 4] = False
    result = relax(free, [(1, 1)], block=(3, 4), iterations=5, schedule=[16])
    assert not result.reachable[:, 4:].any()
    assert (result.values[:, 4:] == 0).all()
    assert result.local_maxima == 0
