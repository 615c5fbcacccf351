"""The workers of a dask cluster as an executor sees them: who there is, what each is doing, and who has left.

Each worker is a seat. A batch of works is sent to one seat and runs nowhere else, so that it is known what was under
way where a worker died. Threads of dask put what happens into one queue, ``Crew.next``, and the executor takes it from
there, in its own thread.

What computes is sent to the cluster once, and its workers pass it on to each other. Each worker then holds it as the
result of a task of its own. So it goes when the client goes, whatever ends this process.
"""

from __future__ import annotations

import asyncio
import os
import pickle
import platform
import time
from collections.abc import Callable, Coroutine, Sequence
from concurrent.futures import CancelledError, Future
from dataclasses import dataclass, field
from functools import partial
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from codesign import node
from codesign.errors import RunError
from codesign.exploration.evaluation import Done, Evaluator
from codesign.exploration.identity import code_digest, digests_of, package_digest
from codesign.exploration.packing import Packing
from codesign.exploration.partition import Work
from codesign.interrupts import held

if TYPE_CHECKING:
    import distributed

SECONDS_A_BATCH = 0.5
"""What a batch is to take: long beside the milliseconds of the scheduler, short beside a study."""

_SECONDS_BETWEEN_LOOKS = 1.0
_SECONDS_TO_JOIN = 120.0


@dataclass(eq=False)
class Batch:
    """Works under way on a seat. ``task``: of dask, which computes them."""

    works: list[Work]
    task: distributed.Future


@dataclass(eq=False)
class Seat:
    """A worker. ``held``: what computes there; None until it has it. ``batches``: under way, the first one first."""

    address: str
    held: distributed.Future | None = None
    batches: list[Batch] = field(default_factory=list)

    @property
    def works(self) -> list[Work]:
        """All works under way."""
        return [work for batch in self.batches for work in batch.works]


@dataclass(frozen=True)
class Came:
    """A batch came in: what came of its first works, in order. ``seconds``: what they took."""

    seat: Seat
    batch: Batch
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
    """What a worker computes with: an evaluator, and the packing of what it sends back."""

    def __init__(self, evaluate: Evaluator) -> None:
        self._packing = Packing(evaluate)
        self._files = evaluate.files()

    def __call__(self, work: Work) -> Done:
        return self._packing(work)

    @property
    def differing(self) -> list[str]:
        """The files that this worker has not, or not as they were where the study was begun."""
        here = digests_of(self._files)
        return [str(file) for file, digest in self._files.items() if here[file] != digest]


def _differing(held: node.Held) -> list[str]:
    assert isinstance(held.compute, _Computing)
    return held.compute.differing


