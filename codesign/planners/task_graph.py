"""The tasks of a workload as a graph: the flows between tasks, with the size of each message.

Within one turn data flow in one direction: the graph is acyclic. The loop of a mission closes through the world,
between turns.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from codesign.errors import InputError

if TYPE_CHECKING:
    import networkx


@dataclass(frozen=True)
class Flow:
    """``bits`` from task ``sender`` to task ``receiver``, named ``name``; a message where they are placed apart."""

    sender: str
    receiver: str
    name: str
    bits: int


@dataclass(frozen=True)
class TaskGraph:
    """Tasks, and the flows between them.

    Raises:
        InputError: a flow that leads in a circle, or from or to no task of ``tasks``.
    """

    tasks: tuple[str, ...]
    flows: tuple[Flow, ...]

    def __post_init__(self) -> None:
        for flow in self.flows:
            for task in (flow.sender, flow.receiver):
                if task not in self.tasks:
                    raise InputError(f"{flow.name!r} flows from or to {task!r}, which is no task", "tasks")
        cycle = self._cycle()
        if cycle:
            raise InputError(
                f"tasks wait for each other in a circle: {' -> '.join((*cycle, cycle[0]))}",
                "tasks",
                "break it where one of them can go on without the other",
            )

    @property
    def networkx(self) -> networkx.MultiDiGraph[str]:
        """The graph with tasks as nodes, and flows as edges that carry ``name`` and ``bits``."""
        import networkx

        graph: networkx.MultiDiGraph[str] = networkx.MultiDiGraph()
        graph.add_nodes_from(self.tasks)
        for flow in self.flows:
            graph.add_edge(flow.sender, flow.receiver, name=flow.name, bits=flow.bits)
        return graph

    @cached_property
    def order(self) -> tuple[str, ...]:
        """The tasks in order: each after the tasks that it waits for, otherwise as listed."""
        import networkx

        place = {task: index for index, task in enumerate(self.tasks)}
        return tuple(networkx.lexicographical_topological_sort(self.networkx, key=place.__getitem__))

    def between(self, sender: str, receiver: str) -> tuple[Flow, ...]:
        """The flows from one task directly to another."""
        return tuple(flow for flow in self.flows if (flow.sender, flow.receiver) == (sender, receiver))

    def _cycle(self) -> list[str]:
        import networkx

        try:
            return [edge[0] for edge in networkx.find_cycle(self.networkx)]
        except networkx.NetworkXNoCycle:
            return []
