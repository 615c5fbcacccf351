"""What every architecture style offers: how a planner is laid out on a component, and what that costs.

A style gives laws: pure functions with their sources. It is found through the entry-point group
``codesign.architectures`` (a sequence of styles an entry point); a user's own style plugs in the same way.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from codesign.figures import Figure, Status
from codesign.memo import Memo
from codesign.planners.interface import Problem
from codesign.spec.part import Part

RESOURCES = ("slices", "lut4", "flip_flops", "block_rams", "multipliers")
"""The kinds of resource a part is budgeted in. They are never added up over kinds."""


@dataclass(frozen=True)
class Item:
    """One line of a demand: what part of the design asks for how much of one resource, and by which law."""

    name: str
    resource: str
    amount: int
    status: Status
    source: str


@dataclass(frozen=True)
class Lever:
    """A change that would close a gap: the parameter to move, and to which value (or in which direction)."""

    parameter: str
    advice: str


@dataclass(frozen=True)
class Bound:
    """A limit that is no resource of the part but just as hard: word depth, clock.

    ``demand`` ≤ ``limit`` is feasible.
    """

    name: str
    demand: float
    limit: float
    unit: str
    status: Status
    source: str
    levers: tuple[Lever, ...] = ()


@dataclass(frozen=True)
class Demand:
    """What a design asks of a part: items by resource, the other bounds, and what would mend each shortage."""

    items: tuple[Item, ...]
    bounds: tuple[Bound, ...] = ()
    levers: dict[str, tuple[Lever, ...]] = field(default_factory=dict)

    def total(self, resource: str) -> int:
        """The sum over the items of one resource."""
        return sum(item.amount for item in self.items if item.resource == resource)


@dataclass(frozen=True)
class Step:
    """A run of clock cycles with nothing outside to wait for.

    ``cycles``: int64, one entry an indivisible unit of work (a visit, a pass), in order. ``record`` says how to tell
    listeners of it: called with (begin ps, end ps, source), only when somebody listens; None for a step with no story.
    ``phase`` names the phase that the cycles are booked under. ``ram_addresses``: addresses that each block RAM is
    given in every one of the cycles; all block RAMs of a design are driven alike. ``kernel``: on a processor, what the
    cycles are units of, where that is not the style's kernel.
    """

    phase: str
    cycles: NDArray[np.int64]
    record: Any = None
    ram_addresses: int = 0
    kernel: str = ""


@dataclass(frozen=True)
class Memory:
    """What stands in each of the design's block RAMs, which are driven alike: words of ``width`` bits by content."""

    width: int
    words: Mapping[str, int]


class Architecture(Protocol):
    """A style of one planner on one type of component."""

    @property
    def planner(self) -> str:
        """The planner's name."""

    @property
    def style(self) -> str:
        """The style's name in YAML."""

    @property
    def description(self) -> str:
        """How it lays the planner out, for ``hwsw list``: one line, no full stop at the end."""

    @property
    def component_type(self) -> str:
        """The type of component it runs on: ``fpga`` or ``processor``."""

    @property
    def kernel(self) -> str:
        """On a processor, the kernel that the platform gives a cost, and that cycles of steps are units of."""

    def demand(self, problem: Problem, parameters: Any, part: Part | None) -> Demand:
        """Resources and other bounds, as a vector with items; no feasibility is judged here.

        ``part`` is None on a processor, where only bounds count.
        """

    def clock_limit(self, problem: Problem, parameters: Any, part: Part) -> Figure:
        """The fastest clock the design of this size reaches on the part, Hz, with its interval."""

    def memory(self, problem: Problem, parameters: Any) -> Memory | None:
        """What the block RAMs hold; None where the style uses none."""

    def work(
        self, problem: Problem, parameters: Any, *, memo: Memo | None = None, detail: bool = True
    ) -> Generator[Step, None, Any]:
        """Steps to be run on a clock; returns the plan, the same that ``Planner.plan`` gives.

        Without ``detail`` nobody listens and nothing interrupts: steps may be as coarse as a whole stage, and what
        ``memo`` holds of it need not be computed again. The cycles add up to the same.
        """

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """Static and dynamic power at ``clock`` Hz, W, with their intervals."""
