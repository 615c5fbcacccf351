"""The critical path of a placed design, from the timing report of nextpnr: its parts in ns, and in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from codesign.ground.units import counted

MEMORY, FLIP_FLOP = "memory", "flip-flop"


@dataclass(frozen=True)
class CriticalPath:
    """The path that limits a clock. Times in ns.

    ``source``: what it begins at, a ``memory`` or a ``flip-flop``; ``source_ns`` from the clock to its output.
    ``begin``, ``end``: the registers, with the module of each in the source. ``levels``: the LUT and carries on it.
    """

    source: str
    source_ns: float
    levels: int
    logic_ns: float
    routing_ns: float
    setup_ns: float
    begin: str
    begin_module: str
    end: str
    end_module: str

    @property
    def total_ns(self) -> float:
        """The sum of the parts."""
        return self.source_ns + self.logic_ns + self.routing_ns + self.setup_ns

    @property
    def words(self) -> str:
        """The path as a sentence without a full stop."""
        share = self.routing_ns / self.total_ns
        return (
            f"from a {self.source} of {self.begin_module} to {self.end_module}: {self.source_ns:.2f} ns to the output,"
            f" {counted(self.levels, 'LUT level')} {self.logic_ns:.2f} ns, routing {self.routing_ns:.2f} ns"
            f" ({share:.0%}), setup {self.setup_ns:.2f} ns"
        )


def critical_path(
    report: Mapping[str, Any], kinds: Mapping[str, str], modules: Mapping[str, str]
) -> CriticalPath | None:
    """The longest path between two edges of the clock in a report; None where it has none.

    Args:
        report: of ``--report``.
        kinds: the type of each cell of the flat netlist, by name.
        modules: the module of the source of each instance, by its path.
    """
    paths = [
        entry["path"]
        for entry in report["critical_paths"]
        if all(str(entry[end]).startswith("posedge ") for end in ("from", "to"))
    ]
    if not paths:
        return None
    steps = max(paths, key=lambda path: sum(step["delay"] for step in path))
    begin, end = steps[0]["from"]["cell"], steps[-1]["to"]["cell"]
    source = MEMORY if _is_memory(kinds.get(begin, begin)) else FLIP_FLOP
    return CriticalPath(
        source=source,
        source_ns=_sum(steps, "clk-to-q", "source"),
        levels=sum(1 for step in steps if step["type"] == "logic"),
        logic_ns=_sum(steps, "logic"),
        routing_ns=_sum(steps, "routing"),
        setup_ns=_sum(steps, "setup"),
        begin=begin,
        begin_module=module_of(begin, modules),
        end=end,
        end_module=module_of(end, modules),
    )


def _sum(steps: Sequence[Mapping[str, Any]], *types: str) -> float:
    return round(sum(float(step["delay"]) for step in steps if step["type"] in types), 4)


def _is_memory(kind: str) -> bool:
    return kind.startswith(("DP16KD", "PDPW16KD", "SP", "SDP", "DP", "pROM"))


def module_of(cell: str, modules: Mapping[str, str]) -> str:
    """The module of the source that a cell of the flat netlist belongs to: that of the longest path it begins with.

    >>> module_of("circuit.nodes[3].node.sum_LUT4_Z", {"circuit": "top", "circuit.nodes[3].node": "node"})
    'node'
    """
    words = cell.split(".")
    prefixes = (".".join(words[:length]) for length in range(len(words) - 1, 0, -1))
    return next((modules[prefix] for prefix in prefixes if prefix in modules), "the top")
