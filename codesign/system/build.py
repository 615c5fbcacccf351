"""Build: the SimPy components of a bound system, and the routes between them."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from codesign.records import Listener, Record
from codesign.spec.components import FpgaComponent, ProcessorComponent
from codesign.system.bind import System, asker_of

if TYPE_CHECKING:
    from codesign.architectures.interface import Step
    from codesign.components import BlockRam, Bus, ClockDomain, Component, Granularity


class Machine:
    """A platform come to life: its components on one simulation environment, and the clock of the mission.

    ``planner`` is the component that plans, ``asker`` the one that wants the plan (the first processor that is not the
    planner, or the planner itself). ``map_loaded``, ``planned`` and ``answered`` are set by the mission, ps.
    """

    def __init__(self, system: System, listeners: Sequence[Listener]) -> None:
        import simpy

        self.system = system
        self.environment = simpy.Environment()
        self._listeners = tuple(listeners)
        self.by_name = {name: self._component(name) for name in system.platform.components}
        self._links = {name: self._link(name) for name in system.platform.links}
        self.planner = self.by_name[system.component]
        self.asker_name = asker_of(system.platform, system.component)
        self._route = _route(system, self.asker_name, system.component)
        self._spent: dict[str, int] = {}
        self.map_loaded = self.planned = self.answered = 0

    @property
    def now(self) -> int:
        """The simulated time, ps."""
        return int(self.environment.now)

    @property
    def listening(self) -> bool:
        """Whether anybody listens."""
        return bool(self._listeners)

    @property
    def components(self) -> tuple[Component, ...]:
        """Components and links, in the order of the platform file, and the block RAMs of the planner."""
        ram = getattr(self.planner, "block_ram", None)
        return (*self.by_name.values(), *self._links.values(), *([ram] if ram is not None else []))

    @property
    def processors(self) -> list[tuple[Component, ProcessorComponent]]:
        """The processors with their specs."""
        specs = self.system.platform.components
        return [
            (component, spec)
            for name, component in self.by_name.items()
            if isinstance(spec := specs[name], ProcessorComponent)
        ]

    def tell(self, record: Record) -> None:
        """Hand a record of the run as a whole to every listener."""
        for listener in self._listeners:
            listener(record)

    def cycles(self) -> dict[str, int]:
        """Clock cycles of the planning component by phase."""
        if self.system.part is None:
            clock = self.planner.clock
            return {phase: clock.cycle_at_or_after(spent) for phase, spent in self._spent.items()}
        return {phase: use.cycles for phase, use in self.planner.phases.items()}

    def carry_to_planner(self, name: str, bits: int) -> Generator[Any, Any, None]:
        """Process generator: a message from the asker to the planner, over every link of the way."""
        yield from self._carry(name, bits, self._route)

    def carry_back(self, name: str, bits: int) -> Generator[Any, Any, None]:
        """Process generator: a message from the planner to the asker."""
        yield from self._carry(name, bits, [(link, to, of) for link, of, to in reversed(self._route)])

    def execute(
        self, steps: Generator[Step, None, Any], granularity: Granularity
    ) -> Generator[Any, Any, Any]:
        """Process generator: run the planner's steps on the planning component; returns the plan.

        On a processor a step is one task, and its cycles are units of its kernel, or else of the style's.
        """
        if self.system.part is not None:
            return (yield from self.planner.execute(steps, granularity))
        kernel = self.system.architecture.kernel
        while True:
            try:
                step = next(steps)
            except StopIteration as done:
                return done.value
            begin, units = self.now, int(step.cycles.sum())
            if units:
                yield from self.planner.execute(step.kernel or kernel, units, step.phase)
                self._spent[step.phase] = self._spent.get(step.phase, 0) + self.now - begin
            if self.listening and step.record is not None:
                self.tell(step.record(begin, self.now, self.planner.name))

    def _carry(self, name: str, bits: int, route: list[tuple[str, str, str]]) -> Generator[Any, Any, None]:
        for link, sender, receiver in route:
            yield from self._links[link].send(sender, receiver, name, bits)

    def _component(self, name: str) -> Any:
        from codesign.components import ClockDomain, Fpga, Processor

        spec = self.system.platform.components[name]
        clock = ClockDomain(int(spec.clock.value))
        if isinstance(spec, FpgaComponent):
            ram = self._block_ram(name, clock) if name == self.system.component else None
            return Fpga(self.environment, name, clock, self._listeners, ram)
        costs = {kernel: int(cost.value) for kernel, cost in spec.costs.items()}
        return Processor(self.environment, name, clock, costs, self._listeners)

    def _block_ram(self, name: str, clock: ClockDomain) -> BlockRam | None:
        """One block RAM for all of the design, which are driven alike, with what each holds."""
        from codesign.components import BlockRam, choose_shape

        system = self.system
        memory = system.architecture.memory(system.problem, system.planning)
        if memory is None or system.part is None:
            return None
        depth, width = choose_shape(system.part.block_ram_shapes, memory.width)
        ram = BlockRam(
            self.environment, f"{name}.block_ram", clock, depth=depth, width=width, listeners=self._listeners
        )
        for content, words in memory.words.items():
            ram.allocate(content, words)
        return ram

    def _link(self, name: str) -> Bus:
        from codesign.components import Bus, ClockDomain

        spec = self.system.platform.links[name]
        return Bus(
            self.environment,
            name,
            ClockDomain(int(spec.clock.value)),
            width=int(spec.width.value),
            setup_cycles=int(spec.setup_cycles.value),
            burst_words=int(spec.burst_words.value),
            listeners=self._listeners,
        )


def build(system: System, listeners: Sequence[Listener] = ()) -> Machine:
    """The components of ``system``, at time 0."""
    return Machine(system, listeners)


def _route(system: System, origin: str, target: str) -> list[tuple[str, str, str]]:
    """The links from ``origin`` to ``target`` as (link, sender, receiver), over as few links as possible.

    ``bind`` has refused a platform where there is no such way.
    """
    import networkx

    graph = networkx.MultiGraph()
    graph.add_nodes_from(system.platform.components)
    for name, link in system.platform.links.items():
        networkx.add_path(graph, link.between, link=name)
    hops = pairwise(networkx.shortest_path(graph, origin, target))
    return [(min(edge["link"] for edge in graph[a][b].values()), a, b) for a, b in hops]
