"""The closed loop in fixed point, compiled: bit for bit equal to ``reference`` with ``arithmetic.fixed``.

The kernel differs from the plain text in three points, with the same answers. The step of the other robots is computed
once an update, not once a trial. Equation 4 is computed by Lagrange's identity, |r|²|V|² - (r·V)² = (r × V)². Both of
its sides, up to 110 bits at a width of 24, are compared as two words of 64 bits.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

(
    STEP,
    HALF_SQUARE,
    INVERSE_STEP,
    CHANGE_SQUARED,
    BRAKE,
    ACCELERATION,
    SPEED,
    RADIUS_SQUARED,
    TOLERANCE_SQUARED,
    PROPORTIONAL,
    INTEGRAL,
    DERIVATIVE,
    LIMIT,
    RANGE_SQUARED,
    TURNS,
) = range(15)
"""Places in the array of constants; ``LIMIT``: 2^(width - 1); ``TURNS``: directions tried at each speed."""

NO_RANGE = 2**62
"""Farther than any distance between two robots."""

VELOCITY_STEP, ACCELERATION_STEP, ACCELERATION_HALF_SQUARE, CHANGE_INVERSE_STEP, GAIN = range(5)
"""Places in the array of shifts."""

SELECT_BRAKE, SELECT_STAY = -1, -2

POSITION_OVERFLOW, VELOCITY_OVERFLOW = 1, 2

_HALF = np.uint64(32)
_LOW = np.uint64(0xFFFFFFFF)


@njit(cache=True, nogil=True)
def _rescale(product: Any, shift: Any) -> Any:
    # floor(product / 2^shift + 1/2): to nearest, halves up. The one bit added is 0 where there is nothing to shift.
    return (product + (np.int64(1) << shift >> np.int64(1))) >> shift


@njit(cache=True, nogil=True)
def _fits(value: Any, limit: Any) -> Any:
    return -limit <= value < limit


@njit(cache=True, nogil=True)
def _wide_product(a: Any, b: Any) -> Any:
    """The high and the low word of a · b, all uint64."""
    # (aH·2^32 + aL)(bH·2^32 + bL) = aH·bH·2^64 + (aH·bL + aL·bH)·2^32 + aL·bL. Every sum below stays within 64 bits.
    a_low, a_high, b_low, b_high = a & _LOW, a >> _HALF, b & _LOW, b >> _HALF
    low = a_low * b_low
    middle = a_high * b_low + (low >> _HALF)
    other = a_low * b_high + (middle & _LOW)
    high = a_high * b_high + (middle >> _HALF) + (other >> _HALF)
    return high, (other << _HALF) | (low & _LOW)


@njit(cache=True, nogil=True)
def on_course(
    x: Any, y: Any, vx: Any, vy: Any, radius_squared: Any, approaching: Any, range_squared: Any = NO_RANGE
) -> Any:
    """True if a relative position and velocity are on a collision course (equation 4)."""
    if x * x + y * y > range_squared or (approaching and x * vx + y * vy >= 0):
        return False
    # A collision is the contrary of equation 4, |r|²|V|² - (r·V)² ≥ R²|V|²: with Lagrange, (r × V)² < R²|V|².
    cross = np.uint64(abs(x * vy - y * vx))
    high, low = _wide_product(cross, cross)
    most_high, most_low = _wide_product(np.uint64(radius_squared), np.uint64(vx * vx + vy * vy))
    return high < most_high or (high == most_high and low < most_low)


@njit(cache=True, nogil=True)
def _to_goal(x: Any, y: Any, bounds: Any, directions: Any) -> Any:
    # "To-goal" (section III) without an arctangent: in the first octant across / along is compared with the tangents
    # halfway between two directions, (cos, sin) in ``bounds``. Then it is mirrored back at 45°, 90° and 0°.
    along, across = max(abs(x), abs(y)), min(abs(x), abs(y))
    direction = 0
    for k in range(len(bounds)):
        if across * bounds[k, 0] > along * bounds[k, 1]:
            direction += 1
    if abs(y) > abs(x):
        direction = directions // 4 - direction
    if x < 0:
        direction = directions // 2 - direction
    if y < 0:
        direction = -direction
    return direction % directions


@njit(cache=True, nogil=True)
def _is_safe(
    own: Any, x: Any, y: Any, vx: Any, vy: Any, stepped: Any, velocity: Any, constants: Any, approaching: Any
) -> Any:
    """True if a trial of robot ``own`` at (x, y) with the velocity (vx, vy) is on no collision course with another."""
    # A trial that leaves its word is refused, as by the overflow bit of the unit.
    if not (_fits(x, constants[LIMIT]) and _fits(y, constants[LIMIT])):
        return False
    # Equation 4 for the relative position and velocity of every pair.
    for other in range(len(stepped)):
        if other != own and on_course(
            x - stepped[other, 0],
            y - stepped[other, 1],
            vx - velocity[other, 0],
            vy - velocity[other, 1],
            constants[RADIUS_SQUARED],
            approaching,
            constants[RANGE_SQUARED],
        ):
            return False
    return True


@njit(cache=True, nogil=True)
def _choose(robot: Any, position: Any, velocity: Any, stepped: Any, target: Any, rules: Any) -> Any:
    """Candidate, checks, trials, and the velocity that the candidate leads to."""
    array, bounds, constants, shifts, approaching, half = rules
    speeds, directions = array.shape[0], array.shape[1]
    checks, trials = 0, 0
    px, py = position[robot]
    vx, vy = velocity[robot]
    heading = _to_goal(target[robot, 0] - px, target[robot, 1] - py, bounds, directions)
    # Equation 2b in two parts: r + v t is the same for all candidates, a t²/2 is each one's own.
    straight_x = _rescale(vx * constants[STEP], shifts[VELOCITY_STEP])
    straight_y = _rescale(vy * constants[STEP], shifts[VELOCITY_STEP])
    # From the fastest speed down; at each, away from the goal's direction by 0, +1, -1, +2, -2, .. ("small values
    # towards both clockwise and anti-clockwise", section III). The first candidate that passes is taken.
    for speed in range(speeds):
        for turn in range(constants[TURNS]):
            rotation = (turn + 1) // 2 if turn % 2 else -(turn // 2)
            direction = (heading + rotation) % directions
            checks += 1
            # Acceleration check: a = (v_c - v) / t is achievable if |v_c - v|² ≤ (a_max t)².
            cx, cy = array[speed, direction, 0] - vx, array[speed, direction, 1] - vy
            if cx * cx + cy * cy > constants[CHANGE_SQUARED]:
                continue
            trials += 1
            ax = _rescale(cx * constants[INVERSE_STEP], shifts[CHANGE_INVERSE_STEP])
            ay = _rescale(cy * constants[INVERSE_STEP], shifts[CHANGE_INVERSE_STEP])
            # Update: v' = v + a t (2a) and r' = r + v t + a t²/2 (2b).
            new_x = vx + _rescale(ax * constants[STEP], shifts[ACCELERATION_STEP])
            new_y = vy + _rescale(ay * constants[STEP], shifts[ACCELERATION_STEP])
            there_x = px + straight_x + _rescale(ax * constants[HALF_SQUARE], shifts[ACCELERATION_HALF_SQUARE])
            there_y = py + straight_y + _rescale(ay * constants[HALF_SQUARE], shifts[ACCELERATION_HALF_SQUARE])
            # Reciprocal: v' is halfway from v to the velocity that avoids, 2v' - v; the other robot does the rest.
            own_x = 2 * new_x - vx if half else new_x
            own_y = 2 * new_y - vy if half else new_y
            if _is_safe(robot, there_x, there_y, own_x, own_y, stepped, velocity, constants, approaching):
                return speed * directions + direction, checks, trials, new_x, new_y
    return SELECT_BRAKE, checks, trials, vx, vy


@njit(cache=True, nogil=True)
def _drive(
    axis: Any, robot: Any, wanted: Any, velocity: Any, sums: Any, errors: Any, constants: Any, shift: Any
) -> Any:
    """The acceleration of one axis that the PID gives; updates the sum of errors and the last error."""
    # e = v_wanted - v and a = Kp e + Ki Σe + Kd (e - e_last). Σe is clipped too, lest it grow while a is clipped.
    error = wanted - velocity[robot, axis]
    total = max(-constants[SPEED], min(constants[SPEED], sums[robot, axis] + error))
    drive = (
        _rescale(constants[PROPORTIONAL] * error, shift)
        + _rescale(constants[INTEGRAL] * total, shift)
        + _rescale(constants[DERIVATIVE] * (error - errors[robot, axis]), shift)
    )
    sums[robot, axis] = total
    errors[robot, axis] = error
    return max(-constants[ACCELERATION], min(constants[ACCELERATION], drive))


@njit(cache=True, nogil=True)
def _move(
    robot: Any, wanted: Any, position: Any, velocity: Any, sums: Any, errors: Any, constants: Any, shifts: Any
) -> Any:
    """One robot's PID control and update (equations 2a and 2b); the kind of value that left its word, 0: none."""
    outside = 0
    limit = constants[LIMIT]
    for axis in range(2):
        a = _drive(axis, robot, wanted[robot, axis], velocity, sums, errors, constants, shifts[GAIN])
        v = velocity[robot, axis]
        # Equation 2b, then 2a: the position with the velocity at the begin of the step.
        r = position[robot, axis] + (
            _rescale(v * constants[STEP], shifts[VELOCITY_STEP])
            + _rescale(a * constants[HALF_SQUARE], shifts[ACCELERATION_HALF_SQUARE])
        )
        v += _rescale(a * constants[STEP], shifts[ACCELERATION_STEP])
        position[robot, axis], velocity[robot, axis] = r, v
        if not _fits(r, limit):
            outside = POSITION_OVERFLOW
        elif outside == 0:
            error, goal = errors[robot, axis], wanted[robot, axis]
            if not (_fits(v, limit) and _fits(error, limit) and _fits(goal, limit)):
                outside = VELOCITY_OVERFLOW
    return outside


