"""The ways that messages take over the links of a platform."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import NamedTuple

from codesign.spec import Platform


class Hop(NamedTuple):
    """One link of a way: its name (None where a component hangs on another's pins), and its two ends."""

    link: str | None
    sender: str
    receiver: str


class Routes:
    """The ways between the components of a platform, over as few links as possible; of equals the first by name."""

    def __init__(self, platform: Platform) -> None:
        import networkx

        self._graph = networkx.MultiGraph()
        self._graph.add_nodes_from(platform.components)
        for name, component in platform.components.items():
            beside = getattr(component, "beside", None)
            if beside is not None:
                self._graph.add_edge(name, beside, link=None)
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
        return tuple(
            Hop(min((edge["link"] for edge in self._graph[a][b].values()), key=lambda name: name or ""), a, b)
            for a, b in hops
        )
