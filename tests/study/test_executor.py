from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest
from executor_contract import Contract, run
from explore_fakes import Fake, computed
from places import ROOT
from processes import gone

from codesign.study import executor
from codesign.study.evaluation import PointByPoint
from codesign.study.executor import Executor, ProcessExecutor, SerialExecutor
from codesign.study.space import Space
from codesign.study.store import EntryState

ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "tests" / "support"), str(ROOT)])}
"""That of a script that imports from the tests, and the package that they are of."""


class TestSerialExecutor(Contract):
    @pytest.fixture
    def executor(self) -> Executor:
        return SerialExecutor()


class TestProcessExecutor(Contract):
    @pytest.fixture
    def executor(self) -> Executor:
        return ProcessExecutor(2)


def test_several_processes_share_the_work(tmp_path: Path) -> None:
    log = tmp_path / "log"
    # One worker is alone until a point is run; from the fifth on each waits for company.
    run(ProcessExecutor(2), {"slices": list(range(20))}, log, limit=2, at=dict.fromkeys(range(4, 20), "meet"))
    workers = {line.split()[1] for line in log.read_text().splitlines()}
    assert len(workers) == 2
    assert str(os.getpid()) not in workers


def test_both_kinds_give_the_same_bytes() -> None:
    axes = {"do": ["nothing", "fail", "refuse"], "slices": [10, 2000], "share": [0.1, 1 / 3]}
    assert run(SerialExecutor(), axes) == run(ProcessExecutor(2), axes)


_DEATHS = {"die": "with exit code 9", "crash": "by SIGSEGV", "kill": "by SIGKILL"}
_FAST = {("die", 3, 2), ("crash", 1, 2), ("kill", 3, 1)}


@pytest.mark.parametrize(
    ("how", "cause", "limit", "workers"),
    [
        pytest.param(*(how, cause, limit, workers), marks=[] if (how, limit, workers) in _FAST else pytest.mark.slow)
        for how, cause in _DEATHS.items()
        for limit in (1, 3, 10)
        for workers in (1, 2)
    ],
)
def test_a_point_that_workers_die_of_fails_alone(how: str, cause: str, limit: int, workers: int) -> None:
    axes = {"do": ["a", "b", "c", "d", how, "e", "f", "g"]}
    entries = run(ProcessExecutor(workers), axes, limit=limit)
    found = [entries[point.key] for point in Space(axes, "").points()]
    assert [entry.state for entry in found] == [
        EntryState.FAILED if value == how else EntryState.DONE for value in axes["do"]
    ]
    assert found[4].text.startswith(f"a worker process died {cause} twice while it computed this point\n")
    assert "hint: use fewer workers if memory ran out" in found[4].text


def test_the_death_of_a_worker_costs_a_retry_alone(tmp_path: Path) -> None:
    log = tmp_path / "log"
    axes = {"slices": list(range(10, 22))}
    entries = run(ProcessExecutor(2), axes, log, limit=2, at={7: "kill once"})
    assert {entry.state for entry in entries.values()} == {EntryState.DONE}
    times = Counter(computed(log))
    assert times.keys() == set(range(12))
    assert times[7] == 2
    assert sum(times.values()) <= 12 + 2 * 4, "no more than what was under way is computed again"


@pytest.mark.slow
def test_every_point_of_a_study_may_kill_its_worker() -> None:
    axes = {"do": ["kill", "die"], "slices": [1, 2]}
    entries = run(ProcessExecutor(2), axes)
    assert [entry.state for entry in entries.values()] == [EntryState.FAILED] * 4


UNGUARDED = """
from explore_fakes import Fake
from codesign.study.evaluation import PointByPoint
from codesign.study.executor import ProcessExecutor
from codesign.study.partition import Alone
from codesign.study.space import Space

space = Space({"slices": [1, 2, 3]}, "")
list(ProcessExecutor(2).run([Alone((point,)) for point in space.points()], PointByPoint(Fake(), space)))
"""


def test_a_script_that_explores_as_it_is_imported_ends_with_the_remedy(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(UNGUARDED)
    done = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, env=ENVIRONMENT, timeout=120, check=False
    )
    assert done.returncode == 1
    last = done.stderr[done.stderr.rindex("codesign.ground.errors.RunError") :]
    assert "a worker process died with exit code 1 as it started" in last
    assert "explore below `if __name__ == '__main__':`" in last


def test_all_workers_compute_from_the_first_work_on(tmp_path: Path) -> None:
    log = tmp_path / "log"
    # The first work waits for company.
    run(ProcessExecutor(2), {"slices": [*range(20)]}, log, limit=2, at={0: "meet"})
    begun = [line.split() for line in log.read_text().splitlines()]
    (first,) = (pid for point, pid in begun if point == "0")
    # Its worker began nothing else before the other worker began.
    assert len({pid for _, pid in begun}) == 2
    others = [number for number, (_, pid) in enumerate(begun) if pid != first]
    assert others[0] < [number for number, (_, pid) in enumerate(begun) if pid == first][1]