@njit(cache=True, nogil=True)
def decide(
    position: Any,
    velocity: Any,
    targets: Any,
    arrived: Any,
    stepped: Any,
    wanted: Any,
    rules: Any,
    candidates: Any,
    checks: Any,
    trials: Any,
) -> Any:
    """Every robot's choice from one common state; writes arrived, stepped, wanted, candidates, checks and trials.

    ``rules``: as of ``run``. Returns the robot that leaves the words of a position if it drives on for one step, or -1.
    The choices are valid in either case.
    """
    constants, shifts = rules[2], rules[3]
    count = len(position)
    outside = -1
    for robot in range(count):
        # Target check: |target - r|^2 against the square of the tolerance.
        x, y = targets[robot, 0] - position[robot, 0], targets[robot, 1] - position[robot, 1]
        arrived[robot] |= x * x + y * y <= constants[TOLERANCE_SQUARED]
        # Equation 2b without acceleration: where the others see this robot after one step.
        for axis in range(2):
            moved = _rescale(velocity[robot, axis] * constants[STEP], shifts[VELOCITY_STEP])
            stepped[robot, axis] = position[robot, axis] + moved
            if not _fits(stepped[robot, axis], constants[LIMIT]) and outside < 0:
                outside = robot
    for robot in range(count):
        candidate, checks[robot], trials[robot] = SELECT_STAY, 0, 0
        if not arrived[robot]:
            candidate, checks[robot], trials[robot], x, y = _choose(robot, position, velocity, stepped, targets, rules)
            wanted[robot, 0], wanted[robot, 1] = x, y
        if candidate < 0:
            # No safe velocity, or arrived: nearer to rest, each axis by itself.
            for axis in range(2):
                v = velocity[robot, axis]
                wanted[robot, axis] = v - max(-constants[BRAKE], min(constants[BRAKE], v))
        candidates[robot] = candidate
    return outside


