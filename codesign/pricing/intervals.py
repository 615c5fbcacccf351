"""The ends of the intervals of times and energy, on many machines side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from codesign.figures import Figure
from codesign.pricing.boards import Numbers
from codesign.pricing.machines import Played, Specs
from codesign.results.ledger import Ledger
from codesign.results.result import Power
from codesign.system.bind import System
from codesign.system.terms import TIMES, plan_terms

Ends = dict[str, tuple[Any, Any]]
"""By figure, the least and the greatest value: an entry a machine, or one number for all."""


@dataclass(frozen=True, eq=False)
class _Ran:
    """Machines after their run, as terms ask about them (``terms.Ran``). All have one part in each FPGA."""

    system: System
    specs: Specs

    def spec(self, name: str) -> Any:
        """The model of the first machine."""
        return self.specs.model(name)

    def figure(self, name: str, of: Callable[[Any], Figure]) -> Figure:
        """A figure of a component or link: arrays where the machines differ in it."""
        return self.specs.figure(name, of)

    def open_link(self, name: str) -> str:  # noqa: ARG002 - ``why_alone`` lets no such link in
        """No link is ever down or late."""
        return ""

    def claimed(self) -> bool:
        """No display takes cycles."""
        return False

    def share_of_memory(self, name: str) -> float:  # noqa: ARG002
        """No design works in an external memory."""
        return 0.0

    def wire_bits(self, name: str, bits: int) -> int:  # noqa: ARG002
        """Bits of a message: it has no checksum."""
        return bits

    def timeout(self, name: str) -> int:
        """Never asked: no message is sent again."""
        raise AssertionError(f"link {name} loses no message")


def intervals_of(
    system: System,
    specs: Specs,
    chosen: Numbers,
    played: Sequence[Played],
    of_starts: Sequence[int],
    powers: Mapping[str, Power],
) -> Ends:
    """The least and the greatest value of each time of a plan and of its energy, by figure.

    Args:
        system: that the machines are of. specs: of the ``chosen`` ones alone, which have one part in each FPGA.
        played: the requests that differ, on all machines. of_starts: the number of the request of each start.
        powers: of each FPGA on the chosen machines.
    """
    ledgers = [_of_some(each.ledger, chosen) for each in played]
    replans = played[0].first is not played[0].ledger
    first = _of_some(played[0].first, chosen) if replans else ledgers[0]
    requests = [ledgers[number] for number in of_starts]
    terms = plan_terms(_Ran(system, specs), first, requests, powers, ends_only=True)
    return dict(terms.intervals((*TIMES, "energy_j")))


def _of_some(ledger: Ledger, chosen: Numbers) -> Ledger:
    """The books of some of the machines."""
    some = Ledger()
    some.work = ledger.work
    for key, spent in ledger.spent.items():
        of_all: Any = spent
        some.spent[key] = of_all[chosen] if np.ndim(of_all) else of_all
    return some
