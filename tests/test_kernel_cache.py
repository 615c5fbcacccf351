"""Compiled kernels find a private place where there is no other."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from codesign.ground import kernel_cache


def test_kernels_find_a_private_cache_where_there_is_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.delitem(sys.modules, "numba")
    kernel_cache.provide_kernel_cache()
    assert "NUMBA_CACHE_DIR" not in os.environ
    monkeypatch.setattr(kernel_cache, "_may_write", lambda folder: False)
    seen = []
    for _ in range(2):
        kernel_cache.provide_kernel_cache()
        seen.append(Path(os.environ["NUMBA_CACHE_DIR"]))
        monkeypatch.delenv("NUMBA_CACHE_DIR")
    assert seen[0] == seen[1]
    assert seen[0].parent == tmp_path
    assert stat.S_IMODE(seen[0].stat().st_mode) == 0o700
    seen[0].chmod(0o777)
    kernel_cache.provide_kernel_cache()
    # Others could have put anything there.
    assert Path(os.environ["NUMBA_CACHE_DIR"]) != seen[0]
    monkeypatch.delenv("NUMBA_CACHE_DIR")


def test_every_folder_with_kernels_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kernels = Path(kernel_cache.__file__).parents[1] / "planners" / "harmonic" / "plan" / "__pycache__"
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(kernel_cache, "_user_cache", lambda: tmp_path / "user")
    monkeypatch.setattr(kernel_cache, "_may_write", lambda folder: folder not in (tmp_path / "user", kernels))
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.delitem(sys.modules, "numba")
    kernel_cache.provide_kernel_cache()
    assert Path(os.environ["NUMBA_CACHE_DIR"]).parent == tmp_path


def test_a_folder_can_be_written_to_only_below_a_folder(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert kernel_cache._may_write(tmp_path / "new" / "numba")
    assert not kernel_cache._may_write(tmp_path / "file" / "numba")


def test_a_compiled_kernel_is_reported_once_and_a_cached_one_never() -> None:
    from numba import njit

    reports: list[int] = []
    kernel = njit(lambda number: number + 1)
    with kernel_cache.compiling_reported(reports.append):
        assert kernel(1) == 2
        assert reports == [0, 1]
        assert kernel(2) == 3
        assert kernel(1.5) == 2.5
    assert reports == [0, 1, 2]
    assert njit(lambda number: number - 1)(1) == 0
    assert reports == [0, 1, 2]


def test_the_time_of_compiling_is_that_of_the_outermost_kernel_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from numba import njit

    inner = njit(lambda number: number * 3)
    outer = njit(lambda number: inner(number) + 1)
    clock = iter([10.0, 17.0])
    monkeypatch.setattr(kernel_cache.time, "process_time", lambda: next(clock))
    with kernel_cache.compiling_timed() as spent_s:
        assert spent_s() == 0.0
        assert outer(1) == 4
        assert spent_s() == 7.0
        assert outer(2) == 7
        assert spent_s() == 7.0
    assert njit(lambda number: number - 2)(1) == -1
    assert spent_s() == 7.0


def test_a_cache_is_cold_until_a_kernel_is_in_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "none"))
    assert kernel_cache.is_cold()
    (tmp_path / "none" / "maps_1").mkdir(parents=True)
    assert kernel_cache.is_cold()
    (tmp_path / "none" / "maps_1" / "reach.fill-12.py311.nbi").touch()
    assert not kernel_cache.is_cold()


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", ["run virtex2pro breadth-first", "verify virtex2pro breadth-first", "explain virtex2pro breadth-first"]
)
def test_the_first_run_announces_the_compilation_and_the_second_does_not(command: str, tmp_path: Path) -> None:
    """In processes of their own, with an empty cache."""
    words = [sys.executable, "-m", "codesign", *command.split()]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    first, second = (
        subprocess.run(words, env=environment, capture_output=True, text=True, check=True) for _ in range(2)
    )
    assert first.stderr.startswith("compiling kernels, once: about 20 s\n")
    assert first.stderr.count("compiling") == 1
    assert "compiling" not in second.stderr
    assert first.stdout == second.stdout


ON_NODE = """
from codesign.ground.kernel_cache import compiled_once, keep_kernels_on_node

assert keep_kernels_on_node("digest") == ""
import numba

@numba.njit(cache=True)
def total(count):
    return count * (count + 1) // 2

assert compiled_once(lambda: total(3)) == 6
print(sum(total.stats.cache_hits.values()))
"""


def test_of_the_processes_of_a_node_one_compiles(tmp_path: Path) -> None:
    """Two processes need one kernel at the same time: it is compiled once, in the folder of the node."""
    script = tmp_path / "script.py"
    script.write_text(ON_NODE)
    command = [sys.executable, str(script)]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    both = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) for _ in range(2)]
    found = [process.communicate(timeout=120)[0] for process in both]
    assert [process.returncode for process in both] == [0, 0]
    assert sorted(found) == ["0\n", "1\n"], "one compiled it, the other found it"
    (node,) = (tmp_path / "cache" / "nodes").iterdir()
    assert len(list(node.rglob("*.nbc"))) == 1
    assert not list((tmp_path / "cache").glob("*.nbi"))


def test_of_two_workers_of_this_machine_one_compiles(tmp_path: Path) -> None:
    """The same in the folder that a user has for kernels, or in the one beside the module."""
    script = tmp_path / "script.py"
    script.write_text(ON_NODE.replace('assert keep_kernels_on_node("digest") == ""', ""))
    command = [sys.executable, str(script)]
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    environment["TMPDIR"] = str(tmp_path)
    both = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) for _ in range(2)]
    found = [process.communicate(timeout=120)[0] for process in both]
    assert [process.returncode for process in both] == [0, 0]
    assert sorted(found) == ["0\n", "1\n"], "one compiled it, the other found it"


def test_a_process_that_loaded_kernels_before_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setitem(sys.modules, "codesign.planners.some", pytest)
    assert kernel_cache.keep_kernels_on_node("digest") == "it loaded kernels before: restart it"
    assert list(tmp_path.iterdir()) == []
