"""The executor over several machines: the workers of a cluster of dask.distributed compute, this process keeps.

Works go out in batches that take about half a second, as the scheduler needs milliseconds for each. A batch is sized
by what works took before, and a worker gives back what it does not get to. Each worker has one batch in hand and one
ahead.

Each worker is a slot. A batch is sent to one slot and runs nowhere else, so that it is known what was under way where a
worker died. Threads of dask put what happens into one queue, ``Crew.next``, and the executor takes it from there, in
its own thread. What computes is sent to the cluster once, and its workers pass it on to each other. Each worker then
holds it as the result of a task of its own. So it goes when the client goes, whatever ends this process.

Rejected: leaving it to dask where a batch runs, and to compute it again where a worker dies. By default it would do so
three times, and say nothing of it; a point that kills its worker would kill four, and take its whole batch with it.
"""

from __future__ import annotations

import asyncio
import json
import logging
import os
import pickle
import platform
import re
import time
from collections.abc import Callable, Coroutine, Generator, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from codesign.ground import node
from codesign.ground.errors import CodesignError, InputError, RunError
from codesign.ground.interrupts import held
from codesign.ground.late import late
from codesign.ground.units import counted
from codesign.study.evaluation import Done, Evaluator
from codesign.study.identity import code_digest, digests_of, package_digest
from codesign.study.partition import Work
from codesign.study.work_queue import Packing, Slot, WorkQueue
from codesign.system.memory import share_of_memory

if TYPE_CHECKING:
    import distributed
else:
    distributed = late("distributed")
worker_pickle = late("distributed.protocol.pickle")

SECONDS_A_BATCH = 0.5
"""The seconds that a batch is to take: long beside the milliseconds of the scheduler, short beside a study."""

_SECONDS_BETWEEN_LOOKS = 1.0
_SECONDS_TO_JOIN = 120.0


class _Slot(Slot):
    """A worker. ``held``: what computes there; None until it has it. The tasks of dask lead to its ``batches``."""

    def __init__(self, address: str) -> None:
        super().__init__(address)
        self.address = address
        self.held: distributed.Future | None = None


@dataclass(frozen=True)
class Came:
    """A batch came in: what came of its first ``works``, in order. ``seconds``: what they took."""

    slot: _Slot
    works: Sequence[Work]
    done: Sequence[Done]
    seconds: float


@dataclass(frozen=True)
class Left:
    """A worker left with these works under way. ``expected``: it was asked to, so that it is no fault of theirs."""

    works: Sequence[Work]
    expected: bool


class _CancelledError(Exception):
    """A task was cancelled."""


class _Computing:
    """The tools that a worker computes with: an evaluator, and the packing of what it sends back."""

    def __init__(self, evaluate: Evaluator) -> None:
        self._packing = Packing(evaluate)
        self._files = evaluate.files()

    def __call__(self, works: Sequence[Work], seconds: float) -> tuple[list[Done], float]:
        return self._packing(works, seconds)

    @property
    def differing(self) -> list[str]:
        """The files that this worker has not, or not as they were where the study was begun."""
        here = digests_of(self._files)
        return [str(file) for file, digest in self._files.items() if here[file] != digest]


def _differing(held: node.Held) -> list[str]:
    assert isinstance(held.compute, _Computing)
    return held.compute.differing


def workers_of(client: distributed.Client) -> dict[str, Any] | None:
    """The facts that the scheduler has of each of its workers, by address; None if it does not answer."""
    # Not client.scheduler_info(): releases up to 2026.3 at least name five workers, and a timer refreshes these five.
    try:
        identity = client.sync(client.scheduler.identity, n_workers=-1) if client.scheduler else None
    except OSError:
        return None
    return identity and dict(identity["workers"])


