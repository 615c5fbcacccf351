"""The demand of a design on an FPGA, of each part and at each clock that many machines have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import Figure, Status
from codesign.ground.memo import Same
from codesign.ground.models import Part
from codesign.inputs.components import FpgaComponent
from codesign.inputs.library import CalibrationFile
from codesign.planners.job import Demand
from codesign.study.pricing.machines import Column, Specs
from codesign.system.bind import Design, System
from codesign.system.fit import Laws, clock_reason, fit_part, laws_of
from codesign.system.results.result import BoundUse, Reason, ResourceUse
from codesign.system.terms import is_quoted

Numbers = NDArray[np.intp]

PartUse = tuple[tuple[ResourceUse, ...], tuple[BoundUse, ...], tuple[Reason, ...]]
"""See ``fit_part``."""

FORMS = 4
"""How many numbers ``Use.form`` may be."""

NOTHING = Figure(0, "W", Status.ASSUMED, "no task is on it")


@dataclass(frozen=True, eq=False)
class Use:
    """What a design takes of a part with a calibration, at some clocks.

    - ``fit``: the resources, the other limits, and why the design does not fit.
    - ``powers``: static and dynamic power at each clock; ``watts``: as float64, clocks × 2 × value, least and greatest.
    - ``form``: of each clock a number; where it is the same, terms have the same inputs.
    - ``too_fast``: why each clock is, or None.
    """

    part: Part
    fit: PartUse
    powers: Sequence[tuple[Figure, Figure]]
    watts: Column
    form: Numbers
    too_fast: Sequence[Reason | None]

    @classmethod
    def of(
        cls, part: Part, fit: PartUse, powers: Sequence[tuple[Figure, Figure]], too_fast: Sequence[Reason | None]
    ) -> Use:
        """A use with its numbers."""
        watts = np.array([[(each.value, *each.interval) for each in pair] for pair in powers], np.float64)
        form = [(dynamic.value != 0) + 2 * is_quoted(part.dynamic_power, dynamic) for _, dynamic in powers]
        return cls(part, fit, powers, watts, np.array(form, np.intp), too_fast)


@dataclass(frozen=True, eq=False)
class Board:
    """The use of one FPGA by a design.

    - ``kind``: of each model, the number of its kind: a part and a calibration. ``uses``: by kind.
    - ``powers``, ``watts``, ``form``, ``too_fast``: of each model, see ``Use``.
    """

    kind: Numbers
    uses: Sequence[Use]
    powers: Sequence[tuple[Figure, Figure]]
    watts: Column
    form: Numbers
    too_fast: Sequence[Reason | None]

    def use(self, model: int) -> Use:
        """The use by a machine with one of the models."""
        return self.uses[int(self.kind[model])]

    def drawn(self, which: Numbers) -> tuple[Column, Column]:
        """Static and dynamic power of each machine, W."""
        static, dynamic = self.watts[which, :, 0].T
        return static, dynamic


def boards_of(system: System, specs: Specs) -> dict[str, Board]:
    """The use of every FPGA of a platform, by name."""
    designs = system.designs
    return {name: _board(designs.get(name), specs.models[name]) for name in system.platform.of(FpgaComponent)}


def _board(design: Design | None, models: Sequence[Any]) -> Board:
    kind, place, firsts, clocks = _kinds(Same(models))
    uses = []
    for first, own in zip(firsts, clocks, strict=True):
        part = models[first].chip
        if design is None:
            uses.append(Use.of(part, ((), (), ()), [(part.static_power, NOTHING)] * len(own), [None] * len(own)))
            continue
        laws, placed = laws_of(design.style, models[first], design.task), replace(design.job, part=part)
        demand = laws.demand(placed)
        demands = Same(demand), Same(laws.power_demand(placed, demand))
        law = Same(laws.style), Same(part), Same(laws.calibration)
        uses.append(_use(*law, *demands, laws.clock_limit(placed), own))
    powers, too_fast = (list(chain(*each)) for each in zip(*((use.powers, use.too_fast) for use in uses), strict=True))
    return Board(
        kind,
        uses,
        [powers[each] for each in place],
        np.concatenate([use.watts for use in uses])[place],
        np.concatenate([use.form for use in uses])[place],
        [too_fast[each] for each in place],
    )


@lru_cache(maxsize=64)
def _kinds(of: Same[Sequence[Any]]) -> tuple[Numbers, Numbers, list[int], list[tuple[int, ...]]]:
    """The kind of each model; its place among all, kind by kind; the first model of each kind, and its clocks, Hz."""
    keys = [(each.chip.full_name, None if each.calibrated is None else each.calibrated.name) for each in of.it]
    numbers = {key: number for number, key in enumerate(dict.fromkeys(keys))}
    kind = np.array([numbers[key] for key in keys], np.intp)
    members = [np.flatnonzero(kind == number).tolist() for number in numbers.values()]
    place = np.argsort(np.concatenate(members)).astype(np.intp)
    clocks = [tuple(int(of.it[each].clock.value) for each in own) for own in members]
    return kind, place, [own[0] for own in members], clocks


@lru_cache(maxsize=1024)
def _use(
    style: Same[Any],
    part: Same[Part],
    calibration: Same[CalibrationFile | None],
    demand: Same[Demand],
    of_power: Same[Demand],
    limit: Figure,
    clocks: tuple[int, ...],
) -> Use:
    """The use by a design that takes ``demand``; styles give many designs one demand."""
    laws = Laws(style.it, part.it, calibration.it)
    return Use.of(
        part.it,
        fit_part(demand.it, part.it),
        [laws.power(of_power.it, clock) for clock in clocks],
        [clock_reason(clock, limit) for clock in clocks],
    )
