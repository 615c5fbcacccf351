"""Ways down the potentials, safe ways, the skeleton, tiles, and the planner's answers made of them."""

from __future__ import annotations

import numpy as np
import pytest
import reference_paths
import reference_tiles
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pydantic import ValidationError

from codesign import maps
from codesign.ground.errors import InputError, MapError
from codesign.planners.interface import Problem, judge_paths
from codesign.planners.job import Job
from codesign.planners.wavefront.plan import obstacle_potentials, octile_length, propagate, skeleton, track
from codesign.planners.wavefront.plan.bounds import VisitBounds
from codesign.planners.wavefront.plan.grid import check_map
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.plan.planner import PLANNER
from codesign.planners.wavefront.plan.tiles import NEVER, run_tiles
from codesign.planners.wavefront.plan.wave import run_wave

NO_STOP = np.zeros((0, 2), np.int64)


@st.composite
def walks(draw: st.DrawFn) -> tuple[NDArray[np.bool_], tuple[int, int], tuple[int, int]]:
    """A random map, a source, and a cell that a way joins to it."""
    shape = draw(st.tuples(st.integers(2, 14), st.integers(2, 14)))
    free = np.random.default_rng(draw(st.integers(0, 10**6))).random(shape) >= draw(st.floats(0, 0.5))
    free[0, 0] = True
    cells = [tuple(cell) for cell in np.argwhere(free).tolist()]
    source = draw(st.sampled_from(cells))
    reached = np.argwhere(propagate(free, [source]) >= 0).tolist()
    return free, source, tuple(draw(st.sampled_from(reached)))


@given(walks(), st.booleans())
@settings(max_examples=examples(120))
def test_shortest_ways_add_up_to_the_potential(
    walk: tuple[NDArray[np.bool_], tuple[int, int], tuple[int, int]], penalised: bool
) -> None:
    free, source, start = walk
    extra = np.add.outer(np.arange(free.shape[0]), np.arange(free.shape[1])) % 4 if penalised else None
    potentials = propagate(free, [source], extra_delay=extra)
    way = track(free, potentials, start, extra_delay=extra)
    assert tuple(way[0]) == start
    assert tuple(way[-1]) == source
    assert free[tuple(way.T)].all()
    moved = np.abs(np.diff(way, axis=0))
    assert (moved.max(axis=1) == 1).all() if len(moved) else start == source
    entered = 0 if extra is None else int(extra[tuple(way[:-1].T)].sum())
    assert int((1 + moved.sum(axis=1)).sum()) + entered == potentials[start]
    if not penalised:
        assert way.tolist() == [list(cell) for cell in reference_paths.track(free, potentials, start)]
        assert potentials[start] / 2 >= octile_length(way) - 1e-9


@given(walks())
@settings(max_examples=examples(120))
def test_safe_ways_arrive_by_equations_4_and_5(
    walk: tuple[NDArray[np.bool_], tuple[int, int], tuple[int, int]],
) -> None:
    free, source, start = walk
    potentials, distances = propagate(free, [source], stop=start), obstacle_potentials(free)
    way = track(free, potentials, start, obstacle_potentials=distances)
    assert tuple(way[-1]) == source
    assert (np.diff(potentials[tuple(way.T)]) < 0).all()
    assert way.tolist() == [list(cell) for cell in reference_paths.track(free, potentials, start, distances)]


def test_a_safe_way_keeps_off_the_walls() -> None:
    free = np.zeros((9, 30), bool)
    free[1:8, 1:29] = True
    potentials, distances = propagate(free, [(1, 1)]), obstacle_potentials(free)
    shortest, safe = (track(free, potentials, (1, 28)), track(free, potentials, (1, 28), obstacle_potentials=distances))
    assert distances[tuple(safe.T)].mean() > 2 * distances[tuple(shortest.T)].mean()


def test_local_courses_are_the_beginning_of_the_whole_way() -> None:
    free = maps.rooms(30, 30, room=(9, 9), door=2, seed=1).free
    potentials = propagate(free, [(0, 0)])
    whole = track(free, potentials, (28, 28))
    assert (track(free, potentials, (28, 28), steps=5) == whole[:6]).all()
    assert (track(free, potentials, (0, 0), steps=5) == [[0, 0]]).all()


