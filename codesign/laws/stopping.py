"""The law of stopping: how fast a body may move that sees so far, brakes so hard, and reacts so late.

It stops in time where v · T + v² / 2a <= R: v its speed, T its reaction time, a its deceleration, R the distance that
its sensor sees. Over any numbers: floats, fractions, arrays. Units are m, s, m/s and m/s².
"""

from __future__ import annotations

from dataclasses import dataclass

from codesign.laws.numbers import Number


def braking(speed: Number, brake: Number) -> Number:
    """The braking distance v² / 2a."""
    return speed**2 / (2 * brake)


@dataclass(frozen=True)
class Stopping:
    """A body: ``sight``, the distance R that its sensor sees, and ``brake``, its deceleration a; both above 0.

    >>> body = Stopping(sight=4.0, brake=2.0)
    >>> body.speed(0.0), body.reaction(4.0), body.reaction(2.0)
    (4.0, 0.0, 1.5)
    """

    sight: Number
    brake: Number

    def speed(self, reaction: Number) -> Number:
        """The greatest speed with which it stops in time: a (√(T² + 2R / a) - T).

        Written as a quotient, which loses no digits where T² is much larger than 2R / a.
        """
        return 2 * self.sight / (reaction + (reaction * reaction + 2 * self.sight / self.brake) ** 0.5)

    def reaction(self, speed: Number) -> Number:
        """The longest reaction time with which it stops in time, R / v - v / 2a: the inverse of ``speed``.

        Below 0 no reaction is quick enough.
        """
        return self.sight / speed - speed / (2 * self.brake)

    def distance(self, speed: Number, reaction: Number) -> Number:
        """The distance from an obstacle's appearance to rest: v · T + v² / 2a."""
        return speed * reaction + braking(speed, self.brake)

    def needed_brake(self, speed: Number, reaction: Number) -> Number:
        """The deceleration with which it stops in time; of use where v · T is less than its sight."""
        return speed**2 / (2 * (self.sight - speed * reaction))


@dataclass(frozen=True)
class Loop:
    """The loop of sensor, planner and brakes: ``period`` of the sensor's scans, and ``delay`` of all the rest.

    A plan takes the newest scan. If it ends before the next scan, the next plan waits for that. If it takes longer than
    a period, the next plan follows at once: plans run back to back. A period of 0 is a sensor that always sees.

    >>> loop = Loop(period=0.1, delay=0.0)
    >>> loop.reaction(0.05), loop.reaction(0.2)
    (0.15000000000000002, 0.5)
    """

    period: Number
    delay: Number

    def reaction(self, plan: Number) -> Number:
        """The worst time from an obstacle's appearance to the brakes, for plans that take so long.

        The obstacle appears just after a scan: a period is lost. Then its plan is computed. Where plans run back to
        back, one that began just before the next scan has to end first, which takes as long again.
        """
        return self.period + self.delay + plan * (1 + (plan > self.period))

    def plan(self, reaction: Number) -> Number:
        """The longest plan with this worst reaction; below 0 none: sensor and delay alone take longer."""
        left = reaction - self.period - self.delay
        return max(min(left, self.period), left / 2) if left > 0 else left
