"""Relaxation: the bit-plane engine against plain integers, and the facts of the method as properties."""

from __future__ import annotations

import hashlib
import itertools
import os
import pickle
import random
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from reference_harmonic import relax_reference, relax_stage

from codesign.ground.errors import RunError
from codesign.planners.harmonic.plan import StageEnd, kernels, relax, work
from codesign.planners.harmonic.plan.arguments import check_arguments
from codesign.planners.harmonic.plan.engine import Engine
from codesign.planners.harmonic.plan.layout import make_layout, segment_words

quick = settings(max_examples=examples(60), suppress_health_check=list(HealthCheck))


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
        start = np.array([[draw(st.integers(0, highest)) for _ in range(columns)] for _ in range(rows)], object)
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
@given(problems(most_bits=90, with_start=True), st.booleans(), st.sampled_from([1, 48]), st.sampled_from([1, 1 << 25]))
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


# Rows of 1 to 8 bytes, that end in the middle of a word or not, one to several segments of groups, one to three words.
SHAPES = [
    (40, 7),
    (40, 15),
    (52, 20),
    (40, 30),
    (70, 37),
    (33, 44),
    (34, 50),
    (90, 61),
    (110, 61),
    (40, 64),
    (70, 66),
    (36, 130),
]


@settings(max_examples=40, suppress_health_check=list(HealthCheck))
@given(
    st.sampled_from(SHAPES),
    st.integers(0, 2**32),
    st.sampled_from([1, 2, 3]),
    st.sampled_from([1, 5, 6, 7, 13, 40]),
    st.sampled_from([[4], [3, 8], [1, 14]]),
    st.booleans(),
    st.booleans(),
)
def test_rows_of_any_length_are_the_reference(
    shape: tuple[int, int], seed: int, parts: int, iterations: int, schedule: list[int], high: bool, transposed: bool
) -> None:
    generator = np.random.default_rng(seed)
    free = generator.random(shape) >= 0.2
    goal = (int(generator.integers(shape[0])), int(generator.integers(shape[1])))
    free[goal] = True
    problem = {
        "free": free,
        "goals": [goal],
        "block": (-(-shape[0] // parts), shape[1]),
        "iterations": iterations,
        "schedule": schedule,
        "termination": "sound",
        # Values that fall as well as rise: r has a sign.
        "start": np.where(free, 1 << schedule[0], 0) if high else None,
    }
    expected = outcome(reference_items(problem))
    assert outcome(engine_items(problem, transposed=transposed)) == expected


def test_rows_take_as_few_bytes_as_they_need() -> None:
    # One shape at least for each distance from row to row, so that the test above covers all of them.
    layouts = [make_layout(shape, shape, 1) for shape in SHAPES]
    assert {layout.pitch for layout in layouts} == {1, 2, 3, 4, 5, 6, 7, 8}
    assert {layout.columns for layout in layouts} == {1, 2, 3}
    assert {layout.each for layout in layouts} >= {1, 2, 3}
    for layout in layouts:
        assert layout.columns > 1 or layout.pitch * 8 > layout.block_columns or layout.block_columns == 64
        begin, end = segment_words(layout)
        assert (begin < end).all()
        assert sum(end - begin) == layout.columns * layout.words


ON_ANY_PROCESSOR = """
import numpy as np
from numba import njit
from codesign.planners.harmonic.plan.lanes import load, majority, shift_down, shift_up, store

@njit
def compute(a, b, c, out):
    x, y, z = load(a, 0), load(b, 0), load(c, 0)
    store(out, 0, majority(x, y, z))
    store(out, 8, shift_up(x, y))
    store(out, 16, shift_down(x, y))

words = np.random.default_rng(7).integers(0, 1 << 64, (3, 8), dtype=np.uint64)
out = np.zeros(24, np.uint64)
compute(*(array.ctypes.data for array in words), out.ctypes.data)
x, y, z = words
one, most = np.uint64(1), np.uint64(63)
assert (out[:8] == x & y | x & z | y & z).all()
assert (out[8:16] == x << one | y >> most).all()
assert (out[16:] == y >> one | x << most).all()
print("the same")
"""


@pytest.mark.parametrize("processor", ["", "generic"])
def test_lanes_are_the_same_on_any_processor(processor: str) -> None:
    # Where there are 512-bit registers the majority is one instruction, elsewhere it is made of several.
    environment = os.environ | ({"NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": ""} if processor else {})
    done = subprocess.run(
        [sys.executable, "-c", ON_ANY_PROCESSOR],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "the same\n", "")


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
    assert (
        sum(stage.visits for stage in result.stages)
        == len(result.visits.block)
        == sum(stage.sweeps for stage in result.stages) * 3 * 4
    )
    assert result.total_cycles == sum(stage.iterations * (stage.precision + 2) for stage in result.stages)
    assert result.reachable[4, 4]
    assert not result.reachable[~problem["free"]].any()
    assert relax(**problem, record_visits=False).visits is None


def test_numba_compiles_anew_after_an_edit_of_what_the_kernels_call() -> None:
    # Its cache looks at the file of the function that is called from Python, here kernels.py, and at no other.
    folder = Path(kernels.__file__).parent
    text = "".join((folder / f"{name}.py").read_text(encoding="utf-8") for name in kernels.CALLED)
    assert hashlib.sha256(text.encode()).hexdigest()[:16] == kernels.CALLED_DIGEST


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
        free, [(0, 0)], block=(5, 6), iterations=iterations, schedule=[33], start=start, termination=termination
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