def test_without_corner_cutting_ways_keep_clear_of_corners() -> None:
    free = maps.random_obstacles(30, 30, density=0.25, seed=5).free
    source = maps.nearest_free(free, (0, 0))
    assert source is not None
    potentials = propagate(free, [source], corner_cutting=False)
    for start in np.argwhere(potentials >= 0)[::7].tolist():
        way = track(free, potentials, start, corner_cutting=False)
        assert free[way[:-1, 0], way[1:, 1]].all()
        assert free[way[1:, 0], way[:-1, 1]].all()


@given(st.integers(0, 10**6), st.floats(0, 0.5))
@settings(max_examples=60)
def test_the_skeleton_is_a_local_rule_that_turns_with_the_map(seed: int, density: float) -> None:
    free = np.random.default_rng(seed).random((13, 17)) >= density
    distances = obstacle_potentials(free)
    found = skeleton(distances)
    assert (found == reference_paths.skeleton(distances)).all()
    assert not (found & ~free).any()
    assert (skeleton(distances.T) == found.T).all()
    assert (skeleton(distances[::-1]) == found[::-1]).all()


@pytest.mark.parametrize(("width", "crest"), [(5, [3]), (6, [3, 4]), (1, [1]), (2, [1, 2])])
def test_the_skeleton_of_a_corridor_is_its_middle(width: int, crest: list[int]) -> None:
    free = np.zeros((width + 2, 40), bool)
    free[1:-1] = True
    assert np.flatnonzero(skeleton(obstacle_potentials(free)).any(axis=1)).tolist() == crest


@given(
    walks(),
    st.integers(1, 15),
    st.integers(1, 15),
    st.sampled_from(["plain", "corners", "penalty", "even"]),
    st.integers(0, 2000),
)
@settings(max_examples=examples(160))
def test_tiles_give_the_same_potentials_by_the_visits_of_the_plain_loop(
    walk: tuple[NDArray[np.bool_], tuple[int, int], tuple[int, int]], height: int, width: int, kind: str, most: int
) -> None:
    free, source, start = walk
    extra = np.add.outer(np.arange(free.shape[0]) * 3, np.arange(free.shape[1])) % 6 if kind == "penalty" else None
    wave_map = check_map(free, (3, 3) if kind == "even" else None, kind != "corners", extra)
    sources, tile = np.array([source]), (height, width)
    whole, unbounded = run_wave(wave_map, sources, NO_STOP)[0], run_tiles(wave_map, sources, tile)[1]
    for stops in (NO_STOP, np.array([start])):
        if len(stops) and whole[start] < 0:
            continue
        until = int(whole[start]) if len(stops) else NEVER
        potentials, visits = run_tiles(wave_map, sources, tile, until)
        expected, loop = reference_tiles.run_tiles(wave_map, sources, stops, tile)
        assert (potentials == expected).all()
        assert (potentials == run_wave(wave_map, sources, stops)[0]).all()
        assert list(zip(visits.tile, visits.since, visits.span, visits.last, strict=True)) == loop
        assert visits.largest >= potentials.max()
        # Near stops take the first visits of the wave to its own end.
        assert (np.diff(visits.since) >= 0).all()
        assert (unbounded.before(until).span == visits.span).all()
        given_up = run_tiles(wave_map, sources, tile, until, 5, most)[1]
        assert (given_up.span == visits.span[: len(given_up.span)]).all()
        assert (given_up.until < until) == (int((visits.span + 6).sum()) > most)
        if kind == "plain" and height <= free.shape[0] and width <= free.shape[1]:
            # What is sure to come only tells sooner that all visits are too many.
            bounds = VisitBounds(whole, until)
            sure, total = bounds.sure(tile), int((visits.span + 6).sum())
            assert [len(sure), sure[:, 3].sum()] == bounds.visits(height, (width, width))[0].tolist()
            assert len(sure) <= len(visits.span)
            assert sure[:, 3].sum() <= visits.span.sum()
            sooner = run_tiles(wave_map, sources, tile, until, 5, most, sure)[1]
            assert (sooner.until < until) == (total > most)
            assert (sooner.left > 0) <= (most < int((sooner.span + 6).sum()) + sooner.left <= total)
        if height >= free.shape[0] and width >= free.shape[1]:
            # A stop that is the source is reached before any visit.
            assert len(visits.tile) == (0 if len(stops) and start == source else 1)


def problem(starts: tuple[tuple[int, int], ...] = ((28, 28), (0, 28))) -> Problem:
    return Problem(maps.rooms(30, 30, room=(9, 9), door=2, seed=1).free, ((0, 0),), starts)


