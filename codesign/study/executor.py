"""The executors: they compute work in this process, or in several.

An executor takes works and an evaluator, and yields the outcome of each as it comes in. The outcomes do not depend on
the executor; only their order may. An exception in one point is a failure of that point alone, and so is the death of a
worker: what it was computing is computed again, first as a whole, then point by point.

Each worker is a pool of one process. So a work goes to the worker that has computed its affinity (``Dealer``), and a
worker that dies takes no other one with it.

Workers are not forked from this process: compiled kernels and their threads do not survive a fork. On Linux they are
forked from a server that has loaded the modules and begun no kernel, so that only the first worker of a process waits
for imports; elsewhere they are spawned. They ignore Ctrl-C, which is the parent's to handle, and end when the parent
does. SIGTERM ends them at once, in a kernel too; where it was sent to the whole group of processes, the parent says
that it was terminated.

Ctrl-C may strike between any two instructions here, and a pool forgives little: a worker that is killed may
hold the lock of the queue that the others wait for, and the pool's thread, which Python joins when it ends,
then waits for those. So all workers are ended, each that was ever started, and before the pool is
shut down; and while a pool hands work over, or is ended, Ctrl-C and SIGTERM are held back.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Generator, Hashable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing import forkserver, get_context, parent_process
from multiprocessing.context import BaseContext
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from typing import Any, Protocol

from codesign.ground.errors import RunError
from codesign.ground.interrupts import held
from codesign.ground.kernel_cache import reload_kernel_folder
from codesign.study.evaluation import Done, Evaluator
from codesign.study.partition import Work
from codesign.study.work_queue import DEATH_HINT, Packing, Slot, WorkQueue
from codesign.system.memory import share_of_memory

_SECONDS_A_BATCH = 0.1
"""Long beside the millisecond that a batch costs, short beside a study."""

_LOADED = ["codesign.study.evaluation", "codesign.study.pricing.price", "codesign.system.scenarios.run"]
"""The modules of every worker. To import them begins no kernel and no thread, so a fork of their server is whole."""

_KEPT_FROM_SERVER = [signal.Signals[name] for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]

_SECONDS_TO_END = 5.0
_SECONDS_TO_STRIKE = 0.2


class Executor(Protocol):
    """Computes work."""

    @property
    def workers(self) -> int:
        """The number of pieces of work that may be under way at a time."""

    def run(self, works: Iterable[Work], evaluate: Evaluator) -> Generator[Done, None, None]:
        """The outcome of each piece of work, as it comes in. None is empty. Closing the generator ends all work."""

    def share(self, memory: int | None) -> int:
        """The bytes that one worker may take, of a bound for all of them; None: of what there is."""


class SerialExecutor:
    """Computes in this process, work by work."""

    workers = 1

    def share(self, memory: int | None) -> int:
        """The bytes that a work may take."""
        return share_of_memory(1, memory)

    def run(self, works: Iterable[Work], evaluate: Evaluator) -> Generator[Done, None, None]:
        """The outcome of each piece of work, in order."""
        queue = WorkQueue(works, evaluate.space, 1)
        while came := evaluate.batch(iter(lambda: queue.next(()), None), evaluate.seconds_a_batch)[0]:
            for done in came:
                if done.interrupt is None:
                    yield from queue.take(done)
                    continue
                # What was done is kept before the interrupt travels on.
                if done.work.indices:
                    yield done
                raise done.interrupt


class ProcessExecutor:
    """Computes in worker processes, ``workers`` of them.

    One worker at a time compiles kernels (``compiled_once``): their cache on disk bears only one that writes.

    A worker that dies is replaced. What it had under way is computed again, one work after another. Where a worker dies
    of it again, its points are computed one by one, and a point of which a worker dies has failed.

    Works go out in batches that take about a tenth of a second, so that a work costs no message of its own.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def share(self, memory: int | None) -> int:
        """The bytes that one worker may take."""
        return share_of_memory(self.workers, memory)

    def run(self, works: Iterable[Work], evaluate: Evaluator) -> Generator[Done, None, None]:
        """The outcome of each piece of work, as it comes in.

        Raises:
            RunError: workers die as they start, or were terminated.
        """
        processes = _Processes(self.workers, evaluate)
        try:
            yield from processes.run(WorkQueue(works, evaluate.space, self.workers, _SECONDS_A_BATCH))
        finally:
            processes.end()


class _Slot(Slot):
    """A worker process. ``started``: comes to its end once the process runs."""

    def __init__(self, number: Hashable, evaluate: Evaluator) -> None:
        super().__init__(number)
        self.pool = ProcessPoolExecutor(1, _context(), _start_worker, (evaluate, dict(os.environ)))
        self.started: Future[Any] | None = None
        self._process: BaseProcess | None = None

    @property
    def process(self) -> BaseProcess | None:
        """The process, also after its end; None before it was started."""
        # Until Python 3.14 (terminate_workers) the pool's own table is the only access to it.
        table = getattr(self.pool, "_processes", None) or {}
        self._process = self._process or next(iter(table.values()), None)
        return self._process


