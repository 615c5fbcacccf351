"""A host measured on the board itself, which has Python and NumPy alone: the script, and what it prints.

The script holds the maps of ``host_fit``, and the programs that planners have for a board. A program in C is built
there: it is another program than the kernels of this package, and the one that a robot would run.
"""

from __future__ import annotations

import base64
import hashlib
import json
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from statistics import median
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from codesign.ground.errors import SpecError
from codesign.ground.models import SpecModel
from codesign.hardware.calibrate.host_costs import REFERENCE, MeasuredHost
from codesign.hardware.calibrate.host_fit import (
    ProgramFit,
    TimedPlan,
    Timing,
    all_timed,
    disturbance_of,
    fit_programs,
    less,
    plans_on,
    questions,
)
from codesign.inputs.base import Spec, fault
from codesign.inputs.faults import validate
from codesign.inputs.files import shown
from codesign.inputs.library import HOSTS
from codesign.inputs.yaml_tree import read_document

_TEMPLATE = Path(__file__).with_name("board_template.py")
_EMPTY = "PAYLOAD: Any = {}"

Seconds = Annotated[float, Field(ge=0, le=3600)]
Runs = Annotated[tuple[Seconds, ...], Field(min_length=3)]


class Clocked(SpecModel):
    """The times of the runs of a plan."""

    wall: Runs = Field(description="By the clock on the wall, s.")
    processor: Runs = Field(description="By the clock of the processor, s.")
    call: Runs = Field(description="A call on a map of two cells, by the clock of the processor, s.")


class BoardFile(Spec):
    """What the script of ``hwsw calibrate host --script`` printed on a board."""

    kind: Literal["board"] = Field(description="This file is a board's.")
    script: str = Field(description="The digest of the maps and programs of the script.")
    machine: str = Field(description="The processor.")
    cores: Annotated[int, Field(ge=1, le=1024)] = Field(description="Its cores.")
    clock_hz: Annotated[int, Field(ge=1)] | None = Field(description="Its greatest clock, where the system says it.")
    made: Mapping[str, str] = Field(description="How each program was made.")
    times: Mapping[str, Mapping[str, Clocked]] = Field(description="By program and plan.")
    not_timed: Mapping[str, str] = Field(description="By program, why it was left out.")


def script(seconds: float) -> str:
    """The Python file that times the programs of all planners on a board, for about so many seconds."""
    plans = [*_plans()]
    content = _content(plans)
    payload = json.dumps({"script": _digest(content), "seconds": seconds, **content}, indent=1, sort_keys=True)
    return _TEMPLATE.read_text(encoding="utf-8").replace(_EMPTY, f"PAYLOAD: Any = json.loads(r'''{payload}''')")


def read_board(path: Path) -> MeasuredHost:
    """The host that a board's file describes: costs fitted to its times, its cores, load and jitter.

    Raises:
        SpecError: every fault of the file; it is of another version's script; or nothing was timed.
    """
    document = read_document(path, shown(path))
    board = validate(BoardFile, document).with_document(document)
    plans = [*_plans()]
    if board.script != _digest(_content(plans)):
        hint = "write the script again with this version, and run it on the board"
        raise SpecError([fault(board, ("script",), "measured with the script of another version", hint)])
    by_key = {(plan.program, key): plan for key, plan in _keyed(plans)}
    known = {(program, key) for program, times in board.times.items() for key in times}
    if not known or not known <= by_key.keys():
        raise SpecError([fault(board, ("times",), "no plan of the script was timed", "run the script on the board")])
    timings, fits = list[Timing](), list[ProgramFit]()
    first = {name: cost.value * 1e-12 for name, cost in HOSTS.find(REFERENCE).costs.items()}
    for program, times in board.times.items():
        own = []
        for key, each in times.items():
            plan, runs = by_key[program, key], [*zip(each.wall, each.processor, strict=True)]
            own.append(Timing(program, plan.map, plan.units, *less(median(each.call), runs)))
        timings += own
        fits += fit_programs(own, first, f"{board.machine}, {board.made[program]}, {path.name}")
    costs = {kernel: cost for fit in fits for kernel, cost in fit.costs.items()}
    where = f"{board.machine}, {path.name}"
    disturbance = disturbance_of(timings, where)
    machine = board.machine, board.cores, board.clock_hz
    return MeasuredHost(*machine, costs, disturbance, tuple(fits), board.not_timed)


def _plans() -> Iterator[TimedPlan]:
    return plans_on([*questions()], [*HOSTS.find(REFERENCE).costs], on_board=True)


def _keyed(plans: list[TimedPlan]) -> Iterator[tuple[str, TimedPlan]]:
    """Each plan with its number among all, as a text."""
    return ((str(number), plan) for number, plan in enumerate(plans))


def _content(plans: list[TimedPlan]) -> dict[str, Any]:
    """Maps and programs as the script holds them."""
    maps: dict[str, Any] = {}
    programs: dict[str, Any] = {}
    for key, plan in _keyed(plans):
        problem, (_, timed) = plan.job.problem, all_timed()[plan.program]
        assert timed.program is not None, "asked of plans for a board"
        packed = zlib.compress(np.packbits(problem.free).tobytes(), 9)
        maps[plan.map] = (*problem.free.shape, base64.b64encode(packed).decode())
        if plan.program not in programs:
            programs[plan.program] = {
                "suffix": timed.program.suffix,
                "source": timed.program.read_text(encoding="utf-8"),
                "parameters": dict(timed.parameters),
                "plans": {},
            }
        answer = plan.units[plan.kernel]
        programs[plan.program]["plans"][key] = (plan.map, [*problem.goals[0]], [*problem.starts[0]], answer)
    return {"maps": maps, "programs": programs}


def _digest(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]