class Crew:
    """The workers of a cluster that compute one study.

    Args:
        client: of the cluster.
        evaluate: what the workers compute with.

    ``cold``: whether a worker joined whose node had no kernel yet.
    """

    def __init__(self, client: distributed.Client, evaluate: Evaluator) -> None:
        self.client = client
        self.where = str(client.scheduler.address) if client.scheduler else "the cluster"
        # Of plain pickles and of functions of the main script, which are pickled by value.
        self._data: bytes = worker_pickle.dumps(_Computing(evaluate))
        self._sending: asyncio.Future[Any] | None = None
        self._sent: distributed.Future | None = None
        self._slots: dict[str, _Slot] = {}
        self._events: SimpleQueue[Callable[[], Came | Left | None]] = SimpleQueue()
        self._looked = -_SECONDS_BETWEEN_LOOKS
        self.refused: dict[str, str] = {}
        self.cold = False

    @property
    def ready(self) -> list[_Slot]:
        """The workers that take batches."""
        return [slot for slot in self._slots.values() if slot.held is not None]

    @property
    def joining(self) -> list[_Slot]:
        """The workers that are looked over."""
        return [slot for slot in self._slots.values() if slot.held is None]

    def send(self, slot: _Slot, works: list[Work]) -> None:
        """Send a batch to a worker; no work of it is begun after twice the seconds of a batch."""
        with held():
            data = pickle.dumps(works, pickle.HIGHEST_PROTOCOL)
            future = self._submit(slot.address, node.compute, slot.held, data, 2 * SECONDS_A_BATCH)
            slot.batches[future] = works
            self._begun(self._fetch(future), partial(self._came, slot, future))

    def next(self, seconds: float) -> Came | Left | None:
        """The next event; None after so many seconds, or if nothing has to be done about it.

        Raises:
            RunError: the scheduler is gone; or a worker that was there at the beginning cannot compute.
        """
        self.look()
        try:
            return self._events.get(timeout=max(0.0, min(seconds, _SECONDS_BETWEEN_LOOKS)))()
        except Empty:
            return None

    def look(self) -> None:
        """See from time to time who there is: those who came are looked over, those who left are noted.

        Raises:
            RunError: the scheduler is gone.
        """
        if time.monotonic() - self._looked < _SECONDS_BETWEEN_LOOKS:
            return
        there = workers_of(self.client)
        if self.client.status != "running":
            raise self._gone()
        self._looked = time.monotonic()
        if there is None:
            return
        for slot in [slot for address, slot in self._slots.items() if address not in there]:
            self._events.put(partial(self._left, slot, expected=False))
        for address in there:
            if address not in self._slots and address not in self.refused:
                self._slots[address] = slot = _Slot(address)
                self.client.subscribe_topic(address, partial(self._heard, slot))
                self._begun(self._join(address), partial(self._joined, slot))

    def end(self) -> None:
        """Let all workers go; what they have not begun is not computed any more."""
        with held():
            slots, self._slots = list(self._slots.values()), {}
            for slot in slots:
                self._let_go(slot)
            if self._sent is not None:
                self._sent.release()

    def _submit(self, address: str, function: Callable[..., Any], *arguments: Any) -> distributed.Future:
        """Run a function on one worker and on no other."""
        return self.client.submit(function, *arguments, workers=[address], allow_other_workers=False, pure=False)

    def _begun(self, coroutine: Coroutine[Any, Any, Any], end: Callable[[Future[Any]], Came | Left | None]) -> None:
        """Begin a coroutine in the thread of the client; ``end`` is called with it in the thread of the executor."""
        future = asyncio.run_coroutine_threadsafe(coroutine, self.client.loop.asyncio_loop)
        future.add_done_callback(lambda future: self._events.put(partial(end, future)))

    async def _fetch(self, future: distributed.Future) -> Any:
        """The value that a task gives. Not to be cancelled: dask gathers results of several tasks in one request."""
        loop, ended = asyncio.get_running_loop(), asyncio.Event()
        future.add_done_callback(lambda _: loop.call_soon_threadsafe(ended.set))
        await ended.wait()
        # A gather that finds a task cancelled leaves a traceback on the terminal.
        if future.cancelled():
            raise _CancelledError
        return await self.client.gather(future, asynchronous=True)

    async def _join(self, address: str) -> tuple[distributed.Future | None, str]:
        """The evaluator that a worker holds; or the reason for which the worker cannot compute."""
        async with asyncio.timeout(_SECONDS_TO_JOIN):
            here, digest = node.versions(), code_digest()
            there = await self._fetch(self._submit(address, node.introduced, digest))
            others = {name: had for name, had in there["versions"].items() if had != here.get(name)}
            if others:
                words = ", ".join(f"{name} {had} (here {here.get(name)})" for name, had in others.items())
                return None, f"it has {words}"
            if there["fault"]:
                return None, there["fault"]
            if (there["host"], there["process"]) == (platform.node(), os.getpid()):
                return None, "it is a thread of this process, and works need processes of their own"
            if await self._fetch(self._submit(address, package_digest)) != package_digest():
                return None, "it has other code of codesign, or other plug-ins"
            # Lost where every worker that had it died.
            if self._sending is None or (self._sent is not None and self._sent.status != "finished"):
                sending = self.client.scatter(self._data, broadcast=True, hash=False, asynchronous=True)
                self._sent, self._sending = None, asyncio.ensure_future(sending)
            self._sent = await self._sending
            holding = self._submit(address, node.hold, self._sent, digest)
            files = await self._fetch(self._submit(address, _differing, holding))
            self.cold |= there["cold"]
            fault = f"its files differ from those here, or are not there: {', '.join(files[:3])}" if files else ""
            return (None, fault) if fault else (holding, "")

    def _joined(self, slot: _Slot, end: Future[Any]) -> None:
        if self._slots.get(slot.address) is not slot:
            return
        try:
            slot.held, fault = end.result()
        except TimeoutError:
            fault = f"it did not answer within {_SECONDS_TO_JOIN:.0f} s"
        except ImportError as wrong:
            fault = f"it cannot import codesign as it is here: {wrong}"
        except Exception as wrong:
            self._check_scheduler()
            fault = f"{type(wrong).__name__}: {wrong}"
        if fault:
            self.refused[slot.address] = fault
            self._let_go(self._slots.pop(slot.address))

    def _came(self, slot: _Slot, task: distributed.Future, end: Future[Any]) -> Came | Left | None:
        if task not in slot.batches:
            return None
        try:
            done, seconds = end.result()
        except Exception as wrong:
            self._check_scheduler()
            if type(wrong).__name__ == "KilledWorker":
                return self._left(slot, expected=False)
            # By us it was not: then it would be no batch of the slot.
            if isinstance(wrong, _CancelledError | CancelledError):
                raise self._gone() from wrong
            what = f"worker {slot.address} failed: {type(wrong).__name__}: {wrong}"
            raise RunError(what, hint="finished points are kept; look into the worker's log") from wrong
        return Came(slot, slot.batches.pop(task), done, seconds)

    def _heard(self, slot: _Slot, event: tuple[float, Any]) -> None:
        """Note in the thread of the client that a worker left."""
        if isinstance(event[1], dict) and event[1].get("action") == "remove-worker":
            self._events.put(partial(self._left, slot, bool(event[1].get("expected"))))

    def _left(self, slot: _Slot, expected: bool) -> Left | None:
        # A worker that begins again may have the address of the one that died.
        if self._slots.get(slot.address) is not slot:
            return None
        works = slot.works
        self._let_go(self._slots.pop(slot.address))
        self._looked = -_SECONDS_BETWEEN_LOOKS
        return Left(works, expected) if works else None

    def _let_go(self, slot: _Slot) -> None:
        """Cancel what is under way on a slot that is a slot no more."""
        futures = [*slot.batches, *([slot.held] if slot.held is not None else [])]
        slot.batches, slot.held = {}, None
        if self.client.status == "running":
            self.client.unsubscribe_topic(slot.address)
            if futures:
                self.client.loop.add_callback(self.client.cancel, futures, asynchronous=True, force=True)

    def _check_scheduler(self) -> None:
        if self.client.status != "running":
            raise self._gone()

    def _gone(self) -> RunError:
        hint = "finished points are kept: the same command goes on from there, on any cluster or without one"
        return RunError(f"the scheduler of the cluster at {self.where} went away", hint=hint)


