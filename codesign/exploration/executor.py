"""The executors: they compute work in this process, or in several.

An executor takes works and an evaluator, and yields what came of each as it comes in. What comes in does not depend on
the executor; only the order may. An exception in one point is a failure of that point alone, and so is the death of a
worker: what it was computing is computed again, first as a whole, then point by point.

Workers are spawned, not forked: compiled kernels and their threads do not survive a fork. They ignore
Ctrl-C, which is the parent's to handle, and end when the parent does. SIGTERM ends them at once, in a kernel too; where
it was sent to the whole group of processes, the parent says that it was terminated.

Ctrl-C may strike between any two instructions here, and a pool forgives little: a worker that is killed may
hold the lock of the queue that the others wait for, and the pool's thread, which Python joins when it ends,
then waits for those. So all workers are ended, each that was ever started, and before the pool is
shut down; and while a pool hands work over, or is ended, Ctrl-C and SIGTERM are held back.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Generator, Iterable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from typing import Protocol

from codesign.errors import RunError
from codesign.exploration.evaluation import Done, Evaluator, without_work
from codesign.exploration.partition import Work
from codesign.exploration.work_queue import DEATH_HINT, WorkQueue
from codesign.interrupts import held
from codesign.system.memory import share_of_memory

_WORKS_AHEAD = 2
_SECONDS_TO_END = 5.0
_SECONDS_TO_STRIKE = 0.2


class Executor(Protocol):
    """Computes work."""

    @property
    def workers(self) -> int:
        """How many works may be under way at a time."""

    def run(self, works: Iterable[Work], evaluate: Evaluator) -> Generator[Done, None, None]:
        """What came of each work, as it comes in. Works are not empty. Closing the generator ends all work."""

    def share(self, memory: int | None) -> int:
        """The bytes that one worker may take, of a bound for all of them; None: of what there is."""


class SerialExecutor:
    """Computes in this process, work by work."""

    workers = 1

    def share(self, memory: int | None) -> int:
        """The bytes that a work may take."""
        return share_of_memory(1, memory)

    def run(self, works: Iterable[Work], evaluate: Evaluator) -> Generator[Done, None, None]:
        """What came of each work, in order."""
        queue = WorkQueue(iter(works), evaluate, 1)
        while (work := queue.next(())) is not None:
            done = evaluate(work)
            if done.interrupt is None:
                yield from queue.take(done)
                continue
            # What was done is kept before the interrupt travels on.
            if done.work.indices:
                yield done
            raise done.interrupt


class ProcessExecutor:
    """Computes in worker processes, ``workers`` of them.

    Until a plan was computed, one worker computes alone: it compiles the kernels into their cache on disk. Others would
    compile them at the same time, and the cache bears only one that writes.

    A worker that dies takes the pool with it. Then what was being computed is computed again, one work after another.
    Where a worker dies of it again, its points are computed one by one, and a point of which a worker dies has failed.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def share(self, memory: int | None) -> int:
        """The bytes that one worker may take."""
        return share_of_memory(self.workers, memory)

    def run(self, works: Iterable[Work], evaluate: Evaluator) -> Generator[Done, None, None]:
        """What came of each work, as it comes in."""
        queue = WorkQueue(iter(works), evaluate, self.workers)
        while True:
            pool = _Pool(self.workers, evaluate)
            try:
                yield from pool.run(queue)
                return
            except BrokenProcessPool:
                cause = pool.cause()
                pool.end()
                yield from queue.after_death(pool.running.values(), cause)
            finally:
                pool.end()


class _Pool:
    """Worker processes that compute until one of them dies. ``running``: the works under way."""

    def __init__(self, workers: int, evaluate: Evaluator) -> None:
        self._pool = ProcessPoolExecutor(workers, get_context("spawn"), _start_worker, (evaluate,))
        self._processes: list[BaseProcess] = []
        self._ahead = _WORKS_AHEAD * workers
        self.running: dict[Future[Done], Work] = {}

    def run(self, queue: WorkQueue) -> Generator[Done, None, None]:
        """What comes in.

        Raises:
            BrokenProcessPool: a worker died. RunError: workers die as they start.
        """
        self._begin()
        running = self.running
        finished: SimpleQueue[Future[Done]] = SimpleQueue()
        while True:
            ahead = self._ahead if queue.compiled else 1
            while len(running) < ahead and (work := queue.next(tuple(running.values()))) is not None:
                with held():
                    try:
                        future = self._pool.submit(_work, work)
                    except BrokenProcessPool:
                        queue.put_back([work])
                        raise
                    running[future] = work
                    future.add_done_callback(finished.put)
            self._processes = _processes(self._pool)
            if not running:
                break
            # In the order in which they came: where a worker died, what the others had finished is first.
            future = finished.get()
            done = replace(future.result(), work=running.pop(future))
            yield from queue.take(done)
        self._pool.shutdown()

    def _begin(self) -> None:
        with held():
            started = self._pool.submit(_started)
        self._processes = _processes(self._pool)
        try:
            started.result()
        except BrokenProcessPool as broken:
            raise RunError(f"a worker process died{self.cause()} as it started", hint=DEATH_HINT) from broken

    def cause(self) -> str:
        """How the worker that died first ended, in words.

        Raises:
            RunError: the workers were terminated, as this process will be.
        """
        cause = _cause(self._processes)
        # A pool that breaks terminates its other workers: SIGTERM counts only where no worker died otherwise.
        if not cause and any(process.exitcode == -signal.SIGTERM for process in self._processes):
            # Sent to the whole group of processes, it has reached this one too: it says so rather than fail.
            time.sleep(_SECONDS_TO_STRIKE)
            raise RunError("the worker processes were terminated", hint="finished points are kept")
        return cause

    def end(self) -> None:
        """End all workers now."""
        with held():
            _end(_processes(self._pool))
            self._pool.shutdown(wait=False, cancel_futures=True)


_worker_evaluate: Evaluator | None = None


def _start_worker(evaluate: Evaluator) -> None:
    global _worker_evaluate  # noqa: PLW0603 - a pool hands its initializer's work on through the module
    _worker_evaluate = evaluate
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _started() -> None:
    """The first thing that a worker is asked."""


def _work(work: Work) -> Done:
    assert _worker_evaluate is not None
    return without_work(_worker_evaluate(work))


def _processes(pool: ProcessPoolExecutor) -> list[BaseProcess]:
    # Until Python 3.14 (terminate_workers) the pool's own table is the only access to its processes.
    return list((getattr(pool, "_processes", None) or {}).values())


def _cause(processes: list[BaseProcess]) -> str:
    """The cause of death of the first process that the pool did not end itself, where it is known."""
    until = time.monotonic() + _SECONDS_TO_END
    # Not join: the pool waits for them too, and the second to ask gets no exit code for a moment.
    while any(process.exitcode is None for process in processes) and time.monotonic() < until:
        time.sleep(0.01)
    codes = [code for process in processes if (code := process.exitcode) not in (None, -signal.SIGTERM)]
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
