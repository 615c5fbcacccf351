"""Ctrl-C and SIGTERM end every command soon, in whatever kernel it is, with word and exit code, and no leftovers."""

from __future__ import annotations

import importlib
import os
import pkgutil
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from explore_fakes import Fake
from numba.core.dispatcher import Dispatcher
from processes import gone

import codesign
from codesign.ground.errors import StoreError
from codesign.inputs import Exploration
from codesign.study import explore, load_study
from codesign.study.store import FileStore

Run = Callable[..., Result]


pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of a terminal")

TERMINATED = (143, "terminated")
ENDS = {signal.SIGINT: (130, "interrupted"), signal.SIGTERM: TERMINATED, signal.SIGHUP: TERMINATED}
# Far above what it takes. Work that ends by itself has another exit code, so the bound decides no test that passes.
BOUND_S = 120


def test_no_kernel_keeps_the_interpreter_to_itself() -> None:
    kernels = {}
    for module in pkgutil.walk_packages(codesign.__path__, "codesign."):
        if module.name != "codesign.__main__":
            for name, found in vars(importlib.import_module(module.name)).items():
                if isinstance(found, Dispatcher):
                    kernels[f"{found.py_func.__module__}.{name}"] = found
    assert len(kernels) > 80
    assert [name for name, kernel in kernels.items() if not kernel.targetoptions.get("nogil")] == []


KERNEL = """
import multiprocessing, signal, sys, threading, time
from pathlib import Path
from numba import njit
from codesign.ground import interrupts
from codesign.ground.files import passing

@njit(nogil=True)
def work(steps):
    total = 0
    for step in range(steps):
        total += step * step % (total % 7 + 3)
    return total

if __name__ == "__main__":
    # Whatever these tests were started under: in the background SIGINT is ignored, under nohup SIGHUP.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in signal.SIGTERM, signal.SIGHUP:
        signal.signal(number, signal.SIG_DFL)
    interrupts.end_on_signals()
    interrupts.keep("what was finished is kept")
    work(1)
    worker = multiprocessing.get_context("spawn").Process(target=time.sleep, args=(1000,))
    with interrupts.held():
        worker.start()
    with passing(Path("file.part")) as file, passing(Path("folder")) as folder:
        file.write_text("half")
        folder.mkdir()
        (folder / "copy").touch()
        # A thread that would be joined at the end, as that of a pool.
        threading.Thread(target=work, args=(1 << 50,)).start()
        print(worker.pid, flush=True)
        work(1 << 50)
"""


