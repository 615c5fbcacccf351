"""The executor over several machines: the workers of a cluster of dask.distributed compute, this process keeps.

Works go out in batches that take about half a second, as the scheduler needs milliseconds for each. A batch is sized
by what works took before, and a worker gives back what it does not get to. Each worker has one batch in hand and one
ahead.

Rejected: leaving it to dask where a batch runs, and to compute it again where a worker dies. By default it would do so
three times, and say nothing of it; a point that kills its worker would kill four, and take its whole batch with it.
"""

from __future__ import annotations

import asyncio
import json
import logging
import re
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codesign.errors import CodesignError, InputError, RunError
from codesign.exploration.batches import BATCHES_AHEAD, BatchSize, drawn
from codesign.exploration.crew import SECONDS_A_BATCH, Came, Crew, Left, workers_of
from codesign.exploration.evaluation import Done, Evaluator
from codesign.exploration.partition import Work
from codesign.exploration.work_queue import WorkQueue
from codesign.system.memory import share_of_memory
from codesign.units import counted

if TYPE_CHECKING:
    import distributed

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
        """How many workers there are now."""
        return len(self._infos())

    @property
    def words(self) -> str:
        """The cluster in words, such as ``2 workers on 1 machine``."""
        infos = self._infos()
        return (
            f"{counted(len(infos), 'worker')} on {counted(len({info['host'] for info in infos}), 'machine')}"
        )

    def share(self, memory: int | None) -> int:
        """The bytes that one worker may take: of a bound for all; by default what the least of them is allowed."""
        limits = [info["memory_limit"] for info in self._infos() if info.get("memory_limit")]
        if memory is None and limits:
            return int(min(limits))
        return share_of_memory(max(1, self.workers), memory)

    def run(self, works: Iterable[Work], evaluate: Evaluator) -> Generator[Done, None, None]:
        """What came of each work, as it comes in.

        Raises:
            RunError: a worker cannot compute what this process does, no worker is left, or the scheduler went away.
        """
        queue = WorkQueue(works, evaluate, max(1, self.workers))
        size = BatchSize(SECONDS_A_BATCH)
        with _quiet():
            crew = Crew(self.client, evaluate)
            try:
                self._gather(crew)
                told = False
                while self._work(crew, queue, size):
                    if crew.cold and not told:
                        told = True
                        self.compiling()
                    match crew.next(self.patience):
                        case Came(seat=seat, batch=batch, done=done, seconds=seconds):
                            size.take(seconds, len(done))
                            queue.put_back(batch.works[len(done) :], seat.address)
                            _hand_out(crew, queue, size)
                            for work, each in zip(batch.works, done, strict=False):
                                yield from queue.take(replace(each, work=work))
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

    def _work(self, crew: Crew, queue: WorkQueue, size: BatchSize) -> bool:
        """Give all workers something to do; whether anything is left to wait for.

        Raises:
            RunError: no worker is left for it.
        """
        until = time.monotonic() + self.patience
        while True:
            queue.workers = max(1, len(crew.ready))
            _hand_out(crew, queue, size)
            if any(seat.batches for seat in crew.ready):
                return True
            if crew.ready or queue.is_empty():
                return False
            if time.monotonic() > until and not crew.joining:
                raise _refusal(crew) if crew.refused else _no_worker(crew, self.patience)
            crew.next(1.0)

    def _infos(self) -> list[dict[str, Any]]:
        return list((workers_of(self.client) or {}).values())


def _hand_out(crew: Crew, queue: WorkQueue, size: BatchSize) -> None:
    """Give each worker a batch, and then each a second one."""
    for depth in range(BATCHES_AHEAD):
        for seat in crew.ready:
            if len(seat.batches) <= depth and (works := drawn(queue, seat.address, seat.works, size.works)):
                crew.send(seat, works)


def _refusal(crew: Crew) -> RunError:
    faults = [f"worker {address}: {fault}" for address, fault in crew.refused.items()]
    return RunError(
        f"the cluster at {crew.where} cannot compute this\n" + "\n".join(faults[:5]),
        hint="install the same versions of Python, hwsw-codesign and its packages on all machines, and restart the"
        " workers as processes of their own",
    )


def _no_worker(crew: Crew, patience: float) -> RunError:
    return RunError(
        f"the cluster at {crew.where} had no worker for {patience:.0f} s",
        hint=f"start some: dask worker {crew.where} --nthreads 1; finished points are kept",
    )


def _connected(cluster: str) -> distributed.Client:
    try:
        import distributed
    except ImportError:
        raise InputError("a cluster needs dask.distributed", hint=_EXTRA) from None
    address = _address_of(cluster)
    client = distributed.Client.__new__(distributed.Client)
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
    from distributed import Security
    from distributed.comm import connect

    options = Security().get_connection_args("client")
    greeting = connect(address, timeout=_SECONDS_TO_CONNECT, **options)
    (await asyncio.wait_for(greeting, _SECONDS_TO_CONNECT)).abort()


def _unreachable(address: str, fault: BaseException) -> CodesignError:
    cause = fault
    while cause.__cause__ is not None:
        cause = cause.__cause__
    if address.startswith("tls://") and isinstance(fault, TypeError | RuntimeError | ValueError):
        return InputError(
            f"{address} needs certificates: {cause}",
            "--cluster",
            "set distributed.comm.tls.ca-file and distributed.comm.tls.client in dask's configuration",
        )
    if "encryption required" in str(cause):
        what = f"{address} is not encrypted, as dask's configuration requires (require-encryption)"
        return InputError(what, "--cluster", "write tls://HOST:PORT")
    why = "what answers is no scheduler" if isinstance(fault, MemoryError | EOFError) else str(cause)
    return RunError(
        f"no scheduler answers at {address}: {why or f'nothing came within {_SECONDS_TO_CONNECT} s'}",
        "--cluster",
        "start one with dask scheduler, or check host, port and firewall; nothing was computed, and nothing is lost",
    )


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
