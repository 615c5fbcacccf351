"""The ways that messages take over the links of a platform."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import NamedTuple

from codesign.inputs import Platform
from codesign.inputs.components import DisplayComponent, MemoryComponent


class Hop(NamedTuple):
    """One step of a way: the links that join its two ends, by name; none where one hangs on the other's pins."""

    links: tuple[str, ...]
    sender: str
    receiver: str


class Routes:
    """The ways between the components of a platform, over as few links as possible.

    Of equally short ways over other components the first is taken; of links side by side, who sends chooses.
    """

    def __init__(self, platform: Platform) -> None:
        import networkx

        self._graph = networkx.MultiGraph()
        self._graph.add_nodes_from(platform.components)
        for name, component in platform.components.items():
            if isinstance(component, MemoryComponent | DisplayComponent):
                self._graph.add_edge(name, component.beside, link=None)
        for name, link in platform.links.items():
            for index, end in enumerate(link.between):
                for other in link.between[index + 1 :]:
                    self._graph.add_edge(end, other, link=name)
        self.between = cache(self._between)

    def joined(self, origin: str, target: str) -> bool:
        """Whether any way leads from one component to the other."""
        import networkx

        return bool(networkx.has_path(self._graph, origin, target))

    def _between(self, origin: str, target: str) -> tuple[Hop, ...]:
        import networkx

        hops = pairwise(networkx.shortest_path(self._graph, origin, target))
        return tuple(Hop(self._links(a, b), a, b) for a, b in hops)

    def _links(self, one: str, other: str) -> tuple[str, ...]:
        names = [edge["link"] for edge in self._graph[one][other].values()]
        return () if None in names else tuple(sorted(names))