@njit(cache=True, nogil=True)
def hold(position: Any, velocity: Any, steps: Any, rules: Any) -> Any:
    """Drive all robots on for some steps with their velocities (equation 2b without acceleration).

    Returns the robot that first leaves its words and the number of that step, with ``position`` at that step; or
    (-1, 0).
    """
    constants, shifts = rules[2], rules[3]
    count, limit = len(position), constants[LIMIT]
    moved = np.zeros((count, 2), np.int64)
    outside, first = -1, steps
    for robot in range(count):
        for axis in range(2):
            r = position[robot, axis]
            d = _rescale(velocity[robot, axis] * constants[STEP], shifts[VELOCITY_STEP])
            moved[robot, axis] = d
            # The first whole number of steps after which r + steps * d leaves [-limit, limit).
            leaves = steps + 1
            if d > 0:
                leaves = (limit - 1 - r) // d + 1
            elif d < 0:
                leaves = (r + limit) // -d + 1
            if leaves <= steps and (outside < 0 or leaves < first):
                outside, first = robot, leaves
    for robot in range(count):
        for axis in range(2):
            position[robot, axis] += first * moved[robot, axis]
    return outside, (first if outside >= 0 else 0)


@njit(cache=True, nogil=True)
def act(position: Any, velocity: Any, sums: Any, errors: Any, wanted: Any, rules: Any) -> Any:
    """One step in which every robot's PID control drives it to its wanted velocity.

    Returns the kind of value that first left its word (0: none), and the robot.
    """
    overflow, overflown = 0, 0
    for robot in range(len(position)):
        outside = _move(robot, wanted, position, velocity, sums, errors, rules[2], rules[3])
        if outside != 0 and overflow == 0:
            overflow, overflown = outside, robot
    return overflow, overflown