def workers_of(client: distributed.Client) -> dict[str, Any] | None:
    """What the scheduler says of each of its workers, by address; None where it does not answer."""
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
        from distributed.protocol.pickle import dumps

        self.client = client
        self.where = str(client.scheduler.address) if client.scheduler else "the cluster"
        # Of plain pickles and of functions of the main script, which are pickled by value.
        self._data: bytes = dumps(_Computing(evaluate))
        self._sending: asyncio.Future[Any] | None = None
        self._sent: distributed.Future | None = None
        self._seats: dict[str, Seat] = {}
        self._events: SimpleQueue[Callable[[], Came | Left | None]] = SimpleQueue()
        self._looked = -_SECONDS_BETWEEN_LOOKS
        self.refused: dict[str, str] = {}
        self.cold = False

    @property
    def ready(self) -> list[Seat]:
        """The workers that take batches."""
        return [seat for seat in self._seats.values() if seat.held is not None]

    @property
    def joining(self) -> list[Seat]:
        """The workers that are looked over."""
        return [seat for seat in self._seats.values() if seat.held is None]

    def send(self, seat: Seat, works: list[Work]) -> None:
        """Send a batch to a worker; no work of it is begun after twice the seconds of a batch."""
        with held():
            data = pickle.dumps(works, pickle.HIGHEST_PROTOCOL)
            future = self._submit(seat.address, node.compute, seat.held, data, 2 * SECONDS_A_BATCH)
            batch = Batch(works, future)
            seat.batches.append(batch)
            self._begun(self._fetch(future), partial(self._came, seat, batch))

    def next(self, seconds: float) -> Came | Left | None:
        """What happens next; None after so many seconds, or where nothing has to be done about it.

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
        for seat in [seat for address, seat in self._seats.items() if address not in there]:
            self._events.put(partial(self._left, seat, expected=False))
        for address in there:
            if address not in self._seats and address not in self.refused:
                self._seats[address] = seat = Seat(address)
                self.client.subscribe_topic(address, partial(self._heard, seat))
                self._begun(self._join(address), partial(self._joined, seat))

    def end(self) -> None:
        """Let all workers go; what they have not begun is not computed any more."""
        with held():
            seats, self._seats = list(self._seats.values()), {}
            for seat in seats:
                self._let_go(seat)
            if self._sent is not None:
                self._sent.release()

    def _submit(self, address: str, function: Callable[..., Any], *arguments: Any) -> distributed.Future:
        """Run a function on one worker and on no other."""
        return self.client.submit(
            function, *arguments, workers=[address], allow_other_workers=False, pure=False
        )

    def _begun(
        self, coroutine: Coroutine[Any, Any, Any], end: Callable[[Future[Any]], Came | Left | None]
    ) -> None:
        """Begin a coroutine in the thread of the client; ``end`` is called with it in the thread of the executor."""
        future = asyncio.run_coroutine_threadsafe(coroutine, self.client.loop.asyncio_loop)
        future.add_done_callback(lambda future: self._events.put(partial(end, future)))

    async def _fetch(self, future: distributed.Future) -> Any:
        """What a task gives. Not to be cancelled: dask gathers the results of several tasks in one request."""
        loop, ended = asyncio.get_running_loop(), asyncio.Event()
        future.add_done_callback(lambda _: loop.call_soon_threadsafe(ended.set))
        await ended.wait()
        # A gather that finds a task cancelled leaves a traceback on the terminal.
        if future.cancelled():
            raise _CancelledError
        return await self.client.gather(future, asynchronous=True)

    async def _join(self, address: str) -> tuple[distributed.Future | None, str]:
        """What computes, held by a worker; or why the worker cannot compute."""
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
            fault = (
                f"its files differ from those here, or are not there: {', '.join(files[:3])}" if files else ""
            )
            return (None, fault) if fault else (holding, "")

    def _joined(self, seat: Seat, end: Future[Any]) -> None:
        if self._seats.get(seat.address) is not seat:
            return
        try:
            seat.held, fault = end.result()
        except TimeoutError:
            fault = f"it did not answer within {_SECONDS_TO_JOIN:.0f} s"
        except ImportError as wrong:
            fault = f"it cannot import codesign as it is here: {wrong}"
        except Exception as wrong:
            self._check_scheduler()
            fault = f"{type(wrong).__name__}: {wrong}"
        if fault:
            self.refused[seat.address] = fault
            self._let_go(self._seats.pop(seat.address))

    def _came(self, seat: Seat, batch: Batch, end: Future[Any]) -> Came | Left | None:
        if batch not in seat.batches:
            return None
        try:
            done, seconds = end.result()
        except Exception as wrong:
            self._check_scheduler()
            if type(wrong).__name__ == "KilledWorker":
                return self._left(seat, expected=False)
            # By us it was not: then it would be no batch of the seat.
            if isinstance(wrong, _CancelledError | CancelledError):
                raise self._gone() from wrong
            raise RunError(
                f"worker {seat.address} failed: {type(wrong).__name__}: {wrong}",
                hint="finished points are kept; look into the worker's log",
            ) from wrong
        seat.batches.remove(batch)
        return Came(seat, batch, done, seconds)

    def _heard(self, seat: Seat, event: tuple[float, Any]) -> None:
        """Note in the thread of the client that a worker left."""
        if isinstance(event[1], dict) and event[1].get("action") == "remove-worker":
            self._events.put(partial(self._left, seat, bool(event[1].get("expected"))))

    def _left(self, seat: Seat, expected: bool) -> Left | None:
        # A worker that begins again may have the address of the one that died.
        if self._seats.get(seat.address) is not seat:
            return None
        works = seat.works
        self._let_go(self._seats.pop(seat.address))
        self._looked = -_SECONDS_BETWEEN_LOOKS
        return Left(works, expected) if works else None

    def _let_go(self, seat: Seat) -> None:
        """Cancel what is under way on a seat that is a seat no more."""
        futures = [batch.task for batch in seat.batches] + ([seat.held] if seat.held is not None else [])
        seat.batches, seat.held = [], None
        if self.client.status == "running":
            self.client.unsubscribe_topic(seat.address)
            if futures:
                self.client.loop.add_callback(self.client.cancel, futures, asynchronous=True, force=True)

    def _check_scheduler(self) -> None:
        if self.client.status != "running":
            raise self._gone()

    def _gone(self) -> RunError:
        return RunError(
            f"the scheduler of the cluster at {self.where} went away",
            hint="finished points are kept: the same command goes on from there, on any cluster or without one",
        )