class _Processes:
    """The worker processes of one run. ``_ready``: those that run, the first one first."""

    def __init__(self, workers: int, evaluate: Evaluator) -> None:
        self._workers, self._evaluate = workers, evaluate
        self._slots: dict[Hashable, _Slot] = {}
        self._ready: list[_Slot] = []
        self._events: SimpleQueue[tuple[_Slot, Future[Any]]] = SimpleQueue()

    def run(self, queue: WorkQueue) -> Generator[Done, None, None]:
        """The outcomes that come in.

        Raises:
            RunError: workers die as they start, or were terminated.
        """
        for number in range(0 if queue.is_empty() else self._workers):
            self._begin(number)
        while True:
            # Until all workers run, each has one work at a time: the first one would take those of the others.
            starting = len(self._ready) < self._workers
            queue.hand_out(self._ready, partial(self._send, queue), one_by_one=starting)
            if not any(slot.batches for slot in self._ready) and queue.is_empty():
                break
            # In the order in which they came: where a worker died, what it had finished is first.
            slot, future = self._events.get()
            if self._slots[slot.name] is not slot:
                continue
            try:
                outcome = future.result()
            except BrokenProcessPool:
                yield from self._after_death(slot, future, queue)
                continue
            if future is slot.started:
                self._ready.append(slot)
                continue
            for done in queue.came(slot, slot.batches.pop(future), *outcome):
                yield from queue.take(done)
        for slot in self._ready:
            slot.pool.shutdown()

    def end(self) -> None:
        """End all workers now."""
        with held():
            _end([slot.process for slot in self._slots.values() if slot.process is not None])
            for slot in self._slots.values():
                slot.pool.shutdown(wait=False, cancel_futures=True)

    def _begin(self, number: Hashable) -> None:
        """Start a worker."""
        with held():
            slot = self._slots[number] = _Slot(number, self._evaluate)
            slot.started = slot.pool.submit(_started)
            self._heed(slot, slot.started)

    def _heed(self, slot: _Slot, future: Future[Any]) -> None:
        future.add_done_callback(lambda future: self._events.put((slot, future)))

    def _send(self, queue: WorkQueue, slot: _Slot, batch: list[Work]) -> None:
        with held():
            try:
                future = slot.pool.submit(_batch, batch, 2 * _SECONDS_A_BATCH)
            except BrokenProcessPool as broken:
                queue.put_back(batch, slot.name)
                self._ready.remove(slot)
                future = Future()
                future.set_exception(broken)
            else:
                slot.batches[future] = batch
            self._heed(slot, future)

    def _after_death(self, slot: _Slot, future: Future[Any], queue: WorkQueue) -> Iterator[Done]:
        """The outcomes that failed as a worker died; another worker takes its place.

        Raises:
            RunError: it died as it started, or it was terminated, as this process will be.
        """
        cause = _cause(slot)
        if future is slot.started:
            raise RunError(f"a worker process died{cause} as it started", hint=DEATH_HINT)
        self._ready = [each for each in self._ready if each is not slot]
        self._begin(slot.name)
        yield from queue.after_death(slot.works, cause)


_packing: Packing | None = None


def _context() -> BaseContext:
    if sys.platform != "linux":
        return get_context("spawn")
    context = get_context("forkserver")
    context.set_forkserver_preload(_LOADED)
    # A signal to the whole group of processes must not end the server before it has told how its workers ended.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, _KEPT_FROM_SERVER)
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    return context


def _start_worker(evaluate: Evaluator, environment: dict[str, str]) -> None:
    global _packing  # noqa: PLW0603 - a pool hands its initializer's work on through the module
    # The server has the environment of the moment at which it began.
    os.environ.clear()
    os.environ.update(environment)
    reload_kernel_folder()
    if sys.platform == "linux":
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _KEPT_FROM_SERVER)
    _packing = Packing(evaluate)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _started() -> None:
    """The first thing that a worker is asked."""


def _batch(works: list[Work], seconds: float) -> tuple[list[Done], float]:
    assert _packing is not None
    return _packing(works, seconds)


def _cause(slot: _Slot) -> str:
    """The end of the worker of a broken pool, in words; "" if it is not known. The pool is shut down.

    Raises:
        RunError: it was terminated, as this process will be.
    """
    process = slot.process
    # The pool's thread asks for the exit code too, and a server tells it once: who asks second gets another.
    ending = threading.Thread(target=slot.pool.shutdown, daemon=True)
    ending.start()
    ending.join(_SECONDS_TO_END)
    code = None if process is None else process.exitcode
    if code == -signal.SIGTERM:
        # Sent to the whole group of processes, it has reached this one too: it says so rather than fail.
        time.sleep(_SECONDS_TO_STRIKE)
        raise RunError("the worker processes were terminated", hint="finished points are kept")
    if code is None:
        return ""
    return f" by {signal.Signals(-code).name}" if code < 0 else f" with exit code {code}"


def _end(processes: list[BaseProcess]) -> None:
    """End these processes now; the processes of a pool that was shut down in order have ended."""
    for process in processes:
        process.terminate()
    for process in processes:
        _wait_for_end(process)
        if process.exitcode is None:
            process.kill()
            process.join()


def _wait_for_end(process: BaseProcess) -> None:
    """Wait some seconds. Not by ``join``: its pool waits too, and the second to ask gets no right exit code."""
    until = time.monotonic() + _SECONDS_TO_END
    while process.exitcode is None and time.monotonic() < until:
        time.sleep(0.005)