_SECONDS_TO_CONNECT = 10
_MOST_OF_A_FILE = 2**20
_ADDRESS = re.compile(r"(?:(?:tcp|tls|ws|wss|ucx)://)?(?:\[[0-9a-fA-F:.]+\]|[^\s/:\[\]]+):([0-9]{1,5})")
_EXTRA = "pip install 'hwsw-codesign[cluster]'"
_FORMS = "write tcp://HOST:PORT, tls://HOST:PORT, or the name of the scheduler's file, such as scheduler.json"


class ClusterExecutor:
    """Computes with the workers of a cluster of dask.distributed.

    A worker that dies costs a retry of what it had under way. Workers that come later are used too. Each worker process
    computes one work at a time, whatever number of threads it has.

    Args:
        cluster: the address of its scheduler, or the name of the file that the scheduler writes; or a client, which
            stays open.
        patience: seconds to wait for workers where there is none.

    ``died``: how many workers died with work under way, so that it was computed again. ``compiling``: called once
    where works went out to a worker whose node has no kernel yet: it compiles them first.

    Raises:
        InputError: dask.distributed is not installed, or this is no address. RunError: no scheduler answers.
    """

    def __init__(self, cluster: str | distributed.Client, *, patience: float = 60.0) -> None:
        self._own = isinstance(cluster, str)
        self.client = _connected(cluster) if isinstance(cluster, str) else cluster
        self.patience = patience
        self.died = 0
        self.compiling: Callable[[], object] = lambda: None

    def __enter__(self) -> ClusterExecutor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the cluster; a client that was handed in stays."""
        if self._own:
            with _quiet():
                self.client.close(timeout=1)

    @property
    def workers(self) -> int:
        """The number of workers now."""
        return len(self._infos())

    @property
    def words(self) -> str:
        """The cluster in words, such as ``2 workers on 1 machine``."""
        infos = self._infos()
        return f"{counted(len(infos), 'worker')} on {counted(len({info['host'] for info in infos}), 'machine')}"

    def share(self, memory: int | None) -> int:
        """The bytes that one worker may take: of a bound for all; by default what the least of them is allowed."""
        limits = [info["memory_limit"] for info in self._infos() if info.get("memory_limit")]
        if memory is None and limits:
            return int(min(limits))
        return share_of_memory(max(1, self.workers), memory)

    def run(self, works: Iterable[Work], evaluate: Evaluator) -> Generator[Done, None, None]:
        """The outcome of each piece of work, as it comes in.

        Raises:
            RunError: a worker cannot compute what this process does, no worker is left, or the scheduler went away.
        """
        queue = WorkQueue(works, evaluate.space, max(1, self.workers), SECONDS_A_BATCH)
        with _quiet():
            crew = Crew(self.client, evaluate)
            try:
                self._gather(crew)
                told = False
                while self._work(crew, queue):
                    if crew.cold and not told:
                        told = True
                        self.compiling()
                    match crew.next(self.patience):
                        case Came() as batch:
                            came = queue.came(batch.slot, batch.works, batch.done, batch.seconds)
                            queue.hand_out(crew.ready, crew.send)
                            for done in came:
                                yield from queue.take(done)
                        case Left(works=lost, expected=True):
                            queue.put_back(lost)
                        case Left(works=lost):
                            self.died += 1
                            yield from queue.after_death(lost, "")
            finally:
                crew.end()

    def _gather(self, crew: Crew) -> None:
        """Wait until all workers that there are were looked over.

        Raises:
            RunError: one of them cannot compute, or there is none.
        """
        crew.look()
        while crew.joining:
            crew.next(self.patience)
        if crew.refused:
            raise _refusal(crew)

    def _work(self, crew: Crew, queue: WorkQueue) -> bool:
        """Give all workers something to do; whether anything is left to wait for.

        Raises:
            RunError: no worker is left for it.
        """
        until = time.monotonic() + self.patience
        while True:
            queue.workers = max(1, len(crew.ready))
            queue.hand_out(crew.ready, crew.send)
            if any(slot.batches for slot in crew.ready):
                return True
            if crew.ready or queue.is_empty():
                return False
            if time.monotonic() > until and not crew.joining:
                raise _refusal(crew) if crew.refused else _no_worker(crew, self.patience)
            crew.next(1.0)

    def _infos(self) -> list[dict[str, Any]]:
        return list((workers_of(self.client) or {}).values())


def _refusal(crew: Crew) -> RunError:
    faults = [f"worker {address}: {fault}" for address, fault in crew.refused.items()]
    return RunError(
        f"the cluster at {crew.where} cannot compute this\n" + "\n".join(faults[:5]),
        hint="install the same versions of Python, hwsw-codesign and its packages on all machines, and restart the"
        " workers as processes of their own",
    )


def _no_worker(crew: Crew, patience: float) -> RunError:
    hint = f"start some: dask worker {crew.where} --nthreads 1; finished points are kept"
    return RunError(f"the cluster at {crew.where} had no worker for {patience:.0f} s", hint=hint)


def _connected(cluster: str) -> distributed.Client:
    try:
        client = distributed.Client.__new__(distributed.Client)
    except ImportError:
        raise InputError("a cluster needs dask.distributed", hint=_EXTRA) from None
    address = _address_of(cluster)
    try:
        with _quiet(), ThreadPoolExecutor(1) as apart:
            apart.submit(asyncio.run, _greeted(address)).result()
            client.__init__(address, timeout=_SECONDS_TO_CONNECT, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError, ImportError, MemoryError, EOFError) as fault:
        # Otherwise its end would wait for a connection that there is not, and print a traceback.
        client.status = "closed"
        raise _unreachable(address, fault) from fault
    return client


async def _greeted(address: str) -> None:
    """Exchange dask's greeting with the scheduler: a client of dask waits for it without end."""
    options = distributed.Security().get_connection_args("client")
    greeting = distributed.comm.connect(address, timeout=_SECONDS_TO_CONNECT, **options)
    (await asyncio.wait_for(greeting, _SECONDS_TO_CONNECT)).abort()


