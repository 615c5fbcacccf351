"""The designs that a board is searched for: planner, style, placement and parameters.

Planners and styles come from the installed plug-ins, and so do the parameters: each style proposes its ``designs``.
A planner of another package takes part without an edit here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, count, islice
from typing import Any, TypeVar

from more_itertools import map_reduce

from codesign.ground.errors import CodesignError, InputError
from codesign.ground.figures import Figure, Price, age_text
from codesign.ground.files import date_of_writing
from codesign.ground.models import Part, TaskParameters
from codesign.ground.units import counted
from codesign.inputs import Platform, list_platforms, load_platform
from codesign.inputs.components import AnyComponent, FpgaComponent, MemoryComponent
from codesign.inputs.files import Source, is_path
from codesign.inputs.platform import Board as Sold
from codesign.inputs.platform import load_prices
from codesign.inputs.workload import PLACE_KEYS
from codesign.laws import Sum, as_sum, symbol
from codesign.laws.numbers import Ends
from codesign.planners.interface import LOAD, Planner, Problem
from codesign.planners.job import Demand, Job
from codesign.planners.plug_in import PlugIn
from codesign.planners.styles import Architecture, Designs, Family
from codesign.study.advice.needs import Needs, Where
from codesign.study.space import canonical
from codesign.system import catalog
from codesign.system.assemble import memory_law
from codesign.system.bind import planner_code
from codesign.system.fit import Laws, PartFit, fit, laws_of
from codesign.system.place import DETECT

T = TypeVar("T")

# The boards of the catalogue: which are asked about, what they cost, and what they draw while they wait.


@dataclass(frozen=True, eq=False)
class Board:
    """A platform that is asked about. ``source``: its shipped name or its file, as ``hwsw run`` takes it.

    ``own_prices``: the user's prices by platform, in place of what platforms declare.
    """

    source: str
    platform: Platform
    own_prices: Mapping[str, Price] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Its name in results."""
        return self.platform.name

    @property
    def price_usd(self) -> float | None:
        """Its price, with the price of the computer beside it; None if the platforms do not declare both."""
        prices = self.prices
        return None if prices is None else sum(float(price.value) for price in prices.values())

    @property
    def price_interval_usd(self) -> tuple[float, float] | None:
        """The least and the greatest price inside the intervals of the figures; None where it is not known."""
        if self.prices is None:
            return None
        low, high = zip(*(price.interval for price in self.prices.values()), strict=True)
        return sum(low), sum(high)

    @cached_property
    def prices(self) -> dict[str, Price] | None:
        """Its price and the price of the computer beside it, by platform; None where one of them is not known."""
        declared = {
            name: sold.price for name, sold in self._sold.items() if sold is not None and sold.price is not None
        }
        known = declared | {name: self.own_prices[name] for name in self._sold if name in self.own_prices}
        return known if len(known) == len(self._sold) else None

    @cached_property
    def _sold(self) -> dict[str, Sold | None]:
        """The board that is sold, None where the platform is none, and the computer beside it; by platform."""
        board = self.platform.board
        beside = {} if board is None or board.beside is None else Board(board.beside, load_platform(board.beside))._sold
        return {self.name: board} | beside

    @cached_property
    def input_idle_w(self) -> tuple[float, float, float] | None:
        """The power at its input while it waits, with the computer beside it: value, least and greatest, W.

        The greatest is of the work that was measured too. None if it is not declared for both.
        """
        powers = [None if sold is None else sold.power for sold in self._sold.values()]
        known = [power for power in powers if power is not None]
        if len(known) < len(powers):
            return None
        ends = [(power.idle.interval[0], (power.busy or power.idle).interval[1]) for power in known]
        return sum(power.idle.value for power in known), *(sum(column) for column in zip(*ends, strict=True))

    @property
    def idle_w(self) -> float:
        """The power that its components draw while no plan is computed, W."""
        return sum(figure.value for figure in self._idle)

    @property
    def idle_interval_w(self) -> tuple[float, float]:
        """The least and the greatest of it inside the intervals of the figures, W."""
        return sum(figure.interval[0] for figure in self._idle), sum(figure.interval[1] for figure in self._idle)

    @property
    def _idle(self) -> list[Figure]:
        """Static power of every FPGA, and idle power of every processor, memory and link with a declared power."""
        components = self.platform.components.values()
        figures = [spec.chip.static_power for spec in components if spec.chip is not None]
        drawing = [spec.drawing for spec in (*components, *self.platform.links.values())]
        return figures + [power.idle for power in drawing if power is not None]


def boards_of(sources: Sequence[str] | None = None, prices: Source | None = None) -> tuple[Board, ...]:
    """The boards of these shipped names or files; by default every shipped platform that is a board on sale.

    ``prices``: a file of the user's own prices, or its content (see ``load_prices``).

    Raises:
        InputError: no such board, none at all, or one is named twice. SpecError: the faults of a file.
    """
    boards = _boards(sources)
    if prices is None:
        return boards
    own = load_prices(prices, [board.name for board in boards]).dated
    return tuple(replace(board, own_prices=own) for board in boards)


