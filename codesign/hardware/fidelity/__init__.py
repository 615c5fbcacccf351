"""The reach of the model: laws against circuits that were simulated, synthesised and placed, and against papers.

``measure`` runs the circuits and reads the rows. Nothing is left out because it does not fit: what does not match has a
reason and an experiment in ``reasons``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from codesign.ground.units import counted
from codesign.hardware.fidelity.claims import Claim, claims
from codesign.hardware.fidelity.mismatches import Mismatch, Spread, mismatches, spreads
from codesign.hardware.fidelity.points import Point, points
from codesign.hardware.fidelity.reasons import Reason, reason_of
from codesign.hardware.rtl.campaign import Asked, Checked, StyleChecked, samples, verify_all
from codesign.system import catalog

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
