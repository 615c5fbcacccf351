"""One machine after its run, as the terms of its plan ask about it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from codesign.figures import Figure
from codesign.system.bind import System

if TYPE_CHECKING:
    from codesign.system.build import Machine


class RanMachine:
    """A machine after its run; see ``terms.Ran``."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.system = machine, machine.system

    def spec(self, name: str) -> Any:
        """The spec of a component or link."""
        return spec_of(self.system, name)

    def figure(self, name: str, of: Callable[[Any], Figure]) -> Figure:
        """A figure of the spec of a component or link."""
        return of(self.spec(name))

    def open_link(self, name: str) -> str:
        """Why the time of the messages of a link is no sum of terms; "" where it is one."""
        links = self.system.platform.links
        if links[name].outages:
            return f"link {name} is down at certain times"
        if self.machine.links[name].late:
            return f"messages of link {name} arrive late"
        ends = set(links[name].between)
        if sum(len(ends & set(link.between)) > 1 for link in links.values()) > 1:
            return f"of link {name} and those beside it each message takes the fastest"
        return ""

    def claimed(self) -> bool:
        """Whether a display takes cycles of a memory that the design works in."""
        if self.system.part is None:
            return False
        fpga = self.machine.planning_component
        memories = (fpga.block_ram, fpga.external)
        return any(memory is not None and memory.claims is not None for memory in memories)

    def share_of_memory(self, name: str) -> float:
        """The share of the busy time of the FPGA that plans in which an external memory works."""
        memory, fpga = self.machine.by_name[name].busy, self.machine.by_name[self.system.component].busy
        return memory / fpga if memory and fpga else 0.0

    def wire_bits(self, name: str, bits: int) -> int:
        """Bits of a message with its checksum."""
        return bits + int(self.machine.links[name].errors.checksum_bits)

    def timeout(self, name: str) -> int:
        """Picoseconds after which a link sends a message again."""
        return int(self.machine.links[name].errors.timeout)


def spec_of(system: System, name: str) -> Any:
    """The spec of a component or link of a system."""
    platform = system.platform
    return platform.links[name] if name in platform.links else platform.components[name]
