"""Trajectories keep off the walls and rise; quality says what they are worth."""

import math
import pickle
from itertools import pairwise

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_harmonic import climb, local_maxima

from codesign.ground.errors import InputError
from codesign.maps import nearest_free
from codesign.maps.generate import empty, maze, random_obstacles
from codesign.planners.harmonic.plan import Field
from codesign.planners.harmonic.plan.planner import quality
from codesign.planners.harmonic.plan.precision import converged_field
from codesign.planners.harmonic.plan.trajectory import Ascent, Ending, Rule
from codesign.planners.interface import Problem


@st.composite
def problems(draw):
    rows, columns = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    density = draw(st.sampled_from([0.0, 0.2, 0.4]))
    free = random_obstacles(rows, columns, density=density, seed=draw(st.integers(0, 999))).free.copy()
    goal = draw(st.integers(0, rows * columns - 1))
    free.ravel()[goal] = True
    goals = [divmod(goal, columns)]
    return free, goals, converged_field(free, goals, draw(st.sampled_from([4, 12, 60, 120])))


def cells_along(points):
    """Cells that the segments between the points pass through, sampled densely."""
    share = np.linspace(0.0, 1.0, 101)[:, None]
    for first, second in pairwise(points):
        yield np.unique(np.floor(first + share * (second - first) + 0.5).astype(int), axis=0)


@settings(max_examples=60)
@given(problems(), st.sampled_from(list(Rule)), st.sampled_from([0.1, 0.5, 1.0]), st.booleans())
def test_no_trajectory_enters_an_obstacle_or_cuts_a_corner(problem, rule, step, guarded):
    free, goals, field = problem
    ascent = Ascent(field, free, goals, rule=rule, step=step, guarded=guarded, most_steps=500)
    for start in np.argwhere(free)[::3]:
        way = ascent.follow(tuple(start))
        for cells in cells_along(way.points):
            (top, left), (bottom, right) = cells.min(axis=0), cells.max(axis=0)
            assert free[top : bottom + 1, left : right + 1].all()
        assert tuple(way.points[0]) == tuple(start)
        assert way.arrived == (tuple(way.points[-1]) in goals)


@settings(max_examples=60)
@given(problems(), st.sampled_from(list(Rule)))
def test_a_guarded_robot_rises_and_never_meets_the_bound(problem, rule):
    free, goals, field = problem
    ascent = Ascent(field, free, goals, rule=rule)
    values = field.to_ints()
    for start in np.argwhere(free):
        way = ascent.follow(tuple(start))
        assert way.ending in (Ending.GOAL, Ending.FLAT)
        cells = np.floor(way.points + 0.5).astype(int)
        heights = [values[tuple(cell)] for cell in cells]
        for k in range(1, len(cells)):
            assert heights[k] > heights[k - 1] or (cells[k] == cells[k - 1]).all()


@settings(max_examples=examples(60))
@given(problems(), st.sampled_from(list(Rule)))
def test_without_local_maxima_every_reachable_cell_arrives(problem, rule):
    free, goals, field = problem
    ascent = Ascent(field, free, goals, rule=rule)
    arriving = ascent.climbs_to_goal()
    for start in np.argwhere(free):
        trajectory = climb(ascent, tuple(start))
        assert trajectory.arrived == arriving[tuple(start)]
        assert trajectory.length == len(trajectory.points) - 1
    reachable = ascent.goal | (Ascent(converged_field(free, goals, 200), free, goals).climbs_to_goal())
    if not local_maxima(field, free, goals).any():
        endings = ascent.endings(reachable)
        assert endings.pop(Ending.GOAL) == reachable.sum()
        assert not any(endings.values())


def test_endings_count_what_single_trajectories_do():
    grid = maze(15, 15, seed=3)
    goals = [tuple(int(i) for i in np.argwhere(grid.free)[0])]
    ascent = Ascent(converged_field(grid.free, goals, 40), grid.free, goals, guarded=False, most_steps=300)
    counted = dict.fromkeys(Ending, 0)
    for start in np.argwhere(grid.free):
        counted[ascent.follow(tuple(start)).ending] += 1
    assert ascent.endings(grid.free) == counted
    assert counted[Ending.OBSTACLE] > 0
    assert counted[Ending.FLAT] > 0