@njit(cache=True, nogil=True)
def at_rest(velocity: Any, arrived: Any) -> Any:
    """True if all robots have arrived and stand."""
    for robot in range(len(velocity)):
        if not arrived[robot] or velocity[robot, 0] != 0 or velocity[robot, 1] != 0:
            return False
    return True


@njit(cache=True, nogil=True)
def run(
    position: Any, velocity: Any, targets: Any, arrived: Any, sums: Any, errors: Any, rules: Any, updates: int
) -> Any:
    """The closed loop of n robots for at most ``updates`` updates, each decided within its time step.

    ``position``, ``velocity``, ``sums``, ``errors``: int64 n × 2, left in the state at the end; ``targets`` likewise.
    ``arrived``: bool n. ``rules``: the array, int64 speeds × directions × 2; the bounds, int64 k × 2; the constants and
    the shifts, int64; whether robots have to approach, and whether each takes half.
    Returns the number of updates done; positions and velocities after each, int64 updates × n × 2; candidate, checks
    and trials, int32 updates × n; the kind of value that overflowed in the next update (0: none), and its robot.
    """
    count = len(position)
    positions = np.zeros((updates, count, 2), np.int64)
    velocities = np.zeros((updates, count, 2), np.int64)
    candidates = np.zeros((updates, count), np.int32)
    checks = np.zeros((updates, count), np.int32)
    trials = np.zeros((updates, count), np.int32)
    stepped, wanted = np.zeros((count, 2), np.int64), np.zeros((count, 2), np.int64)
    overflow, overflown = 0, 0
    for number in range(updates):
        tried = candidates[number], checks[number], trials[number]
        outside = decide(position, velocity, targets, arrived, stepped, wanted, rules, *tried)
        if outside >= 0:
            position[outside] = stepped[outside]
            overflow, overflown = POSITION_OVERFLOW, outside
        else:
            overflow, overflown = act(position, velocity, sums, errors, wanted, rules)
        if overflow != 0:
            return number, positions, velocities, candidates, checks, trials, overflow, overflown
        positions[number], velocities[number] = position, velocity
        if at_rest(velocity, arrived):
            return number + 1, positions, velocities, candidates, checks, trials, 0, 0
    return updates, positions, velocities, candidates, checks, trials, 0, 0


_HALVINGS = 64
"""More than halve an interval of doubles within [0, 1] down to neighbours."""


