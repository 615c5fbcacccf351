"""The designs that a board is searched for: planner, style, placement and parameters.

Planners and styles come from the installed plug-ins, and so do the parameters: each style proposes its ``designs``.
A planner of another package takes part without an edit here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import Any, Literal

from codesign.ground.errors import InputError
from codesign.ground.figures import Figure
from codesign.ground.models import TaskParameters
from codesign.inputs import Platform, list_platforms, load_platform
from codesign.inputs.components import MemoryComponent
from codesign.inputs.files import is_path
from codesign.inputs.platform import Board as Sold
from codesign.inputs.workload import PLACE_KEYS
from codesign.planners.interface import LOAD, Planner, Problem
from codesign.planners.job import Job
from codesign.planners.plug_in import PlugIn
from codesign.planners.styles import Architecture, Designs
from codesign.system import catalog
from codesign.system.assemble import memory_law
from codesign.system.place import DETECT

# The boards of the catalogue: which are asked about, what they cost, and what they draw while they wait.


@dataclass(frozen=True, eq=False)
class Board:
    """A platform that is asked about. ``source``: its shipped name or its file, as ``hwsw run`` takes it."""

    source: str
    platform: Platform

    @property
    def name(self) -> str:
        """Its name in results."""
        return self.platform.name

    @property
    def price_usd(self) -> float | None:
        """Its price, with the price of the computer beside it; None if the platforms do not declare both."""
        prices = self._prices
        return None if prices is None else sum(float(price.value) for price in prices)

    @property
    def price_interval_usd(self) -> tuple[float, float] | None:
        """The least and the greatest price inside the intervals of the figures; None where it is not known."""
        prices = self._prices
        if prices is None:
            return None
        return sum(price.interval[0] for price in prices), sum(price.interval[1] for price in prices)

    @property
    def _prices(self) -> list[Figure] | None:
        """Its own price, and the price of the computer beside it."""
        prices = [board.price for board in self._sold]
        known = [price for price in prices if price is not None]
        return known if prices and len(known) == len(prices) else None

    @property
    def _sold(self) -> list[Sold]:
        """The board that is sold, and the computer beside it; empty for a platform that is none."""
        board = self.platform.board
        if board is None:
            return []
        return [board] if board.beside is None else [board, *Board(board.beside, load_platform(board.beside))._sold]

    @cached_property
    def input_idle_w(self) -> tuple[float, float, float] | None:
        """The power at its input while it waits, with the computer beside it: value, least and greatest, W.

        The greatest is of the work that was measured too. None if it is not declared for both.
        """
        powers = [board.power for board in self._sold]
        known = [power for power in powers if power is not None]
        if not powers or len(known) < len(powers):
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


def boards_of(sources: Sequence[str] | None = None) -> tuple[Board, ...]:
    """The boards of these shipped names or files; by default every shipped platform that is a board on sale.

    Raises:
        InputError: no such board, none at all, or one is named twice. SpecError: the faults of a file.
    """
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


Where = Literal["fabric", "host", "split"]
"""The placement of a design: all on an FPGA, all on a processor, or a task on another component."""


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


def chains_of(board: Board, problem: Problem) -> Iterator[tuple[Candidate, ...]]:
    """The chains of designs of a board (see ``Designs``): every planner, style and placement."""
    for plug_in in catalog.plug_ins():
        for style in plug_in.styles:
            planner = catalog.planners().get(style.planner)
            if planner is None or planner.problem_model is not None:
                continue
            for name, spec in board.platform.components.items():
                if spec.plans and spec.type == style.component_type:
                    yield from _on_component(board, problem, plug_in, planner, style, name)


def _on_component(
    board: Board, problem: Problem, plug_in: PlugIn, planner: Planner, style: Architecture, name: str
) -> Iterator[tuple[Candidate, ...]]:
    part = board.platform.components[name].chip
    for placement in _placements(board, planner, style, name):
        inside = frozenset(planner.tasks) - set(placement.apart)
        job: Job[Any, Any] = Job(problem, None, part=part, inside=inside)
        if placement.memory is not None:
            memory = board.platform.of(MemoryComponent)[placement.memory]
            job = replace(job, external=memory_law(placement.memory, memory))
        for designs in style.designs(job) or _of_samples(plug_in, planner):
            yield tuple(_candidate(board, planner, style, name, placement, design) for design in designs)


def _candidate(
    board: Board, planner: Planner, style: Architecture, name: str, placement: _Placement, design: Mapping[str, Any]
) -> Candidate:
    planning: dict[str, Any] = {"component": name, "style": style.style}
    if placement.memory is not None:
        planning["external_memory"] = placement.memory
    mapping: dict[str, dict[str, Any]] = {planner.planning_task: {**planning, **design}}
    mapping |= {task: {"component": component} for task, component in placement.apart.items()}
    alone: Where = "fabric" if style.component_type == "fpga" else "host"
    return Candidate(board, planner, style, mapping, "split" if placement.apart else alone, {})


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
