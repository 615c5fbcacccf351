"""A design point predicted by the laws of its style, against its synthesis and its placements."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from codesign.ground.errors import InputError
from codesign.ground.figures import Figure
from codesign.hardware.rtl.cells import Counts
from codesign.hardware.rtl.place import DEVICES, Placement, device_of, place
from codesign.hardware.rtl.placed import Placed
from codesign.hardware.rtl.synthesis import Synthesis, synthesise
from codesign.planners import measured
from codesign.planners.job import Demand

_RESOURCES = tuple(Counts().by_resource())


@dataclass(frozen=True)
class LineCompared:
    """A line of the demand in one resource: what the law predicts, and what was synthesised.

    ``line`` "": modules that no line counts. None: the laws of the part do not speak of this family.
    """

    line: str
    resource: str
    predicted: int | None
    synthesised: int


@dataclass(frozen=True, eq=False)
class Compared:
    """All that is predicted and measured of a design point.

    ``law``: the clock limit of the style on the part, Hz. ``placements``: by seed; none without a placement.
    """

    part: str
    synthesis: Synthesis
    lines: tuple[LineCompared, ...]
    law: Figure
    placements: tuple[Placement, ...]
    notes: tuple[str, ...]

    @property
    def clock(self) -> float | None:
        """The median of the placements, Hz."""
        return statistics.median(each.clock for each in self.placements) if self.placements else None

    @property
    def median(self) -> Placement | None:
        """The placement of the median clock, or of the one below it."""
        by_clock = sorted(self.placements, key=lambda each: each.clock)
        return by_clock[(len(by_clock) - 1) // 2] if by_clock else None


def compared(
    design: Placed,
    family: str | None,
    seeds: Sequence[int],
    progress: Callable[[int, int, str], None] = lambda _done, _all, _what: None,
) -> Compared:
    """Synthesise a design point, place it once for each seed, and hold the laws against both.

    ``family``: of the part where it is None. ``progress`` is called with the runs of tools that are
    done, with their number, and with what begins.

    Raises:
        InputError: no open tool synthesises for the part, or places for it.
        MissingToolError: a tool is not installed.
        RunError: the circuit does not fit, or a tool fails.
    """
    part = design.part
    own, exact = measured.family_of(part.family)
    if family is None and not exact:
        hint = f"name a family that counts for it: --family {own}" if own else "name a family with --family"
        raise InputError(f"no open tool synthesises for {part.family}, of {part.full_name}", "--family", hint)
    name = family or own
    if seeds and device_of(part.full_name)[0].family != name:
        raise InputError(f"{part.full_name} is placed with family {own}, not {name}", "--place", "leave --family out")
    circuit = design.style.circuit(design.job)
    progress(0, 1 + len(seeds), f"runs, synthesis for {name}")
    synthesis = synthesise(circuit, name)
    demand, law = _laws(design)
    placements = []
    for done, seed in enumerate(seeds, 1):
        progress(done, 1 + len(seeds), f"runs, placement on {part.full_name}, seed {seed}")
        placements.append(place(circuit, part.full_name, seed))
    return Compared(
        part=part.full_name,
        synthesis=synthesis,
        lines=tuple(_lines(synthesis, demand if name == own and exact else None)),
        law=law,
        placements=tuple(placements),
        notes=tuple(_notes(design, name, own, synthesis)),
    )


def _laws(design: Placed) -> tuple[Demand, Figure]:
    """The demand and the clock limit that the style of the circuit predicts."""
    task = design.style.task
    style = design.system.placement.styles[task] if task else design.system.architecture
    return style.demand(design.job), style.clock_limit(design.job)


def _lines(synthesis: Synthesis, demand: Demand | None) -> list[LineCompared]:
    counted = {
        (line, kind): amount
        for line, counts in synthesis.pieces.items()
        for kind, amount in counts.by_resource().items()
    }
    predicted: dict[tuple[str, str], int] = {}
    for item in demand.items if demand is not None else ():
        if item.resource in _RESOURCES:
            key = item.name, item.resource
            predicted[key] = predicted.get(key, 0) + item.amount
    return [
        LineCompared(*key, None if demand is None else predicted.get(key, 0), counted.get(key, 0))
        for key in dict.fromkeys([*predicted, *counted])
        if predicted.get(key, 0) or counted.get(key, 0)
    ]


def _notes(design: Placed, family: str, own: str, synthesis: Synthesis) -> list[str]:
    notes = ["slices are a matter of packing, so they are not compared"]
    if family != own:
        notes.append(f"the laws speak of {design.part.full_name}, so they are not held against family {family}")
    if family == "xc7":
        notes.append("7 series: counts only, their open timing is not to be trusted; clocks come from reports")
        notes.append("LUT of six inputs are counted one for one, as the budget of the part counts them")
    elif family == "gowin" and synthesis.total.multipliers:
        notes.append("a clock of a Gowin part holds no path through a multiplier: nextpnr has no delays of one")
    elif design.part.name not in DEVICES:
        notes.append(f"no clock: {design.part.full_name} has no open place and route that is to be trusted")
    return notes