def test_the_wave_ends_at_the_first_start_or_runs_on() -> None:
    here = problem()
    stopped = PLANNER.plan(Job(here, PropagateParameters()))
    whole = PLANNER.plan(Job(here, PropagateParameters(stop="whole_map")))
    assert stopped.stop_potential == stopped.largest_potential == whole.potentials[here.starts[0]]
    assert whole.stop_potential is None
    assert PLANNER.quality(here, whole).share_reaching_goal == 1.0
    beyond = int((whole.potentials > stopped.largest_potential).sum())
    quality = PLANNER.quality(here, stopped)
    assert quality.reachable_cells - quality.planned_cells == beyond > 0
    assert PLANNER.figures(stopped)["details"]["stop_potential"] == stopped.stop_potential


def test_a_start_is_judged_by_the_wave_of_its_own_request() -> None:
    for paths in ("shortest", "safe"):
        parameters, here = PropagateParameters(paths=paths), problem()
        first = PLANNER.plan(Job(here, parameters))
        assert any(first.potentials[start] < 0 for start in here.starts)
        own = []
        for start in here.starts:
            asked = here.asked_from(start)
            points, arrived = PLANNER.trajectory(asked, PLANNER.plan(Job(asked, parameters)), start)
            own.append((start, points if arrived else None))
        judged = judge_paths(here, own)
        quality = PLANNER.quality(here, first)
        assert {name: getattr(quality, name) for name in judged} == judged


def test_a_penalty_leads_away_from_walls() -> None:
    here = problem()
    plain = PLANNER.quality(here, PLANNER.plan(Job(here, PropagateParameters())))
    shy = PLANNER.quality(here, PLANNER.plan(Job(here, PropagateParameters(penalty={"distance": 4, "delay": 5}))))
    assert shy.clearance_mean > plain.clearance_mean
    assert shy.starts_arrived == 2


def test_finer_delays_never_lengthen_ways() -> None:
    here = problem()
    lengths = [
        octile_length(PLANNER.plan(Job(here, PropagateParameters(delays=delays))).tracker.follow((28, 28)))
        for delays in ((2, 3), (5, 7), (41, 58))
    ]
    assert lengths[0] >= lengths[1] - 1e-9 >= lengths[2] - 2e-9


def test_check_names_what_is_wrong() -> None:
    cut = np.ones((5, 5), bool)
    cut[:, 2] = False
    assert PLANNER.check(Job(problem(), PropagateParameters())) is None
    found = PLANNER.check(Job(Problem(cut, ((0, 0),), ((0, 4),)), PropagateParameters()))
    assert found is not None
    assert found[0] == "stop"
    assert "(0, 4) cannot be reached" in found[1]
    assert PLANNER.check(Job(Problem(cut, ((0, 0),), ((0, 4),)), PropagateParameters(stop="whole_map"))) is None
    assert PLANNER.check(Job(problem(), PropagateParameters(tile=(31, 4)))) is None
    many = PLANNER.check(Job(Problem(np.ones((256, 256), bool), ((0, 0),), ()), PropagateParameters(tile=(1, 2))))
    assert many == ("tile", "32,768 tiles of 1 × 2 nodes, more than 16,384")


@pytest.mark.parametrize(
    "raw",
    [
        {"delays": (3, 2)},
        {"delays": (0, 2)},
        {"register_bits": 0},
        {"register_bits": 32},
        {"steps": 0},
        {"tile": (0, 4)},
        {"penalty": {"distance": 4, "delay": 64}},
        {"stop": "start"},
        {"corner_cutting": "no"},
        {"omega": 1},
    ],
)
def test_bad_parameters_are_refused(raw: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        PropagateParameters.model_validate(raw)


def test_ways_are_refused_where_the_wave_did_not_come() -> None:
    free = np.array([[True, False, True]])
    potentials = propagate(free, [(0, 0)])
    with pytest.raises(MapError, match="did not reach"):
        track(free, potentials, (0, 2))
    with pytest.raises(MapError, match="obstacle"):
        track(free, potentials, (0, 1))
    with pytest.raises(InputError, match="shape"):
        track(free, potentials.T, (0, 0))
    with pytest.raises(InputError, match="steps"):
        track(free, potentials, (0, 0), steps=0)
    points, arrived = PLANNER.trajectory(
        Problem(free, ((0, 0),), ()), PLANNER.plan(Job(Problem(free, ((0, 0),), ()), PropagateParameters())), (0, 2)
    )
    assert not arrived
    assert points.tolist() == [[0.0, 2.0]]
