"""What tests share: small specs on disk, and the command line in this process."""

from __future__ import annotations

import gc
import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from examples import THOROUGH, examples
from hypothesis import HealthCheck, settings

# While modules load and tests are collected nothing is garbage.
gc.disable()

# One date for all that a session writes: midnight decides no test either.
os.environ.setdefault("SOURCE_DATE_EPOCH", str(int(time.time())))

# Time decides no test: what an example takes depends on the machine and on what else it does. Nor does luck: the same
# examples are drawn at each run, but for `make test-all`, which looks for new ones. Examples may share a folder.
settings.register_profile(
    "codesign",
    deadline=None,
    derandomize=not THOROUGH,
    max_examples=examples(100),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("codesign")

PLATFORM = """\
kind: platform
name: small-board
components:
  fpga: {type: fpga, part: XC2V6000-4, clock: 100 MHz}
  host: {type: processor, clock: 1 GHz, costs: {harmonic_node_update: 40 ns}, power: {busy: 20 W, idle: 5 W}}
links:
  pci: {type: bus, between: [host, fpga], width: 32, clock: 33 MHz, setup_cycles: 8, burst_words: 16}
"""

WORKLOAD = """\
kind: workload
name: two-rooms
planner: harmonic
problem:
  map: {generate: rooms, rows: 24, columns: 36, room: [11, 17], door: 2, seed: 3}
  goals: [[2, 2]]
  starts: {count: 12, seed: 1}
mapping:
  relax: {component: fpga, block: [12, 18], iterations: 4, schedule: {first: 7, step: 8, last: 63}}
  decide: {component: fpga}
explore:
  axes:
    relax.block: [[12, 18], [24, 36], [6, 9]]
    relax.iterations: [1, 4]
    relax.schedule: [{first: 7, step: 8, last: 63}, [15, 255]]
    relax.termination: [sound, published]
    fpga.part: [XC2V6000-4, XC3S500E-4]
    fpga.clock: [50 MHz, 100 MHz]
"""


MOST_KERNELS = (
    *(f"tests/inputs/test_{name}.py" for name in ("boards", "conditions", "searching", "sources")),
    "tests/test_layers.py::test_each_planner_plans_without_yaml",
)
NO_KERNELS = ("tests/inputs/", "tests/testing/", "tests/test_layers.py", "tests/hardware/rtl/test_synthesis.py")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Two workers begin at the two halves of the tests, and both would compile the same kernels at the same time.

    So the first one begins with tests that need most kernels, and the second one with tests that need none.
    """
    if "PYTEST_XDIST_WORKER" in os.environ:
        first = [item for item in items if item.nodeid.startswith(MOST_KERNELS)]
        light = [item for item in items if item.nodeid.startswith(NO_KERNELS) and item not in first]
        taken = {*first, *light}
        others = [item for item in items if item not in taken]
        half = max(len(items) // 2 - len(first), 0)
        items[:] = first + others[:half] + light + others[half:]


def pytest_collection_finish() -> None:
    """Thousands of tests and the modules that they import live to the end: the collector need not walk them again.

    A collection for each 700 new objects takes a twelfth of the time of the tests, one for each 50,000 hardly any.
    """
    gc.collect()
    gc.freeze()
    gc.enable()
    gc.set_threshold(50_000, 20, 20)


@pytest.fixture
def specs(tmp_path: Path) -> tuple[Path, Path]:
    """A platform file and a workload file that fit each other."""
    platform, workload = tmp_path / "board.yaml", tmp_path / "rooms.yaml"
    platform.write_text(PLATFORM, encoding="utf-8")
    workload.write_text(WORKLOAD, encoding="utf-8")
    return platform, workload


@pytest.fixture
def hwsw(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    """Run ``hwsw`` in an empty folder; an unexpected error fails the test."""
    from codesign.cli import main

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")

    def run(*arguments: object) -> Result:
        result = CliRunner().invoke(main, [str(argument) for argument in arguments])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        assert "Traceback" not in result.output
        assert "unexpected error" not in result.output
        return result

    return run