def pair_gaps(
    cells: NDArray[np.float64], speeds: NDArray[np.float64], seconds: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Least distance between the centres of each pair over a run, cells, float64, one value a pair.

    ``cells``: float64 (m + 1) × n × 2, the ends of m legs. ``speeds``: float64 (m + 1) × n × 2, the velocities there,
    cells/s. ``seconds``: float64 m, the time of each leg.

    On a leg a robot moves with constant acceleration (equation 2b): r(s) = r0 + v0 T s + (r1 - r0 - v0 T) s² for s
    from 0 to 1, through both its ends. So the squared distance of a pair is a quartic in s. Its least value lies at an
    end of the leg or at a root of its derivative, a cubic.
    """
    count = cells.shape[1]
    least = np.empty(count * (count - 1) // 2)
    _pair_gaps(cells, speeds, seconds, least)
    return least


def first_touches(
    before: NDArray[np.float64], after: NDArray[np.float64], drift: NDArray[np.float64], limit: float
) -> NDArray[np.float64]:
    """The moment on one leg when the centres of each pair first come nearer than ``limit`` (cells), as a share of it.

    ``before``, ``after``: float64 n × 2, the ends of the leg, cells. ``drift``: float64 n × 2, v0 T of ``pair_gaps``:
    where the velocities at its begin alone would lead, cells. Float64, one value a pair; infinity where they stay away.
    """
    count = len(before)
    first = np.empty(count * (count - 1) // 2)
    _first_touches(before, after, drift, limit, first)
    return first


@njit(cache=True, nogil=True)
def _pair_gaps(cells: Any, speeds: Any, seconds: Any, least: Any) -> None:
    legs, count = len(seconds), cells.shape[1]
    pair = 0
    for robot in range(count - 1):
        for other in range(robot + 1, count):
            x, y = cells[0, other, 0] - cells[0, robot, 0], cells[0, other, 1] - cells[0, robot, 1]
            best = math.sqrt(x * x + y * y)
            for leg in range(legs):
                # The relative motion of the pair: a + b s + c s².
                ax, ay = (cells[leg, other, 0] - cells[leg, robot, 0], cells[leg, other, 1] - cells[leg, robot, 1])
                bx = (speeds[leg, other, 0] - speeds[leg, robot, 0]) * seconds[leg]
                by = (speeds[leg, other, 1] - speeds[leg, robot, 1]) * seconds[leg]
                ex, ey = (
                    cells[leg + 1, other, 0] - cells[leg + 1, robot, 0],
                    cells[leg + 1, other, 1] - cells[leg + 1, robot, 1],
                )
                cx, cy = ex - ax - bx, ey - ay - by
                # |a + b s + c s²| ≥ |a| - |b| - |c|: most legs cannot come nearer than the best so far.
                away = math.sqrt(ax * ax + ay * ay)
                away -= math.sqrt(bx * bx + by * by) + math.sqrt(cx * cx + cy * cy)
                if away < best:
                    best = min(best, _nearest(ax, ay, bx, by, cx, cy), math.sqrt(ex * ex + ey * ey))
            least[pair] = best
            pair += 1


@njit(cache=True, nogil=True)
def _nearest(ax: Any, ay: Any, bx: Any, by: Any, cx: Any, cy: Any) -> Any:
    """The least |a + b s + c s²| for s from 0 to 1."""
    best = math.inf
    for s in _candidates(ax, ay, bx, by, cx, cy):
        best = min(best, _distance(ax, ay, bx, by, cx, cy, s))
    return best


@njit(cache=True, nogil=True)
def _candidates(ax: Any, ay: Any, bx: Any, by: Any, cx: Any, cy: Any) -> Any:
    """Values of s in rising order, from 0 to 1: every minimum of |a + b s + c s²| is among them.

    Between two neighbours the distance falls at most once below any limit that the first is not below: it rises and
    then falls, or does one of the two.
    """
    ab, bc = ax * bx + ay * by, bx * cx + by * cy
    bb, ac, cc = bx * bx + by * by, ax * cx + ay * cy, cx * cx + cy * cy
    # Half the derivative of the square is g(s) = ab + (bb + 2 ac) s + 3 bc s² + 2 cc s³. Between the roots of g', which
    # are those of 6 cc s² + 6 bc s + (bb + 2 ac), it is monotone: at most one root in each of three intervals.
    slope = bb + 2.0 * ac
    turns = np.array([0.0, 1.0, 1.0, 1.0])
    inner = 9.0 * bc * bc - 6.0 * cc * slope
    if inner >= 0.0:
        # The stable form of the roots: no difference of nearly equal numbers.
        large = -(3.0 * bc + math.copysign(math.sqrt(inner), bc))
        first = large / (6.0 * cc) if cc > 0.0 else 2.0
        second = slope / large if large != 0.0 else 2.0
        turns[1], turns[2] = max(0.0, min(first, second, 1.0)), max(0.0, min(1.0, max(first, second)))
    #   |a + b s + c s²|²
    #     \      __                 four turns: 0, the two roots of g' (clipped into [0, 1]), 1
    #      \    /  \      /         between two of them g rises or falls throughout, so at most one
    #       \__/    \____/          minimum lies there, where g goes from below 0 to above
    #    0    |      |      1
    found = np.empty(10)
    count = 0
    for number in range(4):
        low = turns[number]
        found[count] = low
        count += 1
        if number == 3:
            break
        # A minimum lies where g rises through 0: bracketed by its signs, and halved until nothing is between.
        high = turns[number + 1]
        # g in Horner's form, at both ends and at the middles.
        if ab + low * (slope + low * (3.0 * bc + 2.0 * cc * low)) < 0.0 and (
            ab + high * (slope + high * (3.0 * bc + 2.0 * cc * high)) > 0.0
        ):
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                if middle <= low or middle >= high:
                    break
                if ab + middle * (slope + middle * (3.0 * bc + 2.0 * cc * middle)) < 0.0:
                    low = middle
                else:
                    high = middle
            found[count], found[count + 1] = low, high
            count += 2
    return found[:count]


@njit(cache=True, nogil=True)
def _first_touches(before: Any, after: Any, drift: Any, limit: Any, first: Any) -> None:
    count = len(before)
    pair = 0
    for robot in range(count - 1):
        for other in range(robot + 1, count):
            # The relative motion of the pair on the leg: a + b s + c s².
            ax, ay = before[other, 0] - before[robot, 0], before[other, 1] - before[robot, 1]
            bx, by = drift[other, 0] - drift[robot, 0], drift[other, 1] - drift[robot, 1]
            ex, ey = after[other, 0] - after[robot, 0], after[other, 1] - after[robot, 1]
            cx, cy = ex - ax - bx, ey - ay - by
            first[pair] = _first_touch(ax, ay, bx, by, cx, cy, limit)
            if math.sqrt(ex * ex + ey * ey) < limit:
                first[pair] = min(first[pair], 1.0)
            pair += 1


@njit(cache=True, nogil=True)
def _first_touch(ax: Any, ay: Any, bx: Any, by: Any, cx: Any, cy: Any, limit: Any) -> Any:
    """The least s from 0 to 1 with |a + b s + c s²| < limit; infinity where there is none."""
    # |a + b s + c s²| ≥ |a| - |b| - |c|: most pairs cannot come that near.
    away = math.sqrt(ax * ax + ay * ay) - math.sqrt(bx * bx + by * by) - math.sqrt(cx * cx + cy * cy)
    if away >= limit:
        return math.inf
    low = 0.0
    for candidate in _candidates(ax, ay, bx, by, cx, cy):
        if _distance(ax, ay, bx, by, cx, cy, candidate) < limit:
            # The distance passes the limit once between the last candidate, which is not below it, and this one.
            high = candidate
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                if middle <= low or middle >= high:
                    break
                if _distance(ax, ay, bx, by, cx, cy, middle) < limit:
                    high = middle
                else:
                    low = middle
            return high
        low = candidate
    return math.inf


@njit(cache=True, nogil=True)
def _distance(ax: Any, ay: Any, bx: Any, by: Any, cx: Any, cy: Any, s: Any) -> Any:
    x, y = ax + s * (bx + s * cx), ay + s * (by + s * cy)
    return math.sqrt(x * x + y * y)