def test_the_plain_rule_hits_the_wall_of_a_narrow_corridor_and_the_guard_does_not():
    free = np.ones((1, 12), bool)
    field = converged_field(free, [(0, 11)], 40)
    plain = Ascent(field, free, [(0, 11)], guarded=False).follow((0, 1))
    assert plain.ending is Ending.OBSTACLE
    guarded = Ascent(field, free, [(0, 11)]).follow((0, 1))
    assert guarded.arrived
    assert guarded.fallbacks > 0
    straight = Ascent(field, free, [(0, 11)], rule=Rule.NEIGHBOUR).follow((0, 1))
    assert (straight.length, straight.fallbacks) == (10.0, 0)


def test_a_flat_cell_and_the_bound_on_steps_end_a_way():
    free = np.ones((1, 3), bool)
    level = Field.from_ints(np.array([[0, 0, 16]]), 4)
    assert Ascent(level, free, [(0, 2)]).follow((0, 0)).ending is Ending.FLAT
    short = Ascent(level, free, [(0, 2)], most_steps=1, step=0.25, rule=Rule.NEIGHBOUR).follow((0, 1))
    assert short.ending is Ending.STEPS
    assert len(short.points) == 2


def test_a_diagonal_step_past_an_obstacle_is_a_cut_corner():
    # From (0, 1) the falls to the obstacle and to the outside tie, so the rule points down and left.
    free = np.array([[False, True], [True, True]])
    field = Field.from_ints(np.array([[0, 4], [16, 5]]), 4)
    plain = Ascent(field, free, [(1, 0)], step=0.8, guarded=False).follow((0, 1))
    assert plain.ending is Ending.OBSTACLE
    assert len(plain.points) == 1
    guarded = Ascent(field, free, [(1, 0)], step=0.8).follow((0, 1))
    assert guarded.arrived
    assert guarded.points.tolist()[:2] == [[0, 1], [1, 1]]


def test_a_way_ends_at_a_goal_whatever_lies_beyond():
    free = np.ones((1, 3), bool)
    ascent = Ascent(Field.from_ints(np.array([[1, 2, 3]]), 2), free, [(0, 1)])
    assert ascent.climbs_to_goal().tolist() == [[True, True, False]]
    assert climb(ascent, (0, 0)).points.tolist() == [[0, 0], [0, 1]]
    assert climb(ascent, (0, 2)).ending is Ending.FLAT


def test_a_start_between_centres_ends_at_the_centre_of_the_goal():
    grid = empty(9, 9)
    ascent = Ascent(converged_field(grid.free, [(4, 4)], 30), grid.free, [(4, 4)])
    way = ascent.follow((1.3, 6.9))
    assert tuple(way.points[-1]) == (4.0, 4.0)
    assert math.dist((1.3, 6.9), (4, 4)) <= way.length < 1.2 * math.dist((1.3, 6.9), (4, 4))
    assert way.points.dtype == np.float64
    copy = pickle.loads(pickle.dumps(way))
    assert (copy.points == way.points).all()
    assert copy.ending is way.ending


@pytest.mark.parametrize("start", [(-1, 0), (0, 3), (0, 1), (math.nan, 0.0), (math.inf, 0.0), (0.0, -0.51)])
def test_a_start_off_the_free_cells_is_refused(start):
    free = np.array([[True, False, True]])
    ascent = Ascent(Field.from_ints(np.array([[1, 0, 4]]), 2), free, [(0, 2)])
    with pytest.raises(InputError, match="free cell"):
        ascent.follow(start)


@pytest.mark.parametrize("arguments", [{"step": 0.0}, {"step": 1.1}, {"step": math.nan}, {"most_steps": 0}])
def test_impossible_arguments_are_refused(arguments):
    field = Field.from_ints(np.array([[1, 4]]), 2)
    with pytest.raises(InputError):
        Ascent(field, np.ones((1, 2), bool), [(0, 1)], **arguments)


