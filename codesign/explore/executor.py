"""Who computes the points: this process, or several.

An executor takes groups of points and an evaluator, and yields entries for the store as they come in. What
comes in does not depend on the executor; only the order may. An exception in one point is that point's
failure and nobody else's. Outcomes travel as JSON text: what a worker sends is then, byte for byte, what
the store keeps.

Workers are spawned, not forked: compiled kernels and their threads do not survive a fork. They ignore
Ctrl-C, which is the parent's to handle, and end when the parent does.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import traceback
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from multiprocessing import get_context, parent_process
from pathlib import PurePath
from typing import TYPE_CHECKING, Protocol

from codesign.errors import CodesignError, RunError
from codesign.explore.space import DesignPoint
from codesign.explore.store import Entry, State

if TYPE_CHECKING:
    from codesign.system.result import Result

Evaluate = Callable[[DesignPoint], "Result"]
"""Computes one point. For ``ProcessExecutor`` it must pickle; each worker then works on a copy of its own."""

Group = Sequence[DesignPoint]

_GROUPS_AHEAD = 2
_SECONDS_TO_END = 5.0
_HINT_LATER = "memory is the usual reason: use fewer workers; finished points are kept"
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

    The first point is computed by one worker alone: it compiles the kernels into their cache on disk, where
    the others find them instead of all compiling at the same time.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def run(self, groups: Iterable[Group], evaluate: Evaluate) -> Generator[tuple[Entry, ...], None, None]:
        """Entries as they come in."""
        waiting = _first_alone(groups)
        pool = ProcessPoolExecutor(self.workers, get_context("spawn"), _start_worker, (evaluate,))
        running: dict[Future[tuple[Entry, ...]], Group] = {}
        ahead, hint = 1, _HINT_AT_START
        try:
            while True:
                for group in islice(waiting, ahead - len(running)):
                    running[_submitted(pool, group)] = group
                if not running:
                    break
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    entries = future.result()
                    del running[future]
                    ahead, hint = _GROUPS_AHEAD * self.workers, _HINT_LATER
                    yield entries
            pool.shutdown()
        except BrokenProcessPool as fault:
            raise RunError(
                f"a worker process died while it computed one of the points {_named(running.values())}",
                hint=hint,
            ) from fault
        finally:
            _end(pool)


def _first_alone(groups: Iterable[Group]) -> Iterator[Group]:
    rest = iter(groups)
    for first in rest:
        yield first[:1]
        if len(first) > 1:
            yield first[1:]
        yield from rest


def evaluate_group(evaluate: Evaluate, group: Group) -> tuple[Entry, ...]:
    """The entry of each point, in order; a point that raises becomes a failed one."""
    return tuple(_evaluated(evaluate, point) for point in group)


def _evaluated(evaluate: Evaluate, point: DesignPoint) -> Entry:
    try:
        return Entry(point.key, State.DONE, evaluate(point).model_dump_json())
    except CodesignError as fault:
        return Entry(point.key, State.FAILED, str(fault))
    except Exception as fault:
        # Not the user's mistake: the place is what a report of it needs.
        frame = traceback.extract_tb(fault.__traceback__)[-1]
        place = f"{PurePath(frame.filename).name}:{frame.lineno}"
        return Entry(point.key, State.FAILED, f"{type(fault).__name__}: {fault} ({place})")


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


def _submitted(pool: ProcessPoolExecutor, group: Group) -> Future[tuple[Entry, ...]]:
    """Submit with Ctrl-C held back: a worker that is started here inherits that, and stays deaf from its
    first moment."""
    if not hasattr(signal, "pthread_sigmask"):
        return pool.submit(_work, group)
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return pool.submit(_work, group)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end(pool: ProcessPoolExecutor) -> None:
    """End the workers now; there is nothing to end where the pool was shut down in order."""
    # Public (terminate_workers) from Python 3.14 on; until then the pool's own table is the only way to its
    # processes.
    processes = list((getattr(pool, "_processes", None) or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        with contextlib.suppress(ValueError):
            process.terminate()
    for process in processes:
        process.join(_SECONDS_TO_END)
        if process.is_alive():
            process.kill()
            process.join()


def _named(groups: Iterable[Group]) -> str:
    """The places of the points, as ranges.

    >>> _named([[DesignPoint(index, {}, "") for index in (4, 6, 5)], [DesignPoint(9, {}, "")]])
    '4 to 6, 9'
    """
    ranges: list[list[int]] = []
    for index in sorted(point.index for group in groups for point in group):
        if ranges and index == ranges[-1][1] + 1:
            ranges[-1][1] = index
        else:
            ranges.append([index, index])
    return ", ".join(str(first) if first == last else f"{first} to {last}" for first, last in ranges)
