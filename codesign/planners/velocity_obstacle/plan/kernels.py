"""The closed loop in fixed point, compiled: bit for bit equal to ``reference`` with ``arithmetic.fixed``.

The kernel differs from the plain text in three points, with the same answers. The step of the other robots is computed
once an update, not once a trial. Equation 4 is computed by Lagrange's identity, |r|²|V|² - (r·V)² = (r × V)². Both of
its sides, up to 110 bits at a width of 24, are compared as two words of 64 bits.
"""

from __future__ import annotations

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
def _choose(
    robot: Any,
    position: Any,
    velocity: Any,
    stepped: Any,
    target: Any,
    array: Any,
    bounds: Any,
    constants: Any,
    shifts: Any,
    approaching: Any,
    half: Any,
) -> Any:
    """Candidate, checks, trials, and the velocity that the candidate leads to."""
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
    array: Any,
    bounds: Any,
    constants: Any,
    shifts: Any,
    approaching: bool,
    half: bool,
    candidates: Any,
    checks: Any,
    trials: Any,
) -> Any:
    """Every robot's choice from one common state; writes arrived, stepped, wanted, candidates, checks and trials.

    Returns the robot that leaves the words of a position if it drives on for one step, or -1. The choices are valid in
    either case.
    """
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
            candidate, checks[robot], trials[robot], x, y = _choose(
                robot, position, velocity, stepped, targets, array, bounds, constants, shifts, approaching, half
            )
            wanted[robot, 0], wanted[robot, 1] = x, y
        if candidate < 0:
            # No safe velocity, or arrived: nearer to rest, each axis by itself.
            for axis in range(2):
                v = velocity[robot, axis]
                wanted[robot, axis] = v - max(-constants[BRAKE], min(constants[BRAKE], v))
        candidates[robot] = candidate
    return outside


@njit(cache=True, nogil=True)
def hold(position: Any, velocity: Any, steps: Any, constants: Any, shifts: Any) -> Any:
    """Drive all robots on for some steps with their velocities (equation 2b without acceleration).

    Returns the robot that first leaves its words and the number of that step, with ``position`` at that step; or
    (-1, 0).
    """
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
def act(position: Any, velocity: Any, sums: Any, errors: Any, wanted: Any, constants: Any, shifts: Any) -> Any:
    """One step in which every robot's PID control drives it to its wanted velocity.

    Returns the kind of value that first left its word (0: none), and the robot.
    """
    overflow, overflown = 0, 0
    for robot in range(len(position)):
        outside = _move(robot, wanted, position, velocity, sums, errors, constants, shifts)
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
    position: NDArray[np.int64],
    velocity: NDArray[np.int64],
    targets: NDArray[np.int64],
    arrived: NDArray[np.bool_],
    sums: NDArray[np.int64],
    errors: NDArray[np.int64],
    array: NDArray[np.int64],
    bounds: NDArray[np.int64],
    constants: NDArray[np.int64],
    shifts: NDArray[np.int64],
    approaching: bool,
    half: bool,
    updates: int,
) -> Any:
    """The closed loop of n robots for at most ``updates`` updates, each decided within its time step.

    ``position``, ``velocity``, ``sums``, ``errors``: int64 n × 2, left in the state at the end; ``targets`` likewise.
    ``array``: int64 speeds × directions × 2. ``bounds``: int64 k × 2.
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
        outside = decide(
            position,
            velocity,
            targets,
            arrived,
            stepped,
            wanted,
            array,
            bounds,
            constants,
            shifts,
            approaching,
            half,
            candidates[number],
            checks[number],
            trials[number],
        )
        if outside >= 0:
            position[outside] = stepped[outside]
            overflow, overflown = POSITION_OVERFLOW, outside
        else:
            overflow, overflown = act(position, velocity, sums, errors, wanted, constants, shifts)
        if overflow != 0:
            return number, positions, velocities, candidates, checks, trials, overflow, overflown
        positions[number], velocities[number] = position, velocity
        if at_rest(velocity, arrived):
            return number + 1, positions, velocities, candidates, checks, trials, 0, 0
    return updates, positions, velocities, candidates, checks, trials, 0, 0
