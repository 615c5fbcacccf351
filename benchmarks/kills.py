"""Kill studies at random moments, and compare the table of each with that of a study that nothing struck.

python -m benchmarks.kills coordinator [COUNT]    kill -9 of hwsw explore, which then runs again until it ends
python -m benchmarks.kills worker [COUNT]         kill -9 of a local worker process; the study goes on
python -m benchmarks.kills cluster [COUNT]        kill -9 of a worker of a cluster, which its nanny begins again
python -m benchmarks.kills resume                 what a study costs that is killed halfway and goes on

Each prints one line a kill, and ends with exit code 1 where a table differs in one byte. Moments are drawn from a fixed
seed over the time that the study takes.
"""

from __future__ import annotations

import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import psutil

from benchmarks.local_cluster import ENVIRONMENT, Cluster, cluster

SPEC = """\
kind: workload
name: struck
planner: harmonic
problem:
  map: {generate: rooms, rows: 48, columns: 72, room: [11, 11], door: 3, seed: 1, extra_doors: 0.2}
  goals: [[5, 5]]
  starts: {count: 5, seed: 0}
mapping:
  relax: {component: fpga, block: [24, 36], iterations: 6, schedule: {first: 7, step: 8, last: 63}}
  decide: {component: fpga}
explore:
  axes:
    workload.problem.map.seed: {from: 1, to: 60}
    relax.iterations: [4, 6]
    fpga.clock: [50 MHz, 100 MHz, 150 MHz]
"""
SEED = 12
NO_WORKER = "no worker"
MOST_TRIES = 20


class Study:
    """A study in a folder of its own. ``words``: what computes it."""

    def __init__(self, folder: Path, *words: str) -> None:
        folder.mkdir(exist_ok=True)
        self.folder, self.words = folder, words or ("--workers", "2")
        self.table = folder / "points.csv"

    def begin(self) -> subprocess.Popen[bytes]:
        (self.folder / "struck.yaml").write_text(SPEC)
        command = [sys.executable, "-m", "codesign", "explore", "virtex4-pci", "struck.yaml", "-q", *self.words]
        command += ["--store", "points.sqlite", "--csv", "points.csv"]
        log = (self.folder / "log").open("ab")
        with log:
            return subprocess.Popen(command, cwd=self.folder, stdout=log, stderr=log, env=ENVIRONMENT)

    def finish(self) -> float:
        """Run to the end, again where a worker died as it started; the seconds it took."""
        begun = time.perf_counter()
        for _ in range(MOST_TRIES):
            if self.begin().wait() == 0:
                return time.perf_counter() - begun
        raise SystemExit(f"{self.folder}: no end after {MOST_TRIES} runs\n{(self.folder / 'log').read_text()}")


def coordinator(study: Study, seconds: float) -> str:
    """Kill the process that keeps the points after so many seconds, and go on."""
    running = study.begin()
    try:
        running.wait(seconds)
    except subprocess.TimeoutExpired:
        running.kill()
        running.wait()
    study.finish()
    return "coordinator"


def worker(study: Study, seconds: float) -> str:
    """Kill one of the processes that compute."""
    running = study.begin()
    killed = _kill_one_of(lambda: psutil.Process(running.pid).children(recursive=True), running, seconds)
    if running.wait() != 0:
        study.finish()
    return killed


def worker_of(started: Cluster) -> Callable[[Study, float], str]:
    """Kill a worker of a cluster, not its nanny."""

    def strike(study: Study, seconds: float) -> str:
        running = study.begin()
        nannies = [psutil.Process(each.pid) for each in started.workers]
        killed = _kill_one_of(
            lambda: [child for nanny in nannies for child in nanny.children(recursive=True)], running, seconds
        )
        if running.wait() != 0:
            study.finish()
        return killed

    return strike


def _kill_one_of(
    processes: Callable[[], list[psutil.Process]], running: subprocess.Popen[bytes], seconds: float
) -> str:
    """Kill a random process that computes, after so many seconds or as soon as there is one; what it was."""
    time.sleep(seconds)
    while running.poll() is None:
        try:
            # A resource tracker of multiprocessing is a child too, and computes nothing.
            computing = [each for each in processes() if "resource_tracker" not in " ".join(each.cmdline())]
            victim = random.choice(computing)
            victim.kill()
        except (IndexError, psutil.Error):
            time.sleep(0.01)
        else:
            return f"worker {victim.pid}"
    return NO_WORKER


def struck(kind: str, count: int, folder: Path) -> Iterator[bool]:
    """Whether the table of each struck study is that of the one that nothing struck."""
    random.seed(SEED)
    with ExitStack() as stack:
        words: tuple[str, ...] = ()
        strike = {"coordinator": coordinator, "worker": worker}.get(kind)
        if strike is None:
            started = stack.enter_context(cluster(folder, nanny=True))
            words, strike = ("--cluster", started.address), worker_of(started)
        whole = Study(folder / "whole", *words)
        whole.finish()
        (folder / "whole" / "points.sqlite").unlink()
        seconds = whole.finish()
        expected = whole.table.read_bytes()
        print(f"not struck: {seconds:.1f} s, {len(expected)} bytes", flush=True)
        for number in range(1, count + 1):
            victim = NO_WORKER
            for attempt in range(MOST_TRIES):
                moment = random.uniform(0.0, seconds)
                study = Study(folder / f"{number}-{attempt}", *words)
                victim = strike(study, moment)
                if victim != NO_WORKER:
                    break
            same = study.table.read_bytes() == expected
            print(f"{number}: {victim} killed after {moment:.2f} s: {'equal' if same else 'DIFFERS'}", flush=True)
            yield same


def resume(folder: Path) -> None:
    """What a study costs that is killed halfway and goes on, beside one that nothing struck."""
    whole = Study(folder / "whole")
    whole.finish()
    (folder / "whole" / "points.sqlite").unlink()
    seconds = whole.finish()
    again = whole.finish()
    half = Study(folder / "half")
    begun = time.perf_counter()
    running = half.begin()
    time.sleep(seconds / 2)
    running.kill()
    running.wait()
    half.finish()
    both = time.perf_counter() - begun
    print(f"not struck {seconds:.1f} s; killed halfway and gone on {both:.1f} s: {both / seconds - 1:+.1%}")
    print(f"run again with every point kept {again:.1f} s: {again / seconds:.1%}")


def main(words: list[str]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        match words:
            case ["resume"]:
                resume(Path(folder))
            case [("coordinator" | "worker" | "cluster") as kind, *count] if len(count) < 2:
                every = list(struck(kind, int(count[0]) if count else 50, Path(folder)))
                print(f"{sum(every)} of {len(every)} tables equal")
                if not all(every):
                    raise SystemExit(1)
            case _:
                raise SystemExit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
