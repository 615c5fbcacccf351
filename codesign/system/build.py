"""Build: the SimPy components of a bound system, and what tasks and messages cost on them."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Mapping, Sequence
from typing import Any

from codesign import components
from codesign.ground.errors import CodesignError, SpecError
from codesign.ground.records import Listener, Record, TaskRecord, unwanted_by
from codesign.inputs.components import DisplayComponent, FpgaComponent, MemoryComponent
from codesign.planners.job import Flow
from codesign.planners.styles import Exchange, Step
from codesign.system.assemble import building_order, component_of, display_of, link_of, refused
from codesign.system.bind import System, planner_steps
from codesign.system.energy import joules
from codesign.system.messages import Content, LostMessageError, Messages, Routes
from codesign.system.results.ledger import BEGINS, CYCLES, Ledger, Spent

CONTROL, PLANNING, SIDE = 0, 10, 20
"""Priorities on a shared component, the most urgent lowest: the control loop goes before planning, and both before
the tasks that nothing waits for, also where all ask in the same picosecond (``components.channel``)."""


class Machine:
    """A platform come to life on one simulation environment.

    - ``by_name``: components, ``links``: links, by name. The robot of a drive is put in by its scenario, which knows
      where it stands.
    - ``planning_component``: the component that the planner (``System.planner``) runs on.
    """

    def __init__(self, system: System, listeners: Sequence[Listener], granularity: components.Granularity) -> None:
        """Build all but the robot.

        Raises:
            SpecError: a component refuses what planner and map ask of it, such as a display every cycle of a memory.
        """

        self.system = system
        self.granularity = granularity
        self.environment = components.Environment()
        self._listeners = tuple(listeners)
        self._unwanted = unwanted_by(self._listeners)
        self.by_name: dict[str, Any] = {}
        for name in building_order(system.platform):
            try:
                component = self._component(name)
            except CodesignError as wrong:
                spec = system.platform.components[name]
                raise SpecError([refused(system.platform, ("components", name), spec, wrong)]) from wrong
            if component is not None:
                self.by_name[name] = component
        self.links = {
            name: link_of(self.environment, name, link, self._listeners) for name, link in system.platform.links.items()
        }
        self.messages = Messages(system.placement.places, Routes(system.platform), self.links)
        self.planning_component = self.by_name[system.component]
        self._turns = {name: components.Turns(self.environment, name) for name in system.platform.of(FpgaComponent)}
        self._spent: dict[str, int] = {}

    @property
    def now(self) -> int:
        """The simulated time, ps."""
        return int(self.environment.now)

    @property
    def listening(self) -> bool:
        """True if there is a listener."""
        return bool(self._listeners)

    def wants(self, kind: type[Record]) -> bool:
        """True if a listener wants records of this class. Others are not built."""
        return bool(self._listeners) and kind not in self._unwanted

    def run(self, process: Generator[Any, Any, None]) -> None:
        """Run a process generator, and all that it sets going, to the end."""
        self.environment.process(process)
        self.environment.run()

    def another(self) -> Machine:
        """A machine of the same system at time 0, without listeners."""
        return build(self.system, (), self.granularity)

    def joules(self, boards: Mapping[str, tuple[float, float]]) -> dict[str, float]:
        """The parts of an energy up to now, by name; see ``energy.joules``."""
        return joules(self, boards)

    def watts(self, name: str) -> tuple[float, float]:
        """The draw of a processor, memory or link with declared power, W: while it works, and while it does not."""
        power = self.system.spec(name).power
        return power.busy.value, power.idle.value

    @property
    def claimed(self) -> bool:
        """True if a display takes cycles of a memory that the design works in."""
        if self.system.part is None:
            return False
        memories = (self.planning_component.block_ram, self.planning_component.external)
        return any(memory is not None and memory.claims is not None for memory in memories)

    @property
    def all_components(self) -> tuple[components.Component, ...]:
        """Components and links, in the order of the platform file, and the block RAMs of the planner."""
        ram = None if self.system.part is None else self.planning_component.block_ram
        ordered = [self.by_name[name] for name in self.system.platform.components if name in self.by_name]
        return (*ordered, *self.links.values(), *([ram] if ram is not None else []))

    @property
    def listeners(self) -> tuple[Listener, ...]:
        """The listeners."""
        return self._listeners

    def tell(self, record: Record) -> None:
        """Hand a record of the run as a whole to every listener, its places counted in the whole map."""
        record = record.moved(*self.system.problem.corner)
        for listener in self._listeners:
            listener(record)

    @property
    def messages_sent(self) -> int:
        """Messages handed to all links so far, those sent again included: the same at each granularity."""
        return sum(link.sent + link.retransmissions for link in self.links.values())

    def cycles(self) -> dict[str, int]:
        """Clock cycles of the planning component by phase."""
        if self.system.part is None:
            clock = self.planning_component.clock
            return {phase: clock.cycle_at_or_after(spent) for phase, spent in self._spent.items()}
        return {phase: use.cycles for phase, use in self.planning_component.phases.items()}

    def carry(
        self,
        flow: Flow,
        ledger: Ledger | None = None,
        *,
        bits: int | None = None,
        priority: int = CONTROL,
        content: Content | None = None,
    ) -> Generator[Any, Any, Any]:
        """Process generator: a message between two tasks, over every link between their components.

        ``bits``: its size, where it is not the flow's own. ``content``: what it carries; returned as the receiver reads
        it. Tasks on one component exchange nothing.

        Raises:
            LostMessageError: a link gave it up; with the link and its reason.
        """
        size = flow.bits if bits is None else bits
        return (yield from self.messages.carry(flow, ledger, size, priority, content))

    def plan(self, steps: Generator[Step, None, Any], ledger: Ledger | None = None) -> Generator[Any, Any, Any]:
        """Process generator: run the steps of the planner's style on its component; returns the plan."""
        kernel = self.system.architecture.kernel
        return (yield from self._run(self.system.component, steps, kernel, PLANNING, ledger))

    def perform(
        self, task: str, steps: Generator[Step, None, Any], ledger: Ledger | None = None, *, priority: int = CONTROL
    ) -> Generator[Any, Any, Any]:
        """Process generator: run the steps of a task's own style on its component; returns what the task makes."""
        placement = self.system.placement
        kernel = placement.styles[task].kernel
        return (yield from self._run(placement.places[task], steps, kernel, priority, ledger))

    def charge(
        self,
        task: str,
        kernel: str,
        units: int,
        ledger: Ledger | None = None,
        *,
        what: str = "",
        priority: int = CONTROL,
    ) -> Generator[Any, Any, None]:
        """Process generator: ``units`` of a kernel on the component of ``task``, where that is a processor.

        ``what``: what is done, in records and terms; by default the task. On an FPGA it takes no time.
        """
        name = self.system.placement.places[task]
        component = self.by_name[name]
        if not units or self.system.platform.components[name].kernels is None:
            return
        begin, spent = self.now, component.duration(kernel, units)
        yield from component.execute(kernel, units, what or task, priority=priority)
        if ledger is not None:
            ledger.book(Spent.COMPUTE, name, spent)
            ledger.count(name, what or task, kernel, units)
            ledger.book(Spent.WAIT, name, self.now - begin - spent)

    def follow_up(self, task: str) -> None:
        """Start the tasks of the user's own that come after ``task``, which has ended; nothing waits for them."""
        for extra in self.system.workload.tasks:
            if task in extra.after:
                self.environment.process(self._side_task(task, extra))

    def _side_task(self, task: str, extra: Any) -> Generator[Any, Any, None]:
        flow = Flow(task, extra.name, extra.name, extra.after[task])
        try:
            yield from self.carry(flow, priority=SIDE)
        except LostMessageError:
            return
        processor = self.by_name[self.system.placement.places[extra.name]]
        yield from processor.execute(extra.kernel, extra.units, extra.name, priority=SIDE)
        self.follow_up(extra.name)

    def _run(
        self, component: str, steps: Generator[Step, None, Any], kernel: str, priority: int, ledger: Ledger | None
    ) -> Generator[Any, Any, Any]:
        begin, ledger = self.now, Ledger() if ledger is None else ledger
        steps = planner_steps(self.system.planner, steps)
        before = ledger.total
        if component in self._turns:
            output = yield from self._on_fpga(component, steps, priority, ledger)
        else:
            output = yield from self._on_processor(component, steps, kernel, priority, ledger)
        # What was neither computed, sent nor waited for in a message's queue was waited for here.
        ledger.book(Spent.WAIT, component, self.now - begin - (ledger.total - before))
        return output

    def _on_fpga(
        self, name: str, steps: Generator[Step, None, Any], priority: int, ledger: Ledger
    ) -> Generator[Any, Any, Any]:
        fpga = self.by_name[name]
        with self._turns[name].turn(priority) as turn:
            yield turn
            while True:
                busy, before = fpga.busy, dict(fpga.phases)
                ledger.count(name, "", BEGINS, 1)
                try:
                    exchange, output = yield from fpga.execute(_until_exchange(steps), self.granularity)
                finally:
                    ledger.book(Spent.COMPUTE, name, fpga.busy - busy)
                    for phase, use in fpga.phases.items():
                        if use is not before.get(phase):
                            earlier = before[phase].cycles if phase in before else 0
                            ledger.count(name, phase, CYCLES, use.cycles - earlier)
                if exchange is None:
                    return output
                yield from self._exchange(exchange, ledger, priority)

    def _on_processor(
        self, name: str, steps: Generator[Step, None, Any], kernel: str, priority: int, ledger: Ledger
    ) -> Generator[Any, Any, Any]:
        """A step is one task, and its cycles are units of its kernel, or else of the style's.

        They count in ``cycles`` once all the steps are over: how far a run's end cuts into them is a matter of how
        finely they are reported, which listeners decide.
        """
        ended: dict[str, int] = {}
        try:
            output = yield from self._steps_on_processor(name, steps, kernel, priority, ledger, ended)
        except Exception:
            self._count(name, ended)
            raise
        self._count(name, ended)
        return output

    def _count(self, name: str, ended: dict[str, int]) -> None:
        if self.by_name[name] is self.planning_component:
            for phase, spent in ended.items():
                self._spent[phase] = self._spent.get(phase, 0) + spent

    def _steps_on_processor(
        self,
        name: str,
        steps: Generator[Step, None, Any],
        kernel: str,
        priority: int,
        ledger: Ledger,
        ended: dict[str, int],
    ) -> Generator[Any, Any, Any]:
        processor = self.by_name[name]
        while True:
            try:
                step = next(steps)
            except StopIteration as done:
                return done.value
            if isinstance(step, Exchange):
                yield from self._exchange(step, ledger, priority)
                continue
            begin, units, wanted = self.now, int(step.cycles.sum()), step.kernel or kernel
            if units:
                yield from processor.execute(wanted, units, step.phase, priority=priority)
                spent = processor.duration(wanted, units)
                ledger.book(Spent.COMPUTE, name, spent)
                ledger.count(name, step.phase, wanted, units)
                ended[step.phase] = ended.get(step.phase, 0) + spent
            wanted_record = step.record is not None and self.wants(step.makes)
            record = step.record(begin, self.now, processor.name) if wanted_record else None
            # The processor has reported its own record of the task.
            if record is not None and not (units and isinstance(record, TaskRecord)):
                self.tell(record)

    def _exchange(self, step: Exchange, ledger: Ledger, priority: int) -> Generator[Any, Any, None]:
        """The round trip of an ``Exchange``: a question, the other task, its answer. As urgent as its asker."""
        asker, task = self.system.planner.planning_task, step.to
        placement, system = self.system.placement, self.system
        request = Flow(asker, task, f"{task} request", step.bits)
        yield from self.carry(request, ledger, priority=priority)
        style = placement.styles[task]
        steps = style.steps(system.job)
        yield from self.perform(task, steps, ledger, priority=priority)
        answer = Flow(task, asker, f"{task} answer", step.answer_bits)
        yield from self.carry(answer, ledger, priority=priority)

    def _component(self, name: str) -> Any:

        system, platform = self.system, self.system.platform
        fpga, display = platform.of(FpgaComponent).get(name), platform.of(DisplayComponent).get(name)
        if fpga is not None and name == system.component:
            clock = components.ClockDomain(fpga.law.whole(fpga).rate())
            return components.Fpga(self.environment, name, clock, self._listeners, self._block_ram(name, clock))
        if display is not None:
            return self._display(name, display)
        component = component_of(self.environment, name, platform.components[name], self.by_name, self._listeners)
        if system.external is not None and system.external.name == name:
            self.by_name[platform.of(MemoryComponent)[name].beside].use(component)
        return component

    def _display(self, name: str, spec: DisplayComponent) -> Any:
        """A display; one beside an FPGA reads a pixel a cell from its block RAM, where it has one."""

        beside, problem = self.by_name[spec.beside], self.system.problem
        if not isinstance(beside, components.Fpga):
            return component_of(self.environment, name, spec, self.by_name, self._listeners)
        window = problem.rows, problem.columns
        return display_of(self.environment, name, spec, beside.block_ram, window, self._listeners)

    def _block_ram(self, name: str, clock: components.ClockDomain) -> components.BlockRam | None:
        """One block RAM for all of the design, which are driven alike, with what each holds."""

        system = self.system
        memory = system.architecture.memory(system.job)
        if memory is None or system.part is None:
            return None
        depth, width = components.choose_shape(system.part.block_ram_shapes, memory.width)
        ram = components.BlockRam(
            self.environment, f"{name}.block_ram", clock, depth=depth, width=width, listeners=self._listeners
        )
        for content, words in memory.words.items():
            ram.allocate(content, words)
        return ram


def build(system: System, listeners: Sequence[Listener], granularity: components.Granularity) -> Machine:
    """The components of ``system``, at time 0."""
    return Machine(system, listeners, granularity)


def _until_exchange(steps: Iterable[Step]) -> Generator[Step, None, tuple[Exchange | None, Any]]:
    """The steps up to the next exchange, which is returned; or to the end, with what the steps return."""
    source = iter(steps)
    while True:
        try:
            step = next(source)
        except StopIteration as done:
            return None, done.value
        if isinstance(step, Exchange):
            return step, None
        yield step