def price_remarks(boards: Sequence[Board]) -> list[str]:
    """Remarks on where the prices of the boards come from, and on their age."""
    today, own = date_of_writing(), set().union(*(board.own_prices for board in boards))
    prices = {name: price for board in boards for name, price in (board.prices or {}).items()}

    def described(name: str) -> str:
        price, whose = prices[name], "yours" if name in own else "declared"
        return f"{whose}, {age_text(price.date, today) if price.date else 'without a date'}"

    groups = map_reduce(sorted(prices), described)
    texts = [f"{what} ({counted(len(names), 'board')})" for what, names in sorted(groups.items())]
    old = any(name not in own and " old" in described(name) for name in prices)
    hint = "; --prices FILE takes yours" if old else ""
    return [f"Prices: {'; '.join(texts)}{hint}."] if texts else []


def _boards(sources: Sequence[str] | None) -> tuple[Board, ...]:
    if sources is None:
        shipped = (Board(name, load_platform(name)) for name in list_platforms())
        return tuple(board for board in shipped if board.platform.board is not None)
    if not sources:
        raise InputError("no board is named", "--boards", "write --boards zynq,arty-a7, or leave it out")
    boards: dict[str, Board] = {}
    for source in sources:
        board = Board(source, load_platform(source))
        if board.name in boards:
            what = f"board {board.name} is named twice"
            raise InputError(what, "--boards", "name it once, or give one of the files another name:")
        boards[board.name] = board
    return tuple(boards.values())


def is_file(board: Board) -> bool:
    """True if the board is a file of the user, not a shipped platform."""
    return is_path(board.source)


SIMPLE: tuple[Where, ...] = ("host", "fabric", "split")
"""Software is the simplest design; then a circuit; then a circuit whose tasks are on two components."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A design on a board.

    - ``mapping``: the section ``mapping`` of its workload, as YAML has it.
    - ``placement``: ``fabric``, ``host``, or ``split`` where another component does one of the tasks.
    - ``settings``: axes of the platform that are set, such as ``fpga.clock``.
    """

    board: Board
    planner: Planner
    style: Architecture
    mapping: Mapping[str, Mapping[str, Any]]
    placement: Where
    settings: Mapping[str, str]

    @property
    def component(self) -> str:
        """The component that plans."""
        return str(self.mapping[self.planner.planning_task]["component"])

    @property
    def parameters(self) -> dict[str, Any]:
        """The parameters of the planning task that were chosen."""
        chosen = self.mapping[self.planner.planning_task]
        return {key: value for key, value in chosen.items() if key not in PLACE_KEYS}

    @property
    def bits(self) -> int:
        """The last precision; 0 for a planner without stages. Designs with fewer bits are evaluated first."""
        model = self.planner.tasks[self.planner.planning_task]
        return max(model.model_validate(self.parameters).precisions, default=0)


@dataclass(frozen=True)
class _Placement:
    """The tasks on other components, and the external memory of the planning task."""

    apart: Mapping[str, str]
    memory: str | None = None


class Replay(Iterable[Family]):
    """Families that several arrangements walk over, each from the first on; they are made once.

    Where the code of the planner fails, it does so for each of them.
    """

    def __init__(self, source: Iterator[Family]) -> None:
        self._source, self._met = source, list[Family]()
        self._failed: Exception | None = None

    def __iter__(self) -> Iterator[Family]:
        for index in count():
            if index == len(self._met):
                if self._failed is not None:
                    raise self._failed
                try:
                    self._met.append(next(self._source))
                except StopIteration:
                    return
                except Exception as failed:
                    self._failed = failed
                    raise
            yield self._met[index]


