"""Messages between tasks: the links that they go over, and what becomes of their content."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Mapping
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

from codesign import components
from codesign.ground.errors import CodesignError
from codesign.ground.late import late
from codesign.inputs import Platform
from codesign.planners.job import Flow
from codesign.system.results.ledger import RETRIES, Ledger, Spent

Wrong = tuple[int, ...]
"""Bits of a message that arrived wrong, from 0, in order."""


class LostMessageError(CodesignError):
    """A message that no retransmission brought to its receiver."""


class Content(Protocol):
    """The content of a message of which the simulation knows what its bits mean."""

    def misread(self, wrong: Wrong) -> Content | None:
        """The content that the receiver reads where these bits are wrong; None where it equals what was sent."""


class Hop(NamedTuple):
    """One step between two components: the links that join them, by name; none where one is on the other's pins."""

    links: tuple[str, ...]
    sender: str
    receiver: str


networkx = late("networkx")


class Routes:
    """The routes between the components of a platform, over as few links as possible.

    Of equally short routes over other components the first is taken. Of links side by side, the sender chooses.
    """

    def __init__(self, platform: Platform) -> None:
        self._graph = networkx.MultiGraph()
        self._graph.add_nodes_from(platform.components)
        for name, component in platform.components.items():
            if component.neighbour is not None:
                self._graph.add_edge(name, component.neighbour, link=None)
        for name, link in platform.links.items():
            for index, end in enumerate(link.between):
                for other in link.between[index + 1 :]:
                    self._graph.add_edge(end, other, link=name)
        self.between = cache(self._between)

    def joined(self, origin: str, target: str) -> bool:
        """True if any route leads from one component to the other."""
        return bool(networkx.has_path(self._graph, origin, target))

    def _between(self, origin: str, target: str) -> tuple[Hop, ...]:
        hops = pairwise(networkx.shortest_path(self._graph, origin, target))
        return tuple(Hop(self._links(a, b), a, b) for a, b in hops)

    def _links(self, sender: str, receiver: str) -> tuple[str, ...]:
        names = [edge["link"] for edge in self._graph[sender][receiver].values()]
        return () if None in names else tuple(sorted(names))


class Messages:
    """Carries the messages of a run.

    ``harmed``: by link and message, how many were delivered damaged and read as something else than was sent. All other
    unnoticed damage did no harm: see ``ignored``.
    """

    def __init__(self, places: Mapping[str, str], routes: Routes, links: Mapping[str, components.Link]) -> None:
        self.places, self.routes, self.links = places, routes, links
        self.harmed: Counter[tuple[str, str]] = Counter()

    def carry(
        self, flow: Flow, ledger: Ledger | None, bits: int, priority: int, content: Content | None
    ) -> Generator[Any, Any, Any]:
        """Process generator: a message over every link between two tasks; returns its content as it is read.

        Raises:
            LostMessageError: a link gave it up; with the link and its reason.
        """
        origin, target = self.places[flow.sender], self.places[flow.receiver]
        for hop in self.routes.between(origin, target) if origin != target else ():
            if not hop.links:
                continue
            link = self.fastest(hop, bits)
            delivery = yield from link.send(hop.sender, hop.receiver, flow.name, bits, priority)
            if ledger is not None:
                ledger.book(Spent.WAIT, link.name, delivery.queued)
                ledger.book(Spent.TRANSFER, link.name, delivery.transferred)
                ledger.count(link.name, flow.name, bits, delivery.attempts)
                if delivery.attempts > 1:
                    ledger.count(link.name, flow.name, RETRIES, delivery.attempts - 1)
            if delivery.reason is not None:
                what = f"message {flow.name!r} from {flow.sender} to {flow.receiver} was lost: {delivery.reason}"
                raise LostMessageError(what, link.name)
            read = content.misread(delivery.wrong) if content is not None and delivery.wrong else None
            if read is not None:
                content = read
                self.harmed[link.name, flow.name] += 1
        return content

    def fastest(self, hop: Hop, bits: int) -> components.Link:
        """Of links side by side the one that takes a message of ``bits`` bits the quickest; of equals the first."""
        name = min(hop.links, key=lambda each: (self.links[each].duration(bits), each))
        return self.links[name]

    def ignored(self, link: str) -> dict[str, int]:
        """By message: how many ``link`` delivered damaged, and were yet read as they were sent."""
        harmless = {name: count - self.harmed[link, name] for name, count in self.links[link].unnoticed.items()}
        return {name: count for name, count in sorted(harmless.items()) if count}
