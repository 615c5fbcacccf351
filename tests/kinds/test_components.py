"""Every registered kind of component: its law is simulated, priced, bounded and told in terms, and every key counts.

A kind that is added needs a place in ``SITES``, where a small workload uses it; all else follows from its model.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import kinds
import pytest
import yaml
from small_search import SMALL

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.figures import FIGURES
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs import Platform
from codesign.inputs.components import COMPONENTS, MemoryComponent
from codesign.laws import as_sum, symbol
from codesign.laws.acts import IdealLaw
from codesign.study import explore
from codesign.study.check import check_points
from codesign.system.assemble import memory_law


def interval(value: Any, low: Any, high: Any) -> dict[str, Any]:
    return {"value": value, "status": "assumed", "source": "a sample", "low": low, "high": high}


POWER = {"busy": interval("2 W", "1 W", "4 W"), "idle": interval("500 mW", "200 mW", "1 W")}
BOARD: dict[str, Any] = {
    "fpga": {"type": "fpga", "part": "XC2VP30-6", "clock": interval("50 MHz", "40 MHz", "90 MHz")},
    "host": {
        "type": "processor",
        "clock": "1 GHz",
        "costs": {"harmonic_node_update": interval("40 ns", "30 ns", "80 ns"), "harmonic_decision": "40 ns"},
        "cores": 1,
        "load": interval(0.2, 0.1, 0.5),
        "jitter": {"median": interval(1.05, 1.01, 1.1), "p99": interval(1.3, 1.2, 1.7)},
        "memory": "100 MiB",
        "power": POWER,
    },
    "dimm": {
        "type": "memory",
        "technology": "dram",
        "beside": "fpga",
        "capacity": "1 MiB",
        "width": 32,
        "clock": interval("100 MHz", "90 MHz", "133 MHz"),
        "latency_cycles": interval(12, 8, 20),
        "row_words": 64,
        "row_cycles": interval(4, 3, 5),
        "refresh_share": 0.01,
        "power": POWER,
    },
    "screen": {
        "type": "display",
        "beside": "dimm",
        "pixel_clock": "25 MHz",
        "columns": 40,
        "rows": 30,
        "total_columns": 80,
        "total_rows": 35,
        "pixels_a_word": 2,
    },
}
SEARCH = """
kind: workload
name: small-search
planner: breadth_first
problem:
  map: {generate: random, rows: 20, columns: 24, density: 0.2, seed: 1}
  goals: [[18, 22]]
  starts: [[1, 1]]
mapping:
  search: {component: fpga, style: state_machine, memory: external, external_memory: dimm, display: none}
