"""The executors: they compute the points in this process, or in several.

An executor takes groups of points and an evaluator, and yields entries for the store as they come in. What
comes in does not depend on the executor; only the order may. An exception in one point is a
failure of that point alone. Outcomes travel as JSON text: what a worker sends is then, byte for byte, what
the store keeps.

Workers are spawned, not forked: compiled kernels and their threads do not survive a fork. They ignore
Ctrl-C, which is the parent's to handle, and end when the parent does. SIGTERM ends them at once, in a kernel too; where
it was sent to the whole group of processes, the parent says that it was terminated.

Ctrl-C may strike between any two instructions here, and a pool forgives little: a worker that is killed may
hold the lock of the queue that the others wait for, and the pool's thread, which Python joins when it ends,
then waits for those. So all workers are ended, each that was ever started, and before the pool is
shut down; and while a pool hands work over, or is ended, Ctrl-C and SIGTERM are held back.
"""

from __future__ import annotations

import json
import os
import signal
import threading
import time
import traceback
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
from pathlib import PurePath
from queue import SimpleQueue
from typing import TYPE_CHECKING, Protocol

from codesign.errors import CodesignError, RunError
from codesign.exploration.space import DesignPoint
from codesign.exploration.store import Entry, EntryState
from codesign.interrupts import held

if TYPE_CHECKING:
    from codesign.results.result import Result

Evaluate = Callable[[DesignPoint], "Result"]
"""Computes one point. For ``ProcessExecutor`` it must pickle; each worker then works on a copy of its own."""

Group = Sequence[DesignPoint]

_GROUPS_AHEAD = 2
_SECONDS_TO_END = 5.0
_SECONDS_TO_STRIKE = 0.2
_HINT_LATER = "use fewer workers if memory ran out (SIGKILL); finished points are kept"
_HINT_AT_START = (
    f"{_HINT_LATER}; in a script, explore below `if __name__ == '__main__':`, as workers import it"
)


class Executor(Protocol):
    """Computes groups of points."""

    def run(self, groups: Iterable[Group], evaluate: Evaluate) -> Generator[tuple[Entry, ...], None, None]:
        """Entries as they come in, each point's once.

        Groups are not empty. Closing the generator ends all work.

        Raises:
            RunError: a worker process died.
        """


class SerialExecutor:
    """Computes in this process, group by group."""

    def run(self, groups: Iterable[Group], evaluate: Evaluate) -> Generator[tuple[Entry, ...], None, None]:
        """The entries of each group, in order."""
        for group in groups:
            yield evaluate_group(evaluate, group)