@pytest.mark.parametrize(
    ("number", "strikes"), [(signal.SIGINT, 1), (signal.SIGINT, 2), (signal.SIGTERM, 1), (signal.SIGHUP, 1)]
)
def test_a_signal_ends_a_process_within_a_kernel(number: signal.Signals, strikes: int, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(KERNEL)
    started = [sys.executable, str(script)]
    process = subprocess.Popen(started, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        worker = int(process.stdout.readline())
        time.sleep(0.1)
        for _ in range(strikes):
            process.send_signal(number)
            time.sleep(0.05)
        _, err = process.communicate(timeout=BOUND_S)
    finally:
        process.kill()
    code, word = ENDS[number]
    assert (process.returncode, err) == (code, f"{word}; what was finished is kept\n")
    assert gone(worker)
    assert [path.name for path in tmp_path.iterdir()] == ["script.py"]


RETURNING = """
import ctypes
import numpy as np
from numba import njit
from codesign.ground import interrupts

strike = getattr(ctypes.CDLL(None), "raise")
strike.argtypes = [ctypes.c_int]

@njit(nogil=True)
def work(number):
    if number:
        strike(number)
    return np.zeros(3), np.ones(3, np.int8)

def run(number):
    arrays = work(number)
    print("the kernel returned", arrays)

interrupts.end_on_signals()
work(0)
try:
    run(%d)
except KeyboardInterrupt as interrupt:
    print(interrupts.word(type(interrupt)))
"""


def test_a_signal_during_a_kernel_is_raised_once_its_arrays_are_made() -> None:
    # Numba makes the arrays in C code that calls Python, and dereferences a null pointer where Python raises.
    number = signal.SIGTERM
    done = subprocess.run(
        [sys.executable, "-c", RETURNING % number], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{ENDS[number][1]}\n", "")


LOADING = """
import dataclasses, signal, sys
from codesign.ground import interrupts
interrupts.end_on_signals()
try:
    exec("import os, signal; os.kill(os.getpid(), signal.SIGINT)\\nfor _ in range(1000): pass")
except KeyboardInterrupt:
    sys.exit(130)
"""


def test_an_interrupt_in_code_made_from_text_leaves_the_exit_code_alone() -> None:
    # Python ends a process by SIGINT, whatever its code, once a KeyboardInterrupt itself passed there.
    done = subprocess.run([sys.executable, "-c", LOADING], capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (130, "")


ROOMS = "{generate: rooms, rows: %d, columns: %d, room: [24, 24], door: 3, wall: 2, seed: 1}"
LONG = "schedule: {first: 7, step: 8, last: 1023}, stop: schedule_end"
RELAX = f"relax: {{component: pc, block: [1024, 1024], iterations: 6, {LONG}}}"
PLANS = {
    "harmonic": ("harmonic", 1024, "{count: 4, seed: 1}", RELAX),
    "direct": ("relaxation", 700, "{count: 4, seed: 1}", "relax: {component: pc, method: direct}"),
    "gauss_seidel": ("relaxation", 1024, "{count: 4, seed: 1}", "relax: {component: pc, method: gs}"),
    "wavefront": ("wavefront", 4096, "{count: 4, seed: 1}", "propagate: {component: pc}"),
    "breadth_first": ("breadth_first", 4096, "[[4090, 4090]]", "search: {component: pc}"),
}


def workload_of(name: str, folder: Path) -> Path:
    planner, side, starts, mapping = PLANS[name]
    path = folder / f"{name}.yaml"
    problem = f"{{map: {ROOMS % (side, side)}, goals: [[3, 3]], starts: {starts}}}"
    path.write_text(f"kind: workload\nname: {name}\nplanner: {planner}\nproblem: {problem}\nmapping:\n  {mapping}\n")
    return path


def strike(
    folder: Path,
    number: signal.Signals,
    arguments: list[object],
    *,
    after: float = 0,
    line: int = 0,
    until: Callable[[], object] = lambda: True,
    group: bool = False,
) -> subprocess.CompletedProcess[str]:
    """Run the command, and strike it so many seconds after its start, or once something else has happened.

    ``line``: it has written so many lines of standard error. ``until``: this is true.
    Fails where the command, or a process that it started, outlives the bound.
    """
    command = [sys.executable, "-m", "codesign", *map(str, arguments)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen(command, cwd=folder, text=True, start_new_session=True, **pipes)  # type: ignore[call-overload]
    said = ""
    try:
        for _ in range(line):
            said += process.stderr.readline()
        while not until() and process.poll() is None:
            time.sleep(0.05)
        time.sleep(after)
        if process.poll() is None:
            (os.killpg if group else os.kill)(process.pid, number)
        out, err = process.communicate(timeout=BOUND_S)
        bound = time.monotonic() + BOUND_S
        while (left := living(process.pid)) and time.monotonic() < bound:
            time.sleep(0.05)
        assert not left
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    return subprocess.CompletedProcess(command, process.returncode, out, said + err)


def some_kept(store: Path) -> bool:
    """Whether points are in a store that another process writes."""
    try:
        with FileStore(store, read_only=True) as kept:
            return bool(kept.computations())
    except StoreError:
        return False  # it is not made yet


def living(group: int) -> list[int]:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return []
    return [group]


def check_ended(done: subprocess.CompletedProcess[str], number: signal.Signals, kept: str = "") -> None:
    code, word = ENDS[number]
    assert done.returncode == code, done.stderr
    assert done.stderr.splitlines()[-1] == word + kept
    assert "Traceback" not in done.stderr


def test_ctrl_c_ends_a_run_of_long_words_and_leaves_no_file(tmp_path: Path) -> None:
    workload = workload_of("harmonic", tmp_path)
    arguments = ["run", "pc-epyc", workload, "--trace", "o.mcap", "--html", "o.html"]
    done = strike(tmp_path, signal.SIGINT, arguments, until=lambda: any(tmp_path.glob(".*o.mcap*")))
    check_ended(done, signal.SIGINT)
    assert os.listdir(tmp_path) == [workload.name]


@pytest.mark.parametrize("group", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_sigterm_ends_an_exploration_and_keeps_its_points(
    group: bool, specs: tuple[Path, Path], tmp_path: Path
) -> None:
    text = specs[1].read_text(encoding="utf-8")
    # 1,536 simulations: many more than are done when the first are in the store.
    many = f"{[*range(1, 65)]}\n    workload.problem.map.seed: {[*range(1, 3)]}"
    specs[1].write_text(text.replace("[1, 4]", many), encoding="utf-8")
    files = ["--store", "o.sqlite", "--csv", "o.csv"]
    command = ["explore", *specs, "--workers", "2", *files]
    done = strike(tmp_path, signal.SIGTERM, command, until=lambda: some_kept(tmp_path / "o.sqlite"), group=group)
    check_ended(done, signal.SIGTERM, "; finished points are kept")
    assert not (tmp_path / "o.csv").exists()
    study = load_study(tmp_path / "o.sqlite")
    assert 0 < len(study.missing) < len(study.points) == 2 * 3072


def test_sigterm_ends_a_reproduction_and_leaves_no_page(tmp_path: Path) -> None:
    done = strike(tmp_path, signal.SIGTERM, ["reproduce", "harmonic", "--html", "o.html"], line=1)
    check_ended(done, signal.SIGTERM)
    assert os.listdir(tmp_path) == []


@pytest.fixture(scope="module")
def big_study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of a study that takes a while to read."""
    file = tmp_path_factory.mktemp("study") / "o.sqlite"
    section = Exploration(axes={"bench.slices": list(range(1, 101)), "bench.seconds": [1.0 / n for n in range(1, 101)]})
    workload = codesign.load_workload("labyrinth").model_copy(update={"explore": section})
    explore(codesign.load_platform("virtex4-pci"), workload, store=file, workers=1, evaluate=Fake())
    return file


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("trace") / "o.mcap"
    codesign.simulate(codesign.load_platform("virtex4-pci"), codesign.load_workload("labyrinth"), trace=file)
    return file


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "command", [*PLANS, "fleet", "explore", "compare", "reproduce", "calibrate", "report", "show", "check"]
)
def test_a_signal_at_any_moment_ends_any_command(
    command: str, seed: int, tmp_path: Path, big_study: Path, trace: Path
) -> None:
    chance = random.Random(f"{command} {seed}")
    number, after = chance.choice(list(ENDS)), chance.uniform(0.15, 5)
    workload = workload_of(command, tmp_path) if command in PLANS else None
    arguments: list[object] = {
        "fleet": ["run", "nexys2-serial", "robots-8-fleet", "--html", "o.html"],
        "explore": ["explore", "virtex4-pci", "labyrinth", "--workers", "2", "--store", "o.sqlite", "--html", "o.html"],
        "compare": ["compare"],
        "reproduce": ["reproduce", "--html", "o.html"],
        "calibrate": ["calibrate", "host"],
        "report": ["report", big_study, "--csv", "o.csv", "--html", "o.html"],
        "show": ["trace", "show", trace, "--limit", "100000"],
        "check": ["check", "virtex4-pci", "labyrinth"],
    }.get(command, ["run", "pc-epyc", workload, "--trace", "o.mcap", "--html", "o.html"])
    done = strike(tmp_path, number, arguments, after=after, group=chance.random() < 0.5)
    assert "Traceback" not in done.stderr
    assert [path for path in tmp_path.iterdir() if path.name.startswith(".")] == []
    if done.returncode in (0, 3):
        # It was done before, or made its last steps.
        assert command not in PLANS or after > 1
        return
    kept = "; finished points are kept" if command == "explore" and "kept" in done.stderr else ""
    check_ended(done, number, kept)
    # A file that was finished before the signal stays; none is there in part.
    for path in tmp_path.glob("o.*"):
        if path.suffix == ".csv":
            assert len(path.read_text(encoding="utf-8").splitlines()) > 10_000
        elif path.suffix == ".html":
            assert path.read_text(encoding="utf-8").rstrip().endswith("</html>")
        elif path.suffix == ".mcap":
            assert codesign.open_trace(path).complete


@pytest.mark.parametrize(("name", "kept"), [("list", False), ("explore", True)])
def test_only_an_exploration_keeps_what_was_finished(
    hwsw: Run, specs: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, name: str, kept: bool
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("codesign.system.at_hand", interrupted)
    monkeypatch.setattr("codesign.explore", interrupted)
    result = hwsw("list") if name == "list" else hwsw("explore", *specs)
    assert result.exit_code == 130
    assert ("kept" in result.stderr) is kept


def test_an_interrupt_while_loading_gives_no_traceback() -> None:
    script = """
import sys
class Interrupt:
    def find_spec(self, name, *_):
        if name == "click":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupt())
from codesign.__main__ import main
main()
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "interrupted\n")
