"""The demand of a design on an FPGA, of each part and at each clock that many machines have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import Figure, Status
from codesign.ground.memo import Same
from codesign.ground.models import Part
from codesign.inputs.components import FpgaComponent
from codesign.planners.job import Demand
from codesign.study.pricing.machines import Column, Specs
from codesign.system.bind import Design, System
from codesign.system.fit import Laws, clock_reason, fit_part, laws_of
from codesign.system.results.result import BoundUse, Power, Reason, ResourceUse

Numbers = NDArray[np.intp]

PartUse = tuple[tuple[ResourceUse, ...], tuple[BoundUse, ...], tuple[Reason, ...]]
"""See ``fit_part``."""

NOTHING = Figure(0, "W", Status.ASSUMED, "no task is on it")


@dataclass(frozen=True, eq=False)
class Board:
    """The use of one FPGA by a design.

    - ``kind``: of each model, the number of its kind: a part and a calibration. ``fits``: by kind, the resources,
      the other limits, and why the design does not fit. ``parts``: by kind.
    - ``powers``: static and dynamic power of each model. ``too_fast``: why its clock is, or None.
    """

    kind: Numbers
    parts: Sequence[Part]
    fits: Sequence[PartUse]
    powers: Sequence[Power]
    too_fast: Sequence[Reason | None]

    def watts(self, which: Numbers) -> tuple[Column, Column]:
        """Static and dynamic power of each machine, W."""
        static = np.array([power.static.value for power in self.powers], np.float64)
        dynamic = np.array([power.dynamic.value for power in self.powers], np.float64)
        return static[which], dynamic[which]


def boards_of(system: System, specs: Specs) -> dict[str, Board]:
    """The use of every FPGA of a platform, by name."""
    designs = system.designs
    return {name: _board(designs.get(name), specs.models[name]) for name in system.platform.of(FpgaComponent)}


def _board(design: Design | None, models: Sequence[Any]) -> Board:
    kinds: dict[Any, int] = {}
    kind: list[int] = []
    parts: list[Part] = []
    fits: list[PartUse] = []
    prices: list[tuple[Laws, Demand, Figure] | None] = []
    powers: list[Power] = []
    too_fast: list[Reason | None] = []
    for model in models:
        part = model.chip
        key = part.full_name, None if model.calibrated is None else model.calibrated.name
        if key not in kinds:
            kinds[key] = len(fits)
            parts.append(part)
            if design is None:
                fits.append(((), (), ()))
                prices.append(None)
            else:
                laws, own = laws_of(design.style, model, design.task), replace(design.job, part=part)
                demand = laws.demand(own)
                fits.append(_fit(Same(demand), Same(part)))
                prices.append((laws, laws.power_demand(own, demand), laws.clock_limit(own)))
        kind.append(kinds[key])
        price = prices[kinds[key]]
        if price is None:
            powers.append(Power(static=part.static_power, dynamic=NOTHING))
            too_fast.append(None)
            continue
        laws, demand, limit = price
        clock = int(model.clock.value)
        static, dynamic = laws.power(demand, clock)
        powers.append(Power.model_construct(static=static, dynamic=dynamic))
        too_fast.append(clock_reason(clock, limit))
    return Board(np.array(kind, np.intp), parts, fits, powers, too_fast)


@lru_cache(maxsize=256)
def _fit(demand: Same[Demand], part: Same[Part]) -> PartUse:
    """See ``fit_part``; styles give many designs one demand."""
    return fit_part(demand.it, part.it)