"""
PLAN = SMALL.partition("variants:")[0]
ON_HOST = PLAN.replace("relax: {component: fpga, ", "relax: {component: host, style: software, ").replace(
    "decide: {component: fpga}", "decide: {component: host}"
)
SITES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "fpga": ("fpga", PLAN, ()),
    "processor": ("host", ON_HOST, ()),
    "memory": ("dimm", SEARCH, ("dimm",)),
    "display": ("screen", SEARCH, ("dimm", "screen")),
}
"""By kind: its name on the board, the workload that uses it, and what the board has besides FPGA and host."""

ELSEWHERE = {"robot": "tests/system/scenarios/drive"}
"""Kinds that only a mission uses, which has no terms, and the tests that hold them."""

OTHERS: dict[str, list[Any]] = {
    "part": ["XC2V6000-4"],
    "technology": ["sram"],
    "beside": ["fpga", "host"],
    "refresh_share": [0.2],
    "memory": ["1 kB"],
    "cores": [],
    "load": [0.4],
    "jitter": [{"median": 1.1, "p99": 1.6}],
    "costs": [{"harmonic_node_update": "90 ns", "harmonic_decision": "40 ns"}],
    "power": [{"busy": "9 W", "idle": "3 W"}],
    "capacity": ["64 B"],
    "host": [],
    "calibration": ["no-such-file"],
}
"""Other values of keys that are no plain numbers. Other tests hold cores, and a host, which fills what is missing."""

NUMBERS: list[Any] = ["20 MHz", "10 MHz", 5, 16, 50, 200]
"""Other values of all other keys; a key takes some of them."""


def site(kind: str) -> tuple[str, dict[str, Any], str]:
    """The name of a component of a kind, the board that it stands on, and a workload."""
    name, work, more = SITES[kind]
    return name, {each: BOARD[each] for each in ("fpga", "host", *more)}, work


def board(declared: dict[str, Any], **changes: dict[str, Any]) -> Platform:
    whole = {name: spec | changes.get(name, {}) for name, spec in declared.items()}
    links = {"line": kinds.link("bus") | {"width": 32, "clock": "20 MHz", "setup_cycles": 8}}
    return codesign.load_platform({"kind": "platform", "name": "board", "components": whole, "links": links})


def simulated(declared: dict[str, Any], work: str, **changes: dict[str, Any]) -> Any:
    return codesign.simulate(board(declared, **changes), codesign.load_workload(yaml.safe_load(work)))


def priced_keys(kind: str) -> dict[str, dict[str, Any]]:
    """By axis, the figures with an interval that terms may rest on."""
    name, declared, _ = site(kind)
    found = {key: each for key, each in declared[name].items() if isinstance(each, dict) and "low" in each}
    costs = declared[name].get("costs", {})
    jitter = {f"jitter.{key}": each for key, each in declared[name].get("jitter", {}).items()}
    return found | {f"costs.{key}": each for key, each in costs.items() if isinstance(each, dict)} | jitter


def with_figure(spec: dict[str, Any], key: str, value: Any) -> dict[str, Any]:
    """What changes in a spec where a figure is another."""
    outer, _, inner = key.partition(".")
    return {outer: spec[outer] | {inner: value}} if inner else {outer: value}


pytestmark = pytest.mark.parametrize("kind", COMPONENTS)


@pytest.fixture(autouse=True)
def _has_a_site(kind: str) -> None:
    if kind in ELSEWHERE:
        pytest.skip(f"held by {ELSEWHERE[kind]}")


def test_what_is_simulated_is_what_is_priced(kind: str) -> None:
    name, declared, work = site(kind)
    axes = {
        f"{name}.{key}": [figure[end] for end in ("value", "low", "high")]
        for key, figure in priced_keys(kind).items()
        if "." not in key
    }
    if kind == "processor":
        jitters = [{"median": 1.0, "p99": 1.2}, {"median": 1.3, "p99": 3}]
        axes |= {f"{name}.power.busy": ["1 W", "3 W"], f"{name}.jitter": jitters, "line.clock": ["10 MHz", "33 MHz"]}
    if not axes:
        pytest.skip("it has no figure")
    workload = codesign.load_workload(yaml.safe_load(work) | {"explore": {"axes": axes}})
    study = explore(board(declared), workload, workers=1)
    assert any(point.feasible for point in study.points)
    assert check_points(study, 8).differences == ()


def test_the_interval_of_the_terms_holds_every_end_or_open_says_why(kind: str) -> None:
    name, declared, work = site(kind)
    whole = simulated(declared, work)
    assert whole.terms.interval("plan_time_mean_s") or whole.terms.open["plan_time_mean_s"]
    for key, figure in priced_keys(kind).items():
        for figure_name, of in (("plan_time_mean_s", "task"), ("energy_j", "energy")):
            ends = whole.terms.interval(figure_name)
            for end in ("low", "high") if ends else ():
                one = simulated(declared, work, **{name: with_figure(declared[name], key, figure[end])})
                if one.feasible:
                    value = getattr(getattr(one, of), figure_name)
                    assert ends[0] * (1 - 1e-9) <= value <= ends[1] * (1 + 1e-9), (key, end, figure_name)


def test_the_interval_is_of_the_figures_that_move_the_value(kind: str) -> None:
    """A figure that is pinned never widens it; a price of the law narrows it, and all figures together do."""
    name, declared, work = site(kind)
    low, high = simulated(declared, work).terms.interval("plan_time_mean_s") or (0.0, math.inf)
    law = board(declared).components[name].law
    if high == math.inf or not priced_keys(kind):
        pytest.skip("no terms")
    pinned: dict[str, Any] = {}
    for key, figure in priced_keys(kind).items():
        change = with_figure(declared[name] | pinned, key, figure["value"])
        ends = simulated(declared, work, **{name: change}).terms.interval("plan_time_mean_s")
        assert low <= ends[0]
        assert ends[1] <= high
        if key in law.prices(board(declared).components[name]) or key.startswith("costs."):
            assert ends != (low, high), key
        pinned |= change
    assert simulated(declared, work, **{name: pinned}).terms.interval("plan_time_mean_s") != (low, high)


def told(result: Any) -> Any:
    """What a result says that a component may move."""
    cycles = result.figure(FIGURES["cycles"])
    return result.task, result.energy, result.displays, result.feasible, cycles


def test_every_key_moves_what_is_computed_or_is_refused(kind: str) -> None:
    name, declared, work = site(kind)
    before = simulated(declared, work)
    for key in COMPONENTS[kind].model_fields.keys() - {"type"}:
        moved = []
        for value in OTHERS.get(key, NUMBERS):
            try:
                after = simulated(declared, work, **{name: {key: value}})
            except SpecError:
                moved += [True] if key in OTHERS else []
                continue
            moved.append(told(after) != told(before))
        assert any(moved) or not OTHERS.get(key, NUMBERS), f"{key} moves nothing"


def test_symbols_and_numbers_are_of_one_law(kind: str) -> None:
    name, declared, _ = site(kind)
    spec = board(declared).components[name]
    unit = next(iter(spec.kernels or {}), "")
    keys = (f"costs.{unit}", "pace") if unit else spec.law.prices(spec)
    values = {key: int(spec.figure(key).value) for key in keys}
    law, told = spec.law_of(unit, values.__getitem__), spec.law_of(unit, symbol)
    time = as_sum(told.ticks(1000) / told.rate()).at(values)
    assert math.isclose(time, law.ticks(1000) / law.rate(), rel_tol=1e-12)
    for key, sign in spec.directions().items():
        faster = spec.law_of(unit, (values | {key: 2 * values[key]}).__getitem__)
        assert sign * (law.ticks(1000) / law.rate() - faster.ticks(1000) / faster.rate()) > 0


def test_every_view_shows_it(kind: str, tmp_path: Path, hwsw: Any) -> None:
    name, declared, work = site(kind)
    trace = tmp_path / "run.mcap"
    codesign.simulate(board(declared), codesign.load_workload(yaml.safe_load(work)), trace=trace)
    assert name in hwsw("trace", "show", trace).stdout
    # What does no act of its own, such as a memory that a design drives, has no span.
    works = not issubclass(COMPONENTS[kind].law, IdealLaw)
    for option in ("--html", "--perfetto") if works else ("--html",):
        done = hwsw("trace", "export", trace, option, tmp_path / f"run{option}")
        assert done.exit_code == 0, done.output
        assert name.encode() in (tmp_path / f"run{option}").read_bytes()


@pytest.mark.parametrize("words", [1, 63, 64, 65, 1000])
def test_the_cycles_of_accesses_stay_within_the_bounds_of_their_ratio(kind: str, words: int) -> None:
    """What terms say of all cycles of a memory, by latency and rows, holds for those of any accesses."""
    if COMPONENTS[kind] is not MemoryComponent:
        pytest.skip("it is accessed by nothing")
    name, declared, work = site(kind)
    spec = declared[name]
    [ratio] = [figure for key, figure in simulated(declared, work).terms.inputs.items() if "access_cycles" in key]
    law = memory_law(name, board(declared).components[name])
    for latency in ("low", "high"):
        for row in ("low", "high"):
            changes = {"latency_cycles": spec["latency_cycles"][latency], "row_cycles": spec["row_cycles"][row]}
            other = memory_law(name, board(declared, **{name: changes}).components[name])
            for cycles in (lambda each: each.run_cycles(words), lambda each: words * each.access_cycles):
                assert ratio.low <= cycles(other) / cycles(law) <= ratio.high


def test_a_second_has_its_picoseconds(kind: str) -> None:
    """A kernel's cost is told in seconds and charged in picoseconds."""
    if kind != "processor":
        pytest.skip("it has no kernels")
    name, declared, work = site(kind)
    result = simulated(declared, work)
    cost = result.terms.inputs[f"{name}.costs.harmonic_node_update"]
    assert cost.value * PICOSECONDS_PER_SECOND == pytest.approx(40_000)
