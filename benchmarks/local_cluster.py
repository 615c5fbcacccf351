"""A real cluster of dask.distributed on this machine: a scheduler and workers, each a process of its own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

ROOT = Path(__file__).parent.parent
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "tests" / "support"), str(ROOT)])}
SECONDS = 60.0


class Cluster:
    """A scheduler with workers. ``folder``: for its files. ``nanny``: a worker that dies is begun again.

    ``config``: a configuration of dask with certificates; the cluster then speaks TLS.
    """

    def __init__(self, folder: Path, *, nanny: bool = False, config: Path | None = None) -> None:
        self.folder, self.nanny = folder, nanny
        self.config = {} if config is None else {"DASK_CONFIG": str(config)}
        self.protocol = () if config is None else ("--protocol", "tls")
        self.file = folder / "scheduler.json"
        self.workers: list[subprocess.Popen[bytes]] = []
        self.scheduler = self._start(
            "scheduler",
            *("--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(self.file), *self.protocol),
            *("--idle-timeout", "10 minutes"),  # where this process is killed before it ends the cluster
        )
        until = time.monotonic() + SECONDS
        while not self._is_written() and time.monotonic() < until:
            time.sleep(0.05)
        self.address: str = json.loads(self.file.read_text())["address"]

    def add(self, workers: int, **environment: str) -> None:
        """Start workers of one thread each, and wait until the scheduler has them."""
        for _ in range(workers):
            words = ("--host", "127.0.0.1", "--nthreads", "1", "--local-directory", str(self.folder))
            words = (*words, *self.protocol)
            kind = "--nanny" if self.nanny else "--no-nanny"
            self.workers.append(self._start("worker", self.address, *words, kind, **environment))
        if not self.workers:
            return
        import dask
        from distributed import Client

        own = dask.config.collect([*map(Path, self.config.values())], env={})  # type: ignore[attr-defined]
        given = dask.config.merge(dask.config.config, own)  # type: ignore[attr-defined]
        with (
            dask.config.set(given),  # type: ignore[attr-defined]
            Client(self.address, timeout=SECONDS, set_as_default=False) as client,
        ):
            client.wait_for_workers(len(self.workers), timeout=SECONDS)

    def end(self) -> None:
        """Kill all processes. Nannies end their workers themselves."""
        for process in [*self.workers, self.scheduler]:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait(SECONDS)

    def _is_written(self) -> bool:
        try:
            return "address" in json.loads(self.file.read_text())
        except (OSError, ValueError):
            return False

    def _start(self, kind: str, *words: str, **environment: str) -> subprocess.Popen[bytes]:
        log = (self.folder / f"{kind}-{len(self.workers)}.log").open("wb")
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *words, "--no-dashboard"]
        with log:
            return subprocess.Popen(
                command, stdout=log, stderr=log, env=ENVIRONMENT | self.config | environment, start_new_session=True
            )


@contextmanager
def cluster(folder: Path, workers: int = 2, *, nanny: bool = False, config: Path | None = None) -> Iterator[Cluster]:
    """A cluster until the end of the block."""
    started = Cluster(folder, nanny=nanny, config=config)
    try:
        started.add(workers)
        yield started
    finally:
        started.end()
