"""The tasks of a workload as a graph: the flows between tasks, with the size of each message.

Within one turn data flow in one direction: the graph is acyclic. The loop of a mission closes through the world,
between turns.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from codesign.ground.errors import InputError
from codesign.ground.late import late

if TYPE_CHECKING:
    import networkx
else:
    networkx = late("networkx")


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
        cycle = _cycle(self.tasks, self._edges)
        if cycle:
            raise InputError(
                f"tasks wait for each other in a circle: {' -> '.join((*cycle, cycle[0]))}",
                "tasks",
                "break it where one of them can go on without the other",
            )

    @property
    def networkx(self) -> networkx.MultiDiGraph[str]:
        """The graph with tasks as nodes, and flows as edges that carry ``name`` and ``bits``."""
        graph: networkx.MultiDiGraph[str] = networkx.MultiDiGraph()
        graph.add_nodes_from(self.tasks)
        for flow in self.flows:
            graph.add_edge(flow.sender, flow.receiver, name=flow.name, bits=flow.bits)
        return graph

    @property
    def order(self) -> tuple[str, ...]:
        """The tasks in order: each after the tasks that it waits for, otherwise as listed."""
        return _order(self.tasks, self._edges)

    @property
    def _edges(self) -> tuple[tuple[str, str], ...]:
        return tuple((flow.sender, flow.receiver) for flow in self.flows)

    def between(self, sender: str, receiver: str) -> tuple[Flow, ...]:
        """The flows from one task directly to another."""
        return tuple(flow for flow in self.flows if (flow.sender, flow.receiver) == (sender, receiver))


# Every machine has a graph, and there are few shapes.
@lru_cache(maxsize=256)
def _cycle(tasks: tuple[str, ...], edges: tuple[tuple[str, str], ...]) -> tuple[str, ...]:
    if len(_order(tasks, edges)) == len(tasks):
        return ()
    # Imported for a mistake only: it takes longer than a thousand orders.
    graph: networkx.MultiDiGraph[str] = networkx.MultiDiGraph()
    graph.add_nodes_from(tasks)
    graph.add_edges_from(edges)
    return tuple(edge[0] for edge in networkx.find_cycle(graph))


@lru_cache(maxsize=256)
def _order(tasks: tuple[str, ...], edges: tuple[tuple[str, str], ...]) -> tuple[str, ...]:
    """The tasks in order; the tasks of a circle and those after it are left out."""
    order: list[str] = []
    while ready := [
        task
        for task in tasks
        if task not in order and all(sender in order for sender, receiver in edges if receiver == task)
    ]:
        order.append(ready[0])
    return tuple(order)