def _unreachable(address: str, fault: BaseException) -> CodesignError:
    cause = fault
    while cause.__cause__ is not None:
        cause = cause.__cause__
    if address.startswith("tls://") and isinstance(fault, TypeError | RuntimeError | ValueError):
        hint = "set distributed.comm.tls.ca-file and distributed.comm.tls.client in dask's configuration"
        return InputError(f"{address} needs certificates: {cause}", "--cluster", hint)
    if "encryption required" in str(cause):
        what = f"{address} is not encrypted, as dask's configuration requires (require-encryption)"
        return InputError(what, "--cluster", "write tls://HOST:PORT")
    why = "what answers is no scheduler" if isinstance(fault, MemoryError | EOFError) else str(cause)
    what = f"no scheduler answers at {address}: {why or f'nothing came within {_SECONDS_TO_CONNECT} s'}"
    hint = "start one with dask scheduler, or check host, port and firewall; nothing was computed, and nothing is lost"
    return RunError(what, "--cluster", hint)


def _address_of(cluster: str) -> str:
    """The address of a scheduler, as it is given or as it stands in the scheduler's file."""
    address = cluster
    if cluster.endswith(".json"):
        try:
            with Path(cluster).open("rb") as file:
                content = json.loads(file.read(_MOST_OF_A_FILE))
            if "address" not in content:
                raise ValueError("it has no address")
            address = content["address"]
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as wrong:
            what = f"{cluster} is no file of a scheduler: {wrong}"
            raise InputError(what, "--cluster", "dask scheduler --scheduler-file FILE writes one") from wrong
    port = _ADDRESS.fullmatch(address) if isinstance(address, str) else None
    if port is None or not 0 < int(port.group(1)) < 2**16:
        raise InputError(f"{address!r:.80} is no address of a scheduler", "--cluster", _FORMS)
    return address


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what dask logs of workers that come and go off the terminal: this module reports it."""
    logger = logging.getLogger("distributed")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(level)