@dataclass(eq=False)
class Circuit:
    """What arrangements with the same style, tasks and part have in common, whatever their board.

    ``families``: of the style. ``parts``: of a family that was taken apart, by its identity; ``wholes``: what a family
    is a part of, by its identity. ``held``: the use of the part by a design;
    ``clocks``: its fastest clock.
    """

    families: Replay | None = None
    parts: dict[int, Replay] = field(default_factory=dict)
    wholes: dict[int, Family] = field(default_factory=dict)
    held: dict[str, PartFit | None] = field(default_factory=dict)
    clocks: dict[str, Figure | None] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Arrangement:
    """A planner, a style and a placement on a board. Its designs differ in parameters alone."""

    board: Board
    plug_in: PlugIn
    planner: Planner
    style: Architecture
    component: str
    placed: _Placement
    problem: Problem | None
    share: float
    circuits: dict[Any, Circuit]

    @property
    def placement(self) -> Where:
        """Where its tasks run."""
        alone: Where = "fabric" if self.style.component_type == "fpga" else "host"
        return "split" if self.placed.apart else alone

    @cached_property
    def _job(self) -> Job[Any, Any]:
        spec = self.board.platform.components[self.component]
        inside = frozenset(self.planner.tasks) - set(self.placed.apart)
        part = None if spec.chip is None else usable(spec.chip, self.share)
        assert self.problem is not None, "asked of a question"
        job: Job[Any, Any] = Job(self.problem, None, part=part, memory=spec.ram, inside=inside)
        if self.placed.memory is None:
            return job
        memory = self.board.platform.of(MemoryComponent)[self.placed.memory]
        return replace(job, external=memory_law(self.placed.memory, memory))

    @cached_property
    def _circuit(self) -> Circuit:
        job, spec = self._job, self.board.platform.components[self.component]
        own = spec.calibrated if isinstance(spec, FpgaComponent) else None
        models = [None if each is None else each.model_dump_json() for each in (job.part, own)]
        key = self.planner.name, self.style.style, *models, job.memory, job.inside, job.external
        return self.circuits.setdefault(key, Circuit())

    def families(self) -> Iterator[Family]:
        """Every design; of a style that proposes none, the samples of its plug-in, each by itself.

        The code of the planner may fail at each of them (``planner_code``).
        """
        if self._circuit.families is None:
            self._circuit.families = Replay(self._families())
        yield from self._circuit.families

    def parts(self, family: Family) -> Iterator[Family]:
        """The parts of one of its families that has some."""
        known = self._circuit.parts
        if id(family) not in known:
            assert family.parts is not None, "asked of a family with parts"
            known[id(family)] = Replay(family.parts())
        for part in known[id(family)]:
            self._circuit.wholes[id(part)] = family
            yield part

    def at(self, path: Sequence[int]) -> Family:
        """One of its families by its number, then that of a part of it, and so on."""
        family = next(islice(self.families(), path[0], None))
        for index in path[1:]:
            family = next(islice(self.parts(family), index, None))
        return family

    def clock_of_whole(self, family: Family) -> Figure | None:
        """A clock that no design of a family exceeds by its law, Hz: that of the family it is a part of, if of one."""
        whole = self._circuit.wholes.get(id(family))
        return None if whole is None else self.clock_limit(whole.lowest)

    def _families(self) -> Iterator[Family]:
        some = False
        for family in self.style.families(self._job):
            some = True
            yield family
        if not some:
            yield from map(Family, _of_samples(self.plug_in, self.planner))

    def candidate(self, design: Mapping[str, Any]) -> Candidate:
        """The design with these parameters, on an FPGA at the fastest clock that it reaches."""
        planning: dict[str, Any] = {"component": self.component, "style": self.style.style}
        if self.placed.memory is not None:
            planning["external_memory"] = self.placed.memory
        mapping: dict[str, dict[str, Any]] = {self.planner.planning_task: {**planning, **design}}
        mapping |= {task: {"component": component} for task, component in self.placed.apart.items()}
        candidate = Candidate(self.board, self.planner, self.style, mapping, self.placement, {})
        held = self.held(design)
        return candidate if held is None or held.clock is None else at_clock(candidate, reached(held.clock.limit))

    def held(self, design: Mapping[str, Any]) -> PartFit | None:
        """The use of the part by a design, and its clock; None of a processor, and where a run has to say it."""
        return self._asked(
            design,
            self._circuit.held,
            lambda laws, job: fit(Demand(laws.items(job)), job.part, 0, laws.clock_limit(job)),
        )

    def clock_limit(self, design: Mapping[str, Any]) -> Figure | None:
        """The fastest clock of a design by its law alone, Hz; None as of ``held``."""
        held = self._circuit.held.get(canonical(design))
        if held is not None and held.clock is not None:
            return held.clock.limit
        return self._asked(design, self._circuit.clocks, lambda laws, job: laws.clock_limit(job))

    def _asked(
        self, design: Mapping[str, Any], known: dict[str, T | None], ask: Callable[[Laws, Job[Any, Any]], T]
    ) -> T | None:
        component = self.board.platform.of(FpgaComponent).get(self.component)
        if component is None:
            return None
        key = canonical(design)
        if key not in known:
            known[key] = None
            with suppress(CodesignError, ValueError), planner_code(self.planner):
                model = self.planner.tasks[self.planner.planning_task].model_validate(dict(design))
                parameters = self.style.settled(model)
                if not parameters.to_find:
                    known[key] = ask(laws_of(self.style, component), replace(self._job, parameters=parameters))
        return known[key]

    def time_of(self, units: Mapping[str, int], limit: Figure | None) -> tuple[float, float]:
        """The time of units of work on the component, s: at the figures' own values, and the least inside intervals.

        ``units``: cycles under "", or units by kernel. ``limit``: of the clock of the least design of a family, Hz; of
        an FPGA. The upper end of its interval is of that design alone, so no clock of the part is taken to be out of
        reach inside the intervals.
        """
        if limit is not None:
            cycles, chip = units.get("", 0), self.board.platform.components[self.component].chip
            assert chip is not None, "a clock has a limit on an FPGA"
            fastest = chip.block_ram_clock.interval[1]
            return cycles / limit.value, 0.0 if self.placed.memory is not None else cycles / fastest
        spec = self.board.platform.components[self.component]
        times = [(n, _unit_time(spec, kernel)) for kernel, n in units.items() if kernel in (spec.kernels or {})]
        value, least = (sum(n * time[end] for n, time in times) for end in (0, 1))
        return value, least


