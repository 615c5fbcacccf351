"""The memory of a run is estimated before it begins: near what it then takes, and refused above the bound."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result
from hypothesis import given
from hypothesis import strategies as st
from small_maps import Specs

import codesign
from codesign.ground.errors import SpecError
from codesign.maps import OccupancyGrid
from codesign.planners.interface import Planner
from codesign.planners.job import Job
from codesign.study import explore
from codesign.system import catalog
from codesign.system import memory as machine
from codesign.system.memory import estimate, free_bound, share_of_memory
from codesign.system.scenarios import bind, simulate

LEAST, MOST = 0.7, 2.0

MEASURE = """
import json, resource, sys
import codesign
from codesign.system.scenarios import bind
from codesign.system.memory import estimate
platform, workload = codesign.load_platform(sys.argv[1]), codesign.load_workload(sys.argv[2])
trace = sys.argv[3] if len(sys.argv) > 3 else None
expected = estimate(bind(platform, workload), listening=trace is not None).total
codesign.simulate(platform, workload, trace=trace, memory=2**60)
try:
    # The peak of this program: that of getrusage holds the process that started it too.
    with open("/proc/self/status") as status:
        peak = next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM:"))
except OSError:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
print(json.dumps([expected, peak]))
"""

ROOMS = "{generate: rooms, rows: %d, columns: %d, room: [24, 24], door: 3, wall: 2, seed: 1}"
EMPTY = "{generate: empty, rows: %d, columns: %d}"
MAZE = "{generate: maze, rows: %d, columns: %d, corridor: 1, wall: 1, seed: 1}"
RELAX = "relax: {component: pc, block: [%d, %d], iterations: 64, schedule: %s, stop: schedule_end}"


def harmonic(side: int, block: int, schedule: str) -> tuple[str, str, int, str]:
    return "harmonic", MAZE, side, RELAX % (block, block, schedule)


# What takes the memory in each, at sizes that a run of seconds has. Mazes of one cell settle at 1023 bits in time.
FAST = {"harmonic as one block": harmonic(255, 255, "[1023]")}
SLOW = {
    "harmonic in blocks": harmonic(511, 64, "[1023]"),
    "harmonic in stages": harmonic(511, 511, "{first: 15, step: 16, last: 255}"),
    "harmonic in one word": harmonic(2047, 2047, "[15]"),
    "sweeps": ("relaxation", ROOMS, 2048, "relax: {component: pc, method: sor, max_iterations: 20}"),
    "direct": ("relaxation", EMPTY, 512, "relax: {component: pc, method: direct}"),
    "direct in rooms": ("relaxation", ROOMS, 700, "relax: {component: pc, method: direct}"),
    "wavefront": ("wavefront", ROOMS, 2048, "propagate: {component: pc}"),
    "breadth first": ("breadth_first", ROOMS, 2048, "search: {component: pc}"),
}


def workload_file(folder: Path, planner: str, map_: str, side: int, mapping: str) -> Path:
    path = folder / "workload.yaml"
    goal = (side - 1) // 2 // 2 * 2 if map_ == MAZE else 3
    starts = "[[4, 4]]" if planner == "breadth_first" else "{count: 4, seed: 1}"
    problem = f"{{map: {map_ % (side, side)}, goals: [[{goal}, {goal}]], starts: {starts}}}"
    path.write_text(f"kind: workload\nname: big\nplanner: {planner}\nproblem: {problem}\nmapping:\n  {mapping}\n")
    return path


def check_peak(*arguments: object) -> None:
    expected, peak = measured(*arguments)
    if expected / peak <= LEAST:
        # The first process of a fresh checkout compiles kernels, which takes more memory than the run.
        expected, peak = measured(*arguments)
    assert LEAST < expected / peak < MOST, f"{expected / 2**20:.0f} MiB expected, {peak / 2**20:.0f} taken"


def measured(*arguments: object) -> tuple[int, int]:
    """Bytes that a run in a process of its own was estimated to take, and that it took."""
    done = subprocess.run(
        [sys.executable, "-c", MEASURE, *map(str, arguments)], capture_output=True, text=True, check=False, timeout=170
    )
    assert done.returncode == 0, done.stderr
    expected, peak = json.loads(done.stdout)
    return expected, peak


needs_rusage = pytest.mark.skipif(sys.platform == "win32", reason="peaks are measured by getrusage")


@needs_rusage
@pytest.mark.parametrize("case", [*FAST, *(pytest.param(case, marks=pytest.mark.slow) for case in SLOW)])
def test_the_estimate_is_near_the_measured_peak(case: str, tmp_path: Path) -> None:
    check_peak("pc-epyc", workload_file(tmp_path, *(FAST | SLOW)[case]))


@needs_rusage
@pytest.mark.slow
@pytest.mark.parametrize("case", ["harmonic in one word", "sweeps"])
def test_the_estimate_of_a_traced_run_is_near_the_measured_peak(case: str, tmp_path: Path) -> None:
    check_peak("pc-epyc", workload_file(tmp_path, *SLOW[case]), tmp_path / "o.mcap")


@needs_rusage
@pytest.mark.slow
@pytest.mark.parametrize(
    ("platform", "workload"),
    [("nexys2-serial", "robots-64"), ("pc-epyc", "office-relaxation"), ("virtex4-pci", "labyrinth")],
)
def test_the_estimate_of_what_is_shipped_is_near_the_measured_peak(platform: str, workload: str) -> None:
    check_peak(platform, workload)


def test_every_planner_of_ours_says_what_it_takes() -> None:
    assert [name for name, planner in catalog.planners().items() if type(planner).memory is Planner.memory] == []


@given(side=st.integers(8, 96), bits=st.integers(1, 1000), more=st.integers(1, 23), block=st.sampled_from([8, 64]))
def test_more_cells_and_more_bits_take_no_less(side: int, bits: int, more: int, block: int) -> None:
    import numpy as np

    from codesign.planners.harmonic.plan.parameters import RelaxParameters
    from codesign.planners.interface import Problem

    planner = catalog.planner("harmonic")

    def taken(side: int, bits: int) -> int:
        problem = Problem(np.ones((side, side), np.bool_), ((0, 0),), ())
        parameters = RelaxParameters(block=(min(block, side),) * 2, iterations=4, schedule=(bits,))
        return planner.memory(Job(problem, parameters, mapped=frozenset({"relax"})))

    assert taken(side, bits) <= taken(side, bits + more)
    assert taken(side, bits) <= taken(side + more, bits)


@pytest.fixture
def big(tmp_path: Path) -> Path:
    return workload_file(tmp_path, "harmonic", ROOMS, 512, RELAX % (512, 512, "[1023]"))


def test_a_run_above_the_bound_is_refused_with_estimate_bound_and_levers(big: Path) -> None:
    platform, workload = codesign.load_platform("pc-epyc"), codesign.load_workload(big)
    expected = estimate(bind(platform, workload)).total
    with pytest.raises(SpecError) as caught:
        codesign.simulate(platform, workload, memory=expected - 1)
    (refused,) = caught.value.faults
    assert refused.key == "mapping.relax"
    assert f"about {machine.in_words(expected)}" in refused.what
    assert f"more than {machine.in_words(expected - 1)}, the bound given" in refused.what
    hint = str(refused.hint)
    for lever in ("smaller or coarser map", "fewer bits", "smaller blocks", "--memory"):
        assert lever in hint
    system = bind(platform, workload)
    held = [estimate(system, listening=listening, keeping=keeping) for listening in (0, 1) for keeping in (0, 1)]
    nothing, kept, traced, both = (each.listeners for each in held)
    assert (nothing, both) == (0, traced + kept)
    assert min(traced, kept) > 512 * 512
    assert [each.total - each.listeners for each in held] == [expected] * 4


def test_by_default_the_bound_is_half_of_what_is_free(big: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    platform, workload = codesign.load_platform("pc-epyc"), codesign.load_workload(big)
    monkeypatch.setattr(machine, "_free_of_machine", lambda: 700 * 2**20)
    monkeypatch.setattr(machine, "_free_of_group", lambda: None)
    assert free_bound() == 350 * 2**20
    with pytest.raises(SpecError, match="350 MiB, half of what this machine has free"):
        codesign.simulate(platform, workload)
    monkeypatch.setattr(machine, "_free_of_group", lambda: 600 * 2**20)
    assert free_bound() == 300 * 2**20
    monkeypatch.setattr(machine, "_free_of_machine", lambda: None)
    monkeypatch.setattr(machine, "_free_of_group", lambda: None)
    assert free_bound() > 2**30


def test_what_the_machine_says_is_free(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "meminfo"
    monkeypatch.setattr(machine, "Path", lambda _: file)
    monkeypatch.setattr(os, "sysconf", {"SC_AVPHYS_PAGES": 3, "SC_PAGE_SIZE": 4096}.__getitem__)
    assert machine._free_of_machine() == 3 * 4096
    file.write_text("MemTotal:  9 kB\nMemFree:  1 kB\nMemAvailable:  7 kB\n")
    assert machine._free_of_machine() == 7 * 1024


def test_what_the_control_groups_leave_is_free(tmp_path: Path) -> None:
    own = tmp_path / "cgroup"
    inner = tmp_path / "root" / "docker" / "abc"
    inner.mkdir(parents=True)
    own.write_text("0::/docker/abc\n")
    assert machine._free_of_group(tmp_path / "root", own) is None
    (inner / "memory.max").write_text("max\n")
    (inner / "memory.current").write_text("1000\n")
    assert machine._free_of_group(tmp_path / "root", own) is None
    (inner.parent / "memory.max").write_text("5000\n")
    (inner.parent / "memory.current").write_text("2000\n")
    assert machine._free_of_group(tmp_path / "root", own) == 3000
    old = tmp_path / "root" / "memory" / "x"
    old.mkdir(parents=True)
    own.write_text("3:cpu:/x\n2:memory,hugetlb:/x\n")
    (old / "memory.limit_in_bytes").write_text("900\n")
    (old / "memory.usage_in_bytes").write_text("1000\n")
    assert machine._free_of_group(tmp_path / "root", own) == 0


def test_the_command_line_refuses_before_the_run(big: Path, hwsw: Callable[..., Result]) -> None:
    for command in (["run"], ["check"], ["compare"]):
        files = ["pc-epyc", str(big)] if command != ["compare"] else [f"pc-epyc:{big}", "--on", str(big)]
        done = hwsw(*command, *files, "--memory", "250MiB")
        assert done.exit_code == (1 if command == ["compare"] else 2)
        assert "the run would need about" in done.output
        assert "more than 250 MiB" in done.output
    assert hwsw("check", "pc-epyc", big, "--memory", "4 GiB").exit_code == 0
    done = hwsw("run", "pc-epyc", big, "--memory", "4")
    assert done.exit_code == 2
    assert "--memory" in done.output


def test_an_exploration_of_what_fits_no_worker_is_refused_and_a_single_point_fails(
    specs: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert share_of_memory(4, 2**33) == 2**31
    assert share_of_memory(64, 2**30) == machine.PROGRAM_BYTES + 64 * 2**20
    text = specs[1].read_text(encoding="utf-8").partition("  axes:")[0]
    text = text.replace("component: fpga", "component: host")
    axes = "  axes:\n    workload.problem:\n"
    for side in (600, 24):
        one = f"{{generate: empty, rows: {side}, columns: {side}}}"
        axes += f"    - {{map: {one}, goals: [[2, 2]], starts: [[5, 5]]}}\n"
    text = text.replace("{first: 7, step: 8, last: 63}", "[511]")
    specs[1].write_text(text + axes, encoding="utf-8")
    platform, workload = codesign.load_platform(specs[0]), codesign.load_workload(specs[1])
    study = explore(platform, workload, workers=1, memory=2**28)
    assert [point.state for point in study.points] == ["failed", "done"]
    assert "the run would need about" in str(study.points[0].failure)
    specs[1].write_text((text + axes).rpartition("    - ")[0], encoding="utf-8")
    with pytest.raises(SpecError, match="the run would need about"):
        explore(platform, codesign.load_workload(specs[1]), workers=1, memory=2**28)


def test_a_run_that_no_memory_holds_is_refused_with_its_size(specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8").partition("explore:")[0]
    text = text.replace("generate: rooms, rows: 24, columns: 36, room: [11, 17], door: 2, seed: 3", "file: m.txt")
    text = text.replace("{first: 7, step: 8, last: 63}", "[1023]").replace("{count: 12, seed: 1}", "[[3, 3]]")
    text = text.replace("component: fpga", "component: host").replace("[12, 18]", "[64, 64]")
    specs[1].write_text(text, encoding="utf-8")
    (specs[1].parent / "m.txt").write_text("...\n...\n...\n", encoding="utf-8")
    big = OccupancyGrid(np.ones((4096, 4096), np.bool_))
    with pytest.raises(SpecError, match=r"the run would need about \d+\.\d GiB of memory .*, more than 4\.0 GiB"):
        simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), grid=big, memory=4 * 2**30)