SCRIPT = """
import sys
from pathlib import Path
from explore_fakes import Fake
from codesign.study.evaluation import PointByPoint
from codesign.study.executor import ProcessExecutor
from codesign.study.partition import Alone
from codesign.study.space import Space

if __name__ == "__main__":
    space = Space({"do": ["nothing"] + [f"sleep"] * 6}, "")
    works = [Alone((point,)) for point in space.points()]
    try:
        for done in ProcessExecutor(2).run(works, PointByPoint(Fake(Path(sys.argv[1])), space)):
            print("in", flush=True)
    except KeyboardInterrupt:
        print("interrupted", flush=True)
        sys.exit(130)
"""


def start(tmp_path: Path) -> tuple[subprocess.Popen[str], list[int]]:
    """A process that explores with two workers, in a group as a terminal makes one; and the workers."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    log = tmp_path / "log"
    process = subprocess.Popen(
        [sys.executable, str(script), str(log)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env=ENVIRONMENT,
    )
    until = time.monotonic() + 600
    while len(computed(log)) < 3 and time.monotonic() < until:
        time.sleep(0.05)
    assert len(computed(log)) == 3, "each worker has one work in hand"
    assert process.stdout is not None
    assert process.stdout.readline() == "in\n", "what took no time has come in"
    return process, sorted({int(line.split()[1]) for line in log.read_text().splitlines()})


@pytest.mark.skipif(sys.platform == "win32", reason="signals of a terminal")
def test_ctrl_c_ends_the_workers_without_a_word_of_theirs(tmp_path: Path) -> None:
    process, workers = start(tmp_path)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert (process.returncode, out, err) == (130, "interrupted\n", "")
    assert workers
    assert all(map(gone, workers))


STRUCK = """
import multiprocessing, signal, sys
from concurrent.futures import ProcessPoolExecutor
from explore_fakes import Fake
from codesign.study.evaluation import PointByPoint
from codesign.study.executor import ProcessExecutor
from codesign.study.partition import Alone
from codesign.study.space import Space
from processes import gone

class Pool(ProcessPoolExecutor):
    submissions = 0

    def submit(self, *arguments):
        Pool.submissions += 1
        future = super().submit(*arguments)
        if Pool.submissions == int(sys.argv[1]):
            # As where a thread of some library takes the signal, whatever this one has masked.
            signal.getsignal(signal.SIGINT)(signal.SIGINT, None)
        return future

if __name__ == "__main__":
    from codesign.study import executor
    executor.ProcessPoolExecutor = Pool
    space = Space({"slices": list(range(10, 30))}, "")
    works = [Alone((point,)) for point in space.points()]
    try:
        for done in ProcessExecutor(2).run(works, PointByPoint(Fake(), space)):
            pass
    except KeyboardInterrupt:
        print("left", [child.pid for child in multiprocessing.active_children() if not gone(child.pid)], flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of a terminal")
@pytest.mark.parametrize("submission", [1, 2, 4, 5])
def test_ctrl_c_while_work_is_handed_over_leaves_no_worker_and_nothing_to_wait_for(
    tmp_path: Path, submission: int
) -> None:
    """At 1 and 2 a worker has just been started; the end of the process waits for all of them."""
    script = tmp_path / "script.py"
    script.write_text(STRUCK)
    process = subprocess.run(
        [sys.executable, str(script), str(submission)],
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
        timeout=60,
        check=False,
    )
    assert (process.returncode, process.stdout, process.stderr) == (0, "left []\n", "")


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_workers_end_with_a_parent_that_is_killed(tmp_path: Path) -> None:
    process, workers = start(tmp_path)
    process.kill()
    process.communicate(timeout=30)
    until = time.monotonic() + 600
    while not all(map(gone, workers)) and time.monotonic() < until:
        time.sleep(0.05)
    assert workers
    assert all(map(gone, workers))


@pytest.mark.skipif(os.name != "posix", reason="a signal of POSIX")
def test_how_a_worker_ended_is_told_right_each_time() -> None:
    """The pool's thread asks for the exit code at the same time."""
    told = []
    for _ in range(40):
        slot = executor._Slot(0, PointByPoint(Fake(), Space({"a": [1]}, "")))
        with pytest.raises(BrokenProcessPool):
            slot.pool.submit(signal.raise_signal, signal.SIGKILL).result()
        told.append(executor._cause(slot))
    assert told == [" by SIGKILL"] * 40
