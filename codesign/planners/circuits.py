"""The contract of circuits: the Verilog of a design point, and all that a run of it has to report.

A ``CircuitStyle`` belongs to one style on an FPGA. It answers two questions about a ``Job``: ``circuit``, what is built
(cheap, no plan is computed), and ``expected``, what the model says the circuit reports, clock edge by clock edge.

Every top module has the same ports, so one bench drives all of them:

    clk                   rising edges count
    reset                 synchronous, high for one edge or more
    start                 high for one edge: the run begins, and the edge after it is cycle 0
    in_data, in_valid     a word of the load stream; ``in_ready`` takes it at the edge where both are high
    phase[3:0]            0 while nothing runs, else 1 + the index of the phase in ``Circuit.phases``
    event_valid           high at an edge where the circuit reports an event
    event_kind[3:0]       the index of its kind in ``Circuit.kinds``
    event_data            its value, ``Circuit.event_bits`` wide
    done                  high for at least one edge: the run has ended

A bench that never lets the circuit wait (``in_valid`` high as long as words are left) sees every event at the cycle
that the laws give. A slower stream only delays the phase that takes it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import Fault, UnsuitedError
from codesign.planners.counted import CountedLaws
from codesign.planners.job import Job

SHARED = Path(__file__).parent / "verilog"
"""The folder of the Verilog that several rooms use."""

MOST_KINDS = 16
"""The kinds of events, and the phases, that four bits tell apart."""


@dataclass(frozen=True, eq=False)
class Image:
    """The contents of a memory at power-up, or the words of a stream: ``words`` of ``width`` bits."""

    width: int
    words: Sequence[int] | NDArray[np.uint64]

    def hex_text(self) -> str:
        """The words as ``$readmemh`` reads them, one a line."""
        digits = -(-self.width // 4)
        return "".join(f"{int(word):0{digits}x}\n" for word in self.words)


class Bits(int):
    """A parameter of more than 32 bits: Verilog has to know its ``width``."""

    width: int

    def __new__(cls, value: int, width: int) -> Bits:
        """``value`` >= 0 in ``width`` bits."""
        bits = super().__new__(cls, value)
        bits.width = width
        return bits


@dataclass(frozen=True, eq=False)
class Circuit:
    """The circuit of one design point, as it is built.

    - ``top``: the top module. ``sources``: the Verilog-2005 files that it needs, all shipped with the package.
    - ``parameters``: the Verilog parameters of the top; text is a file name of ``images``. One of
      more than 32 bits is ``Bits``.
    - ``images``: the memories with contents at power-up, by the file name that ``parameters`` gives to the top.
    - ``stream``: the load stream, in the order in which the circuit takes it.
    - ``phases``: the names of the phases, as in ``Step.phase``. ``kinds``: the names of the kinds of events.
    - ``event_bits``: the width of ``event_data``, at most 64.
    - ``pieces``: for each name of a ``Line`` of the style's demand, the Verilog modules that it counts. A module that
      stands in none is counted with the module that contains it.
    - ``notes``: what a reader of the exported folder must know, sentences.
    - ``pins``: further outputs of the top, width by name, such as a display's, at most 64 bits in all.
      ``Expected.pins`` says what they show.
    - ``elements``: how many elements an array has. A simulator is chosen by it.
    """

    top: str
    sources: tuple[Path, ...]
    parameters: Mapping[str, int | str]
    stream: Image
    phases: tuple[str, ...]
    kinds: tuple[str, ...]
    event_bits: int
    images: Mapping[str, Image] = field(default_factory=dict)
    pieces: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    pins: Mapping[str, int] = field(default_factory=dict)
    elements: int = 1


EventsOfKind = tuple[int, NDArray[np.int64], NDArray[np.uint64]]
"""The kind of some events, their cycles and their values."""


@dataclass(frozen=True, eq=False)
class Events:
    """Events in the order of their cycles: arrays of one length, int64, uint8 and uint64.

    ``cycle`` 0 is the edge after the one that takes ``start``. ``kind`` is an index of ``Circuit.kinds``.
    """

    cycle: NDArray[np.int64]
    kind: NDArray[np.uint8]
    value: NDArray[np.uint64]

    @classmethod
    def joined(cls, parts: Iterable[EventsOfKind]) -> Events:
        """Events of several kinds, sorted by their cycles; in one cycle they stay in the order of ``parts``."""
        kinds, cycles, values = zip(*parts, strict=True)
        cycle = np.concatenate(cycles)
        kind = np.repeat(np.array(kinds, np.uint8), [len(each) for each in cycles])
        order = np.argsort(cycle, kind="stable")
        return cls(cycle[order], kind[order], np.concatenate(values)[order])


@dataclass(frozen=True, eq=False)
class Pins:
    """The values of the outputs in ``Circuit.pins``, cycle by cycle, as changes: arrays of one length.

    From ``cycle[i]`` (int64, rising) on they show ``value[i]``, of which the bits ``known[i]`` count (both uint64); the
    lowest bits belong to the first output. Nothing is said before the first change, nor from cycle ``end`` on. A run
    is watched to ``end``, also after it is done.
    """

    cycle: NDArray[np.int64]
    value: NDArray[np.uint64]
    known: NDArray[np.uint64]
    end: int


@dataclass(frozen=True, eq=False)
class Expected:
    """The run that the model expects: its events, and the cycles of each phase as the style's ``work`` counts them.

    ``events``: cycles follow from the laws of the style alone, values from the plan alone. ``cycles``: by phase.
    ``contention``: why single cycles may differ though all values are equal (two accesses to one memory); "" where none
    may. ``pins``: what the further outputs show; None only for a circuit without any.
    """

    events: Events
    cycles: Mapping[str, int]
    contention: str = ""
    pins: Pins | None = None


class CircuitStyle(ABC):
    """The circuits of one style on an FPGA.

    ``planner``, ``style``: as the style has them. ``task``: the task that is placed by itself, or "" for the planning
    task. ``laws``: what synthesis counts of it; None where no law is fitted.
    """

    planner: str
    style: str
    task: str = ""
    laws: CountedLaws | None = None

    @abstractmethod
    def circuit(self, job: Job[Any, Any], /) -> Circuit:
        """The circuit of a design point.

        Raises:
            UnsuitedError: no circuit of this style has the parameters of the job; the error names the parameter.
        """

    @abstractmethod
    def expected(self, job: Job[Any, Any], /) -> Expected:
        """The report that a run of ``circuit`` has to give."""

    @abstractmethod
    def sample(self, seed: int, /) -> Job[Any, Any]:
        """A random design point on a random map, the same for the same seed. Icarus runs it in seconds."""

    def held_out(self, variables: Mapping[str, int], /) -> bool:
        """True if the resource laws of the style left a synthesis out of their fit, by the parameters of its top."""
        return self.laws is not None and self.laws.held_out(variables)


def unsuited(key: str, what: str, hint: str) -> UnsuitedError:
    """The error about a parameter that no circuit has."""
    return UnsuitedError([Fault("circuit", 0, 0, key, what, hint)])


def phase_cycles(steps: Any) -> tuple[dict[str, int], Any]:
    """Drain the steps of ``Architecture.work``: the cycles of each phase, and the plan that it returns."""
    cycles: dict[str, int] = {}
    while True:
        try:
            step = next(steps)
        except StopIteration as stop:
            return cycles, stop.value
        cycles[step.phase] = cycles.get(step.phase, 0) + int(step.cycles.sum())
