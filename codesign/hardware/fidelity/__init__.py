"""The reach of the model: laws against circuits that were simulated, synthesised and placed, and against papers.

``measure`` runs the circuits and reads the rows. Nothing is left out because it does not fit: what does not match has a
reason and an experiment in ``reasons``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path

import yaml
from more_itertools import map_reduce

from codesign.ground.units import counted
from codesign.hardware.fidelity.claims import Claim, claims
from codesign.hardware.fidelity.points import TOTAL, Point, points, rooms, width_of
from codesign.hardware.rtl.verify import Asked, Checked, StyleChecked, samples, verify_all
from codesign.planners.measured import PARTS
from codesign.system import catalog

# What does not match: the errors of the laws by term, and the terms beyond their tolerance.

MEAN, WORST = 0.05, 0.10
"""The errors that LUT and flip-flops may have on designs that are not fitted; block RAMs and multipliers have none."""
CLOCK_WIDTH = 0.15
"""Half of the interval that a clock may have."""
CLAIMED = 0.05
"""The difference that circuit and paper may have."""
EXACT = "block_rams", "multipliers"


@dataclass(frozen=True)
class Spread:
    """The errors of one term: relative, law over measured less 1.

    - ``family``: of rows; "" for all. ``line``: of the demand; ``all`` for the sum of the lines.
    - ``fitted``, ``held``: the sizes of the errors of the rows that the law was fitted to, and of the others.
    - ``least``, ``most``: the smallest and the largest ratio of law and measured; None where nothing was measured.
    - ``part``: of a clock; otherwise "".
    """

    planner: str
    style: str
    family: str
    part: str
    line: str
    quantity: str
    fitted: tuple[float, ...]
    held: tuple[float, ...]
    least: float | None
    middle: float | None
    most: float | None

    @property
    def beyond(self) -> bool:
        """True if a resource is off by more than its tolerance on the rows held out, or on all where none is."""
        errors = self.held or self.fitted
        if self.quantity in EXACT:
            return max(self.fitted + self.held) > 0
        return sum(errors) / len(errors) > MEAN or max(errors) > WORST


def spread(points: Sequence[Point], family: str = "") -> Spread:
    """The errors of points of one term."""
    first = points[0]
    ratios = sorted(point.predicted.value / point.measured for point in points if point.measured)
    return Spread(
        planner=first.planner,
        style=first.style,
        family=family,
        part=first.part if first.quantity == "clock" else "",
        line=first.line,
        quantity=first.quantity,
        fitted=tuple(abs(point.error) for point in points if not point.held),
        held=tuple(abs(point.error) for point in points if point.held),
        least=ratios[0] if ratios else None,
        middle=ratios[len(ratios) // 2] if ratios else None,
        most=ratios[-1] if ratios else None,
    )


def spreads(points: Sequence[Point], *, by_family: bool) -> tuple[Spread, ...]:
    """The errors of each term of resources, of each family or of all families together."""
    counted = [point for point in points if point.quantity != "clock"]
    groups = map_reduce(
        counted,
        lambda point: (point.planner, point.style, point.family if by_family else "", point.line, point.quantity),
    )
    return tuple(spread(group, key[2]) for key, group in groups.items())


@dataclass(frozen=True)
class Mismatch:
    """Something that does not match, or that nothing was measured of: ``key`` for its reason, and in ``words``."""

    key: str
    words: str


def mismatches(
    points: Sequence[Point], claims: Sequence[Claim], checked: Sequence[StyleChecked]
) -> tuple[Mismatch, ...]:
    """All of them: cycles, lines of demands, clocks, papers, and what was never measured."""
    return (
        *_of_cycles(checked),
        *_of_lines(points),
        *_of_clocks(points),
        *_of_claims(claims),
        *_never_measured(points),
    )


def _of_cycles(checked: Sequence[StyleChecked]) -> Iterator[Mismatch]:
    for each in checked:
        if not each.equal or each.deviation:
            words = f"{sum(point.differences for point in each.verified)} differences, {each.deviation:.1%} mean"
            yield Mismatch(f"cycles/{each.planner}/{each.style}", words)


def _of_lines(points: Sequence[Point]) -> Iterator[Mismatch]:
    for each in spreads(points, by_family=False):
        if each.line != TOTAL and each.beyond:
            errors = each.held or each.fitted
            words = f"{sum(errors) / len(errors):.1%} mean, {max(errors):.1%} worst"
            key = f"resources/{each.planner}/{each.style}/{each.line}/{each.quantity}"
            yield Mismatch(key, words)


def _of_clocks(points: Sequence[Point]) -> Iterator[Mismatch]:
    clocks = [point for point in points if point.quantity == "clock"]
    groups = map_reduce(clocks, lambda point: (point.planner, point.style, point.part))
    for (planner, style, part), group in groups.items():
        outside = sum(not point.holds for point in group)
        widest = max(width_of(point.predicted) for point in group)
        if outside:
            yield Mismatch(
                f"clock/outside/{planner}/{style}/{part}", f"{outside} of {len(group)} medians outside the interval"
            )
        alone = sum(point.without is None for point in group)
        if alone:
            yield Mismatch(f"clock/alone/{planner}/{style}/{part}", f"{alone} of {len(group)} medians")
        if widest > CLOCK_WIDTH:
            yield Mismatch(f"clock/wide/{planner}/{style}/{part}", f"interval of ±{widest:.0%}")


def _of_claims(claims: Sequence[Claim]) -> Iterator[Mismatch]:
    worst: dict[str, float] = {}
    for claim in claims:
        if claim.error is not None:
            worst[claim.name] = max(worst.get(claim.name, 0.0), claim.error, key=abs)
    for name, error in worst.items():
        if abs(error) > CLAIMED:
            yield Mismatch(f"paper/{name}", f"{error:+.0%}")


def _never_measured(points: Sequence[Point]) -> Iterator[Mismatch]:
    """Families of rows without a synthesis or a placement, by planner."""
    families = dict.fromkeys(PARTS.values())
    placed = {point.family for point in points if point.quantity == "clock"}
    for family in families:
        if family not in placed:
            yield Mismatch(f"never placed/{family}", "no placement of any style")
    for planner in rooms():
        synthesised = {point.family for point in points if point.planner == planner and point.quantity != "clock"}
        for family in families:
            if family not in synthesised:
                yield Mismatch(f"never synthesised/{planner}/{family}", "no synthesis")
    yield Mismatch("never measured/power", "no board was measured")


# Why something does not match, and the experiment that would settle it: one table, by what it explains.


@dataclass(frozen=True)
class Reason:
    """The reason of a mismatch.

    - ``what``: a pattern of the keys of mismatches. ``why``, and the ``experiment``: sentences.
    - ``shown``: what shows ``why``: a file, a command, or how the law is made. "" if nothing does.
    """

    what: str
    why: str
    experiment: str
    shown: str = ""

    @property
    def words(self) -> str:
        """The cause, with what shows it; or as a likely one."""
        return f"{self.why} (shown by {self.shown})" if self.shown else f"Likely: {self.why}"


REASONS = tuple(Reason(**each) for each in yaml.safe_load(Path(__file__).with_name("reasons.yaml").read_text("utf-8")))


def reason_of(mismatch: Mismatch) -> Reason | None:
    """The first reason that explains a mismatch."""
    return next((reason for reason in REASONS if fnmatchcase(mismatch.key, reason.what)), None)


def idle(mismatches: Sequence[Mismatch]) -> tuple[Reason, ...]:
    """The reasons that explain no mismatch any more."""
    used = {reason_of(mismatch) for mismatch in mismatches}
    return tuple(reason for reason in REASONS if reason not in used)


__all__ = ["Claim", "Fidelity", "Mismatch", "Point", "Reason", "Spread", "asked", "measure", "reason_of"]

SAMPLES, QUICK_SAMPLES = 10, 2
"""Random design points of each circuit that are simulated."""


@dataclass(frozen=True, eq=False, repr=False)
class Fidelity:
    """All that was compared: ``cycles`` by simulation, ``points`` of the rows, ``claims`` of the papers."""

    cycles: tuple[StyleChecked, ...]
    points: tuple[Point, ...]
    claims: tuple[Claim, ...]

    def __repr__(self) -> str:
        points, claims = counted(len(self.points), "point"), counted(len(self.claims), "claim")
        return f"Fidelity({counted(len(self.cycles), 'style')}, {points}, {claims})"

    @cached_property
    def mismatches(self) -> tuple[Mismatch, ...]:
        """Whatever does not match."""
        return mismatches(self.points, self.claims, self.cycles)

    @cached_property
    def by_family(self) -> tuple[Spread, ...]:
        """The errors of resources by family and line."""
        return spreads(self.points, by_family=True)

    @cached_property
    def by_line(self) -> tuple[Spread, ...]:
        """The errors of resources by line, over all families."""
        return spreads(self.points, by_family=False)


def asked(seeds: Sequence[int]) -> list[Asked]:
    """The design points that are simulated."""
    return samples(catalog.circuits().values(), seeds)


def measure(
    seeds: Sequence[int], backend: str = "cxxrtl", jobs: int = 1, progress: Callable[[Checked], None] = lambda _: None
) -> Fidelity:
    """Simulate the samples of these seeds, and compare all rows with the laws.

    ``progress`` is called after each sample.

    Raises:
        MissingToolError: a tool is not installed.
    """
    return compared(verify_all(asked(seeds), backend, jobs, progress))


def compared(cycles: tuple[StyleChecked, ...]) -> Fidelity:
    """The comparison with these simulations."""
    rows = points()
    return Fidelity(cycles, rows, claims(rows))