class ProcessExecutor:
    """Computes in worker processes, ``workers`` of them.

    Until the first point that fits, and so is run, one worker computes alone: it compiles the kernels into their
    cache on disk. Others would compile them at the same time, and the cache bears only one that writes.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def run(self, groups: Iterable[Group], evaluate: Evaluate) -> Generator[tuple[Entry, ...], None, None]:
        """Entries as they come in."""
        waiting = _first_alone(groups)
        pool = ProcessPoolExecutor(self.workers, get_context("spawn"), _start_worker, (evaluate,))
        running: dict[Future[tuple[Entry, ...]], Group] = {}
        finished: SimpleQueue[Future[tuple[Entry, ...]]] = SimpleQueue()
        ahead, hint = 1, _HINT_AT_START
        processes: list[BaseProcess] = []
        try:
            while True:
                for group in islice(waiting, ahead - len(running)):
                    with held():
                        future = pool.submit(_work, group)
                        future.add_done_callback(finished.put)
                        running[future] = group
                processes = _processes(pool)
                if not running:
                    break
                # In the order in which they came: where a worker died, what the others had finished is first.
                future = finished.get()
                entries = future.result()
                del running[future]
                hint = _HINT_LATER
                if _was_run(entries):
                    ahead = _GROUPS_AHEAD * self.workers
                yield entries
            pool.shutdown()
        except BrokenProcessPool as fault:
            if any(process.exitcode == -signal.SIGTERM for process in processes):
                # Sent to the whole group of processes, it has reached this one too: it says so rather than fail.
                time.sleep(_SECONDS_TO_STRIKE)
            points = _ranges(running.values())
            what = f"a worker process died{_cause(processes)} while it computed one of the points {points}"
            raise RunError(what, hint=hint) from fault
        finally:
            with held():
                _end(_processes(pool))
                pool.shutdown(wait=False, cancel_futures=True)


def _was_run(entries: tuple[Entry, ...]) -> bool:
    return any(entry.state is EntryState.DONE and json.loads(entry.text)["feasible"] for entry in entries)


def _first_alone(groups: Iterable[Group]) -> Iterator[Group]:
    rest = iter(groups)
    for first in rest:
        yield first[:1]
        if len(first) > 1:
            yield first[1:]
        yield from rest


def evaluate_group(evaluate: Evaluate, group: Group) -> tuple[Entry, ...]:
    """The entry of each point, in order; a point that raises becomes a failed one."""
    return tuple(_entry_of(evaluate, point) for point in group)


def _entry_of(evaluate: Evaluate, point: DesignPoint) -> Entry:
    try:
        return Entry(point.key, EntryState.DONE, evaluate(point).model_dump_json())
    except CodesignError as fault:
        return Entry(point.key, EntryState.FAILED, str(fault))
    except Exception as fault:
        # Not the user's mistake: the place is what a report of it needs.
        return Entry(point.key, EntryState.FAILED, f"{type(fault).__name__}: {fault} ({_place(fault)})")


def _place(fault: Exception) -> str:
    """The innermost line of this package behind ``_entry_of``, or of any other where it never came back here."""
    frames = traceback.extract_tb(fault.__traceback__)
    ours = [frame for frame in frames[1:] if "codesign" in PurePath(frame.filename).parts]
    frame = (ours or frames)[-1]
    return f"{PurePath(frame.filename).name}:{frame.lineno}"


_worker_evaluate: Evaluate | None = None


def _start_worker(evaluate: Evaluate) -> None:
    global _worker_evaluate  # noqa: PLW0603 - a pool hands its initializer's work on through the module
    _worker_evaluate = evaluate
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _work(group: Group) -> tuple[Entry, ...]:
    assert _worker_evaluate is not None
    return evaluate_group(_worker_evaluate, group)


def _processes(pool: ProcessPoolExecutor) -> list[BaseProcess]:
    # Until Python 3.14 (terminate_workers) the pool's own table is the only access to its processes.
    return list((getattr(pool, "_processes", None) or {}).values())


def _cause(processes: list[BaseProcess]) -> str:
    """The cause of death of the first process that the pool did not end itself, where it is known."""
    until = time.monotonic() + _SECONDS_TO_END
    # Not join: the pool waits for them too, and the second to ask gets no exit code for a moment.
    while any(process.exitcode is None for process in processes) and time.monotonic() < until:
        time.sleep(0.01)
    codes = [code for process in processes if (code := process.exitcode) not in (None, 0, -signal.SIGTERM)]
    if not codes:
        return ""
    return f" by {signal.Signals(-codes[0]).name}" if codes[0] < 0 else f" with exit code {codes[0]}"


def _end(processes: list[BaseProcess]) -> None:
    """End these processes now; those of a pool that was shut down in order have ended."""
    for process in processes:
        process.terminate()
    for process in processes:
        process.join(_SECONDS_TO_END)
        if process.is_alive():
            process.kill()
            process.join()


def _ranges(groups: Iterable[Group]) -> str:
    """The places of the points, as ranges.

    >>> _ranges([[DesignPoint(index, {}, "") for index in (4, 6, 5)], [DesignPoint(9, {}, "")]])
    '4 to 6, 9'
    """
    ranges: list[list[int]] = []
    for index in sorted(point.index for group in groups for point in group):
        if ranges and index == ranges[-1][1] + 1:
            ranges[-1][1] = index
        else:
            ranges.append([index, index])
    return ", ".join(str(first) if first == last else f"{first} to {last}" for first, last in ranges)
