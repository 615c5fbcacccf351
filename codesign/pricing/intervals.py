"""The ends of the intervals of times and energy, on many machines side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from codesign.figures import Figure
from codesign.pricing.boards import Numbers
from codesign.pricing.machines import Column, Specs, half_bits_of
from codesign.results.ledger import Ledger
from codesign.results.result import Power
from codesign.scenarios.requests import Requests
from codesign.system.bind import System
from codesign.system.terms import TIMES, plan_terms

Ends = dict[str, tuple[Column, Column]]


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

    def sent_bits(self, name: str, bits: int) -> Any:
        """Bits on the wire of a serial link for a message, with those of its frames."""
        return half_bits_of(self.specs.model(name), bits) / 2

    def wire_bits(self, name: str, bits: int) -> int:  # noqa: ARG002
        """Bits of a message: it has no checksum."""
        return bits

    def timeout(self, name: str) -> int:
        """Never asked: no message is sent again."""
        raise AssertionError(f"link {name} loses no message")


def intervals_of(
    requests: Requests, specs: Specs, chosen: Numbers, powers: Mapping[str, Power], system: System
) -> Ends:
    """The least and the greatest value of each time of a plan and of its energy, by figure.

    Args:
        requests: of all machines. specs: of the ``chosen`` ones alone, which have one part in each FPGA.
        powers: of each FPGA on them.
        system: that they are of.
    """
    ledgers: dict[int, Ledger] = {}

    def own(ledger: Ledger) -> Ledger:
        if id(ledger) not in ledgers:
            copied = Ledger()
            copied.work = ledger.work
            for key, spent in ledger.spent.items():
                copied.spent[key] = spent[chosen] if np.ndim(spent) else spent
            ledgers[id(ledger)] = copied
        return ledgers[id(ledger)]

    terms = plan_terms(
        _Ran(system, specs),
        own(requests.first.before.ledger),
        [own(each) for each in requests.ledgers],
        powers,
    )
    ends = {name: terms.interval(name) for name in (*TIMES, "energy_j")}
    return {name: each for name, each in ends.items() if each is not None}
