"""The memory that a run takes, estimated before it begins, and the memory that it may take.

An estimate is the sum of the program, of what the planner says that it holds (``Planner.memory``), and of what the
scenario and the listeners hold. It estimates the peak: between 0.7 and 2 times what was measured over planners and
sizes (``tests/system/test_memory.py``). The bound is half of what the machine has free, unless one is given.
"""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from codesign.planners.interface import Problem
from codesign.system.bind import System

PROGRAM_BYTES = 200 * 2**20
"""Interpreter, libraries and compiled kernels. Measured: 195 to 206 MiB on x86-64 Linux, whatever the planner."""

_SHARE_OF_FREE = 0.5
_WHERE_UNKNOWN = 4 * 2**30
_SMALL_RUN = 64 * 2**20
_NO_LIMIT = 2**60
# Measured (traces of harmonic control, relaxation and wavefront on 2048 x 2048 cells: 6 to 20 bytes a cell).
_TRACE_BYTES_A_CELL = 20
_FIELD_BYTES_A_CELL = 8


@dataclass(frozen=True)
class Estimate:
    """The bytes that a run takes at its peak, by what takes them."""

    program: int
    planner: int
    scenario: int
    listeners: int

    @property
    def total(self) -> int:
        """All of it."""
        return self.program + self.planner + self.scenario + self.listeners


def estimate(system: System, *, listening: bool = False, keeping: bool = False) -> Estimate:
    """The memory that a run of the bound system takes.

    ``listening``: a listener takes its records, as for a trace. ``keeping``: they are kept in memory, as for a page.
    """
    problem, planner = system.problem, system.planner
    cells = int(problem.free.size) if isinstance(problem, Problem) else 0
    planned = planner.memory(system.job)
    fields = planner.fields_a_stage * max(1, len(system.planning.precisions))
    recorded = (_TRACE_BYTES_A_CELL if listening else 0) + (_FIELD_BYTES_A_CELL * fields if keeping else 0)
    return Estimate(
        program=PROGRAM_BYTES,
        planner=planned,
        scenario=system.scenario.bytes_a_cell * cells,
        listeners=recorded * cells,
    )


def refusal(
    system: System, bound: int | None = None, *, listening: bool = False, keeping: bool = False
) -> tuple[str, str] | None:
    """The reason for not beginning the run, as (sentence, hint), or None; ``bound``: bytes, else ``free_bound``."""
    need = estimate(system, listening=listening, keeping=keeping)
    given = bound is not None
    bound = free_bound() if bound is None else bound
    if need.total <= bound:
        return None
    parts = {"planner": need.planner, "scenario": need.scenario, "records": need.listeners}
    shown = ", ".join(f"{in_words(size)} for the {name}" for name, size in parts.items() if size > 0)
    kind = "the bound given" if given else "half of what this machine has free"
    what = f"the run would need about {in_words(need.total)} of memory ({shown}), more than {in_words(bound)}, {kind}"
    levers = ["a smaller or coarser map"] if isinstance(system.problem, Problem) else ["fewer robots or updates"]
    levers += system.planner.memory_levers(system.job)
    if need.listeners > 0:
        levers.append("no trace and no page")
    return what, f"take {', '.join(levers)}; or allow more (--memory 8GiB)"


def free_bound() -> int:
    """Half of the memory that this process could still take, bytes; 4 GiB where the system does not say."""
    free = [size for size in (_free_of_machine(), _free_of_group()) if size is not None]
    return int(_SHARE_OF_FREE * min(free)) if free else _WHERE_UNKNOWN


def share_of_memory(workers: int, bound: int | None = None) -> int:
    """The bytes that one of several workers may take, of a bound for all of them (by default ``free_bound``).

    At least what a run on a small map takes: many workers on a small machine are slow, and no fault of the design.
    """
    bound = free_bound() if bound is None else bound
    return max(bound // workers, PROGRAM_BYTES + _SMALL_RUN)


def in_words(size: int) -> str:
    """Bytes for a human.

    >>> in_words(5 * 2**30), in_words(300 * 2**20)
    ('5.0 GiB', '300 MiB')
    """
    return f"{size / 2**30:.1f} GiB" if size >= 2**30 else f"{max(1, round(size / 2**20))} MiB"


def _free_of_machine() -> int | None:
    """The memory that Linux says can be taken without swapping; elsewhere the pages that are free, or None."""
    with suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    with suppress(AttributeError, OSError, ValueError):
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return None


def _free_of_group(root: Path = Path("/sys/fs/cgroup"), own: Path = Path("/proc/self/cgroup")) -> int | None:
    """The memory that the control groups around this process leave it, as a container has them; None: no limit."""
    left: list[int] = []
    with suppress(OSError, ValueError):
        for line in own.read_text(encoding="utf-8").splitlines():
            _, controllers, path = line.split(":", 2)
            if controllers == "":
                folder, names = root, ("memory.max", "memory.current")
            elif "memory" in controllers.split(","):
                folder, names = root / "memory", ("memory.limit_in_bytes", "memory.usage_in_bytes")
            else:
                continue
            parts = [part for part in path.split("/") if part not in ("", "..")]
            for depth in range(len(parts) + 1):
                left += _left_in(folder.joinpath(*parts[:depth]), *names)
    return min(left) if left else None


def _left_in(folder: Path, limit: str, usage: str) -> list[int]:
    with suppress(OSError, ValueError):
        most = int((folder / limit).read_text(encoding="ascii"))
        if most < _NO_LIMIT:
            return [max(0, most - int((folder / usage).read_text(encoding="ascii")))]
    return []