def _unit_time(spec: AnyComponent, kernel: str) -> tuple[float, float]:
    """The time of a unit of a kernel on a processor, s: its value, and the least inside the intervals."""
    figures: dict[str, Figure] = {}

    def number(key: str) -> Sum:
        figures[key] = spec.figure(key)
        return symbol(key)

    law = spec.law_of(kernel, number)
    time = as_sum(law.ticks(1) / law.rate())
    value = time.at({key: figure.value for key, figure in figures.items()})
    return float(value), float(Ends(figures).of_sum(time.monomials)[0])


def reached(limit: Figure) -> int:
    """The fastest clock that a circuit reaches by its law, Hz: in whole MHz where it is above 10 MHz."""
    step = 1_000_000 if limit.value >= 10_000_000 else 1_000
    return int(limit.value) // step * step


def at_clock(candidate: Candidate, hz: int) -> Candidate:
    """The design at a clock of the fabric, Hz."""
    return replace(candidate, settings={f"{candidate.component}.clock": f"{hz // 1000} kHz"})


LOGIC = ("slices", "lut4", "flip_flops")
"""The resources of a part that a router needs room in. Block RAM and multipliers may all be used."""


def of_share(budget: float, share: float) -> int:
    """The amount of a resource of the logic that a design may use."""
    return math.floor(share * budget)


def usable(part: Part, share: float) -> Part:
    """The part with the share of its logic that a design may use."""
    resources = {
        kind: replace(figure, value=of_share(figure.value, share)) if kind in LOGIC else figure
        for kind, figure in part.resources.items()
    }
    return part.model_copy(update={"resources": resources})


def arrangements_of(
    board: Board, problem: Problem | None, needs: Needs, circuits: dict[Any, Circuit] | None = None
) -> Iterator[Arrangement]:
    """Every planner, style and placement on a board that the needs do not leave out. ``problem``: None to name them.

    ``circuits``: what is known of the designs of the problem, for the arrangements of several boards.
    """
    known = {} if circuits is None else circuits
    for plug_in in catalog.plug_ins():
        for style in plug_in.styles:
            planner = catalog.planners().get(style.planner)
            if planner is None or planner.problem_model is not None:
                continue
            for name, spec in board.platform.components.items():
                if spec.plans and spec.type == style.component_type:
                    for placed in _placements(board, planner, style, name):
                        each = Arrangement(board, plug_in, planner, style, name, placed, problem, needs.share, known)
                        if _is_asked(each, needs):
                            yield each


def _is_asked(each: Arrangement, needs: Needs) -> bool:
    asked = (needs.on, needs.planner, needs.style)
    own = (each.placement, each.planner.name, each.style.style)
    return all(limit in (None, value) for limit, value in zip(asked, own, strict=True))


def _placements(board: Board, planner: Planner, style: Architecture, name: str) -> Iterator[_Placement]:
    """All tasks on the planning component; then each task that another component can do there; then with a memory.

    Not ``detect``: a round trip for every sweep only adds time, and its circuit stays in the fabric.
    """
    components = board.platform.components
    yield _Placement({})
    for task in planner.tasks:
        if task in {planner.planning_task, LOAD, DETECT}:
            continue
        types = {kind for kind, _ in catalog.task_styles_of(planner.name, task)}
        for other, spec in components.items():
            if other != name and spec.type in types:
                yield _Placement({task: other})
    if style.supports_external:
        for memory, spec in board.platform.of(MemoryComponent).items():
            if spec.beside == name:
                yield _Placement({}, memory)


def _of_samples(plug_in: PlugIn, planner: Planner) -> Designs:
    """The samples of a plug-in with a style that proposes no designs, each as a chain of its own."""
    model: type[TaskParameters] = planner.tasks[planner.planning_task]
    required = [key for key, field in model.model_fields.items() if field.is_required()]
    default: tuple[Mapping[str, Any], ...] = () if required else ({},)
    samples = [sample for sample in plug_in.samples.parameters if sample]
    return tuple((design,) for design in chain(default, samples))
