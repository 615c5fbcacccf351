"""The terms of a plan add up to the simulated time and energy, at the figures' own values and at any others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shipped_plans import design, result_of, shipped_plans, with_values, written

import codesign
from codesign.ground.figures import FIGURES
from codesign.ground.memo import Memo
from codesign.system import point_of
from codesign.system.results.result import Result
from codesign.system.results.terms import is_edges
from codesign.system.scenarios import simulate
from codesign.system.terms import TIMES

PICOSECOND = 1e-12
EXTERNAL = design("virtex2pro-dimm", "breadth-first-external")


def values_of(result: Result) -> dict[str, float]:
    assert result.terms is not None
    return {name: figure.value for name, figure in result.terms.inputs.items()}


def priced(result: Result, figure: str, values: dict[str, Any]) -> float:
    assert result.terms is not None
    (plan,) = result.terms.plans(figure)
    return float(sum(term.at(values) for term in plan))


def roundings(result: Result) -> float:
    """The bound of the difference: a picosecond for each message, and for each time that an FPGA takes up work."""
    assert result.links is not None
    return (sum(link.sent for link in result.links.values()) + 2) * PICOSECOND


def test_the_terms_of_every_shipped_plan_add_up() -> None:
    unpriced = {}
    for one in shipped_plans():
        result = result_of(one)
        assert result.time is not None
        assert result.energy is not None
        assert result.terms is not None
        unpriced |= {(one[:2], figure): reason for figure, reason in result.terms.open.items()}
        assert result.task is not None
        for figure, value in (
            ("first_plan_s", result.time.first_plan_s),
            ("plan_time_mean_s", result.task.plan_time_mean_s),
            ("plan_time_worst_s", result.task.plan_time_worst_s),
            ("energy_j", result.energy.energy_j),
        ):
            if figure in result.terms.open:
                continue
            # No platform draws 200 W.
            bound = roundings(result) * (200.0 if figure == "energy_j" else 1.0)
            assert priced(result, figure, values_of(result)) == pytest.approx(value, rel=1e-12, abs=bound), one
            interval = result.interval(FIGURES[figure])
            assert interval is not None
            assert interval[0] - bound <= value <= interval[1] + bound
        plan = result.terms.times.get("first_plan_s", ((),))[0]
        assert all(term.seconds >= 0 for term in plan)
        # Each time has terms, or a reason why it has none.
        assert result.terms.times.keys() ^ (result.terms.open.keys() - {"energy_j"}) == set(TIMES)
    on_display = [("virtex2pro-vga", "breadth-first"), ("virtex2pro-vga", "breadth-first-large")]
    both = {(pair, figure) for pair in on_display for figure in (*TIMES, "energy_j")}
    # Which start is the 95th of a hundred rests on the figures, unless all are answered alike.
    unpriced = {key for key in unpriced if key[0] in on_display or key[1] != "plan_time_95_s"}
    assert unpriced == {*both, (EXTERNAL[:2], "energy_j")}


INPUTS = {
    "fpga.clock": st.integers(20_000_000, 110_000_000),
    "pci.clock": st.integers(1_000_000, 100_000_000),
    "pci.width": st.integers(1, 128),
    "pci.setup_cycles": st.integers(0, 100),
    "pci.burst_words": st.integers(1, 80),
    "host.costs.harmonic_node_update": st.integers(1, 10**6),
}


@pytest.fixture(scope="module")
def memo() -> Memo:
    return Memo()


@settings(max_examples=40)
@given(values=st.fixed_dictionaries(INPUTS), where=st.sampled_from(["fpga", "host"]))
def test_a_plan_is_priced_anew_without_a_simulation(
    specs: tuple[Path, Path], memo: Memo, values: dict[str, int], where: str
) -> None:
    placed = {"relax.component": where, "decide.component": where}
    placed |= {"relax.style": "software"} if where == "host" else {}
    base = codesign.load_platform(specs[0]), codesign.load_workload(specs[1])
    units = {"clock": "Hz", "costs": "ps"}
    raw = {
        name: f"{value} {units[name.split('.')[1]]}" if name.split(".")[1] in units else value
        for name, value in values.items()
    }
    result = simulate(*point_of(*base, placed), memo=memo)
    moved = simulate(*point_of(*base, {**placed, **raw}), memo=memo)
    assert result.terms is not None
    assert moved.time is not None
    edges = {name: figure for name, figure in result.terms.inputs.items() if is_edges(name)}
    scales = {"host.costs.harmonic_node_update": PICOSECOND}
    known = {name: value * scales.get(name, 1.0) for name, value in values.items()}
    # How long it waits for edges is the one thing that depends on when all else ends.
    bounds = [
        priced(result, "first_plan_s", {**values_of(result), **known, **dict.fromkeys(edges, end)})
        for end in (0.0, 4.0)
    ]
    assert bounds[0] - 8 * PICOSECOND <= moved.time.first_plan_s <= bounds[1] + 8 * PICOSECOND


@pytest.mark.parametrize(
    "one", [design("zynq", "breadth-first"), design("virtex4-pci", "wavefront-tiles"), design("pc-epyc", "floor-plan")]
)
def test_simulated_times_and_energies_lie_inside_the_intervals(one: Any) -> None:
    """Random values of all figures that a platform file declares."""
    result, random = result_of(one), np.random.default_rng(1)
    assert result.terms is not None
    for _ in range(10):
        values = {
            name: written(random.uniform(*figure.interval), figure.unit)
            for name, figure in result.terms.inputs.items()
            if " " not in name and figure.interval[0] < figure.interval[1]
        }
        moved = with_values(one, values)
        for figure in (FIGURES["first_plan_s"], FIGURES["energy_j"]):
            interval, value = result.interval(figure), moved.figure(figure)
            assert interval is not None
            assert value is not None
            assert interval[0] * (1 - 1e-9) <= value <= interval[1] * (1 + 1e-9)


def test_an_external_memory_bounds_all_cycles() -> None:
    result = result_of(EXTERNAL)
    interval = result.interval(FIGURES["first_plan_s"])
    assert interval is not None
    for latency, row in ((8, 3), (20, 5), (8, 5), (20, 3)):
        moved = with_values(EXTERNAL, {"dimm.latency_cycles": latency, "dimm.row_cycles": row})
        assert moved.time is not None
        assert interval[0] < moved.time.first_plan_s < interval[1]


@pytest.mark.parametrize(
    "one",
    [
        design("virtex4-pci", "labyrinth", detect__component="host", decide__component="host"),
        design("virtex4-pci", "labyrinth", decide__component="host"),
        design("zynq", "wavefront-tiles", track__component="arm"),
        design("zynq", "breadth-first", track__component="arm"),
    ],
    ids=lambda one: "-".join(map(str, (one[0], *dict(one[2])))),
)
def test_tasks_apart_and_the_messages_between_them_are_terms(one: Any) -> None:
    result = result_of(one)
    assert result.time is not None
    assert result.energy is not None
    values, bound = values_of(result), 1e4 * PICOSECOND
    assert priced(result, "first_plan_s", values) == pytest.approx(result.time.first_plan_s, rel=1e-9, abs=bound)
    assert priced(result, "energy_j", values) == pytest.approx(result.energy.energy_j, rel=1e-6)
    assert result.terms is not None
    (plan,) = result.terms.times["first_plan_s"]
    assert {"fpga", result.places["decide" if "decide" in result.places else "track"]} <= {term.where for term in plan}


ERRORS = "errors: {bit_error_rate: 1.0e-5, retries: 20, timeout: 1 us, seed: 3}"


def with_link(specs: tuple[Path, Path], text: str) -> Result:
    board = specs[0].read_text(encoding="utf-8")
    specs[0].write_text(board.replace("burst_words: 16}", f"burst_words: 16, {text}}}"), encoding="utf-8")
    return simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))


def test_messages_that_are_sent_again_are_terms(specs: tuple[Path, Path]) -> None:
    result = with_link(specs, ERRORS.replace("1.0e-5", "1.0e-3"))
    assert result.terms is not None
    assert result.links is not None
    assert result.links["pci"].retransmissions
    assert "wait to send again" in {term.what for term in result.terms.times["first_plan_s"][0]}
    assert result.time is not None
    total = priced(result, "first_plan_s", values_of(result))
    assert total == pytest.approx(result.time.first_plan_s, rel=1e-12, abs=40 * PICOSECOND)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("outages: [{begin: 1 s, end: 2 s}]", "link pci is down at certain times"),
        ("errors: {late: {share: 0.999, delay: 1 us}}", "messages of link pci arrive late"),
    ],
)
def test_what_meets_in_time_is_no_sum(specs: tuple[Path, Path], text: str, reason: str) -> None:
    result = with_link(specs, text)
    assert result.terms is not None
    assert result.terms.open == dict.fromkeys((*TIMES, "energy_j"), reason)
    assert result.terms.plans("first_plan_s") == ()
    assert result.interval(FIGURES["first_plan_s"]) is None