def test_quality_of_a_corridor_is_known():
    free = np.ones((1, 11), bool)
    problem = Problem(free, ((0, 10),), ((0, 0), (0, 4), (0, 10)))
    judged = quality(problem, converged_field(free, problem.goals, 60), rule=Rule.NEIGHBOUR)
    assert (judged.reachable_cells, judged.local_maxima, judged.share_reaching_goal) == (10, 0, 1.0)
    assert (judged.starts, judged.starts_arrived) == (3, 3)
    assert (judged.path_length_ratio_mean, judged.path_length_ratio_worst) == (1.0, 1.0)
    assert (judged.clearance_mean, judged.clearance_least) == (1.0, 1.0)


def test_quality_counts_what_low_precision_loses():
    free = np.ones((1, 11), bool)
    problem = Problem(free, ((0, 10),), ((0, 0), (0, 9)))
    field = converged_field(free, problem.goals, 4)  # ... 0, 1, 4, 16
    judged = quality(problem, field, rule=Rule.NEIGHBOUR)
    assert judged.local_maxima == 7
    assert judged.share_reaching_goal == 3 / 10
    assert (judged.starts, judged.starts_arrived) == (2, 1)


def test_quality_tells_mean_from_worst_and_clearance_from_length():
    # Three rows, goal at the right of the middle one; a start in a corner must leave the wall.
    free = np.ones((3, 9), bool)
    problem = Problem(free, ((1, 8),), ((0, 0), (1, 0)))
    field = converged_field(free, problem.goals, 80)
    judged = quality(problem, field)
    ways = [Ascent(field, free, problem.goals).follow(start) for start in problem.starts]
    ratios = [ways[0].length / (7 + math.sqrt(2)), ways[1].length / 8]
    assert judged.path_length_ratio_mean == pytest.approx(np.mean(ratios))
    assert judged.path_length_ratio_worst == pytest.approx(max(ratios))
    assert judged.clearance_least == 1.0
    assert 1.0 < judged.clearance_mean < 2.0


def test_quality_without_starts_or_ways_has_no_lengths():
    free = np.array([[True, True, False, True]])
    for starts in ((), ((0, 3),)):
        problem = Problem(free, ((0, 0),), starts)
        judged = quality(problem, converged_field(free, problem.goals, 8))
        assert (judged.reachable_cells, judged.share_reaching_goal) == (1, 1.0)
        assert (judged.starts, judged.starts_arrived) == (len(starts), 0)
        assert judged.path_length_ratio_mean is judged.clearance_least is judged.clearance_mean is None


def test_quality_of_a_single_goal_cell():
    problem = Problem(np.ones((1, 1), bool), ((0, 0),), ((0, 0),))
    judged = quality(problem, converged_field(problem.free, problem.goals, 8))
    assert (judged.reachable_cells, judged.share_reaching_goal, judged.starts_arrived) == (0, None, 1)
    assert judged.path_length_ratio_mean is None
    assert judged.clearance_least == 1.0
    assert pickle.loads(pickle.dumps(judged)) == judged


def test_wrong_cells_are_those_the_published_termination_left_behind() -> None:
    """Fact 5: ended early with wrong cells; the same run under sound termination has none."""
    from codesign.planners.harmonic.plan import relax

    grid = maze(51, 51, corridor=3, seed=2)
    goal = nearest_free(grid.free, (25, 25))
    assert goal is not None
    problem = Problem(free=grid.free, goals=(goal,), starts=())
    fields = {
        termination: relax(
            grid.free, [goal], block=(17, 17), iterations=64, schedule=[32], termination=termination
        ).field
        for termination in ("sound", "published")
    }
    differing = int((fields["sound"].to_ints() != fields["published"].to_ints()).sum())
    assert differing > 50
    assert quality(problem, fields["published"]).wrong_cells == differing
    assert quality(problem, fields["sound"]).wrong_cells == 0
