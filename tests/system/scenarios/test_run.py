"""One run: granularity changes nothing, listeners change nothing, the parts of the answer add up."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_maps import put_map

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.memo import Memo
from codesign.ground.records import MessageRecord, StageRecord, TaskRecord, VisitsRecord
from codesign.inputs.files import data_folder
from codesign.system import point_of
from codesign.system.results.result import DisplayUse
from codesign.system.scenarios import bind, simulate
from codesign.views.trace import MemoryListener

SECOND = 10**12

Specs = tuple[Path, Path]


def loaded(specs: Specs, **settings: Any) -> tuple[Any, Any]:
    axes = {name.replace("__", "."): value for name, value in settings.items()}
    return point_of(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), axes)


def comparable(records: list[Any]) -> list[Any]:
    return [
        (type(record), {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in vars(record).items()})
        for record in records
    ]


POINTS: list[dict[str, Any]] = [
    {},
    {"relax__block": [7, 11], "relax__iterations": 1},
    {"relax__block": [24, 36], "relax__schedule": [9, 40]},
    {"relax__termination": "published", "fpga__clock": "33 MHz"},
    {"relax__component": "host", "relax__style": "software", "decide__component": "host"},
    {"relax__component": "host", "relax__style": "software_limbs", "decide__component": "host"},
]


@pytest.mark.parametrize("settings", POINTS, ids=lambda point: "-".join(map(str, point.values())) or "base")
def test_granularity_listeners_and_memo_change_nothing(specs: Specs, settings: dict[str, Any]) -> None:
    point = loaded(specs, **settings)
    ahead, visit = MemoryListener(), MemoryListener()
    first = simulate(*point, listeners=(ahead,))
    assert simulate(*point, listeners=(visit,), granularity="visit") == first
    assert comparable(ahead.records) == comparable(visit.records)
    assert simulate(*point) == first
    memo = Memo()
    assert simulate(*point, memo=memo) == first
    assert simulate(*point, memo=memo) == first
    assert memo.hits


def test_a_result_tells_what_a_display_read(tmp_path: Path) -> None:
    text = (data_folder("platforms") / "virtex2pro-vga.yaml").read_text(encoding="utf-8")

    def screen(beside: str = "fpga", **settings: Any) -> DisplayUse:
        (tmp_path / "vga.yaml").write_text(text.replace("beside: fpga # reads", f"beside: {beside} # reads"))
        files = codesign.load_platform(tmp_path / "vga.yaml"), codesign.load_workload("breadth-first")
        result = simulate(*point_of(*files, {f"dimm.{name}": value for name, value in settings.items()}))
        assert result.displays is not None
        assert [*result.displays] == ["screen"]
        return result.displays["screen"]

    in_block_ram = screen()
    assert (in_block_ram.frames, in_block_ram.starved_words) == (0, 0)
    # Of each line of 1344 pixels at 65 MHz, 98 are cells of the map, a cycle each at 120 MHz.
    assert in_block_ram.port_share == pytest.approx(98 / (1344 / 65e6 * 120e6), rel=0.05)
    assert screen("dimm").starved_words == 0
    slow = screen("dimm", clock="20 MHz")
    assert slow.starved_words > 0
    assert slow.port_share > 0.5


def test_cycles_and_times_add_up(specs: Specs) -> None:
    listener = MemoryListener()
    result = simulate(*loaded(specs), listeners=(listener,))
    assert result.feasible
    visits, stages = listener.of(VisitsRecord), listener.of(StageRecord)
    for stage, told in zip(result.stages, stages, strict=True):
        of_stage = [record for record in visits if record.stage == stage.stage]
        assert sum(int(record.iterations.sum()) for record in of_stage) == stage.iterations == told.iterations
        assert sum(len(record.block) for record in of_stage) == stage.visits
        assert stage.cycles == stage.iterations * (stage.precision + 2)
    switches = result.cycles["relax"] - sum(stage.cycles for stage in result.stages)
    assert 0 < switches < result.cycles["relax"]
    to_planner, back = listener.of(MessageRecord)
    assert (to_planner.sender, to_planner.receiver) == ("host", "fpga")
    assert (back.sender, back.receiver) == ("fpga", "host")
    assert result.time.map_loaded_s == to_planner.end / SECOND
    assert result.time.first_plan_s == back.end / SECOND
    period = 10_000  # ps at 100 MHz
    planning = round((result.time.planned_s - result.time.map_loaded_s) * SECOND)
    waited = planning - sum(result.cycles.values()) * period
    assert 0 <= waited < period
    assert result.utilisation["fpga"] == pytest.approx(
        sum(result.cycles.values()) * period / SECOND / result.time.first_plan_s
    )
    energy = result.energy
    assert energy.energy_j == pytest.approx(energy.fpga_j + energy.processors_j)


def test_a_faster_clock_is_never_slower(specs: Specs) -> None:
    clocks = ["25 MHz", "50 MHz", "75 MHz", "100 MHz", "125 MHz"]
    times = [simulate(*loaded(specs, fpga__clock=clock)).time.first_plan_s for clock in clocks]
    assert times == sorted(times, reverse=True)
    assert len(set(times)) == len(times)


def test_the_host_costs_what_its_kernel_costs(specs: Specs) -> None:
    point = loaded(specs, relax__component="host", relax__style="software", decide__component="host")
    result = simulate(*point)
    assert result.resources == ()
    assert result.part is None
    # 40 ns a node update; at 1 GHz a clock cycle is a nanosecond.
    cells = {"relax": 12 * 18, "decide": 1}
    assert result.cycles["relax"] % 40 == 0
    assert result.cycles["relax"] // 40 == cells["relax"] * sum(stage.iterations for stage in result.stages)
    assert result.time.planned_s == sum(result.cycles.values()) * 1000 / SECOND
    limbs = simulate(*loaded(specs, relax__component="host", relax__style="software_limbs", decide__component="host"))
    assert limbs.stages == result.stages
    assert limbs.time.planned_s >= result.time.planned_s


def test_what_does_not_fit_is_a_result(specs: Specs) -> None:
    result = simulate(*loaded(specs, fpga__part="XC3S500E-4", relax__block=[24, 36]))
    assert not result.feasible
    assert result.time is None
    assert result.quality is None
    assert {reason.name for reason in result.reasons} >= {"slices", "block_rams"}
    for use in result.resources:
        assert use.demand == sum(item.figure.value for item in use.items)
        assert use.gap == max(0, use.demand - use.budget)
    for reason in result.reasons:
        assert reason.gap == pytest.approx(reason.demand - reason.limit)
        assert reason.levers


def test_precision_beyond_the_words_says_what_would_fit(specs: Specs) -> None:
    result = simulate(*loaded(specs, relax__schedule=[7, 255], relax__block=[6, 9]))
    (reason,) = [reason for reason in result.reasons if reason.kind == "bound"]
    assert (reason.demand, reason.limit) == (16 * 256, 1024)
    assert any("63 bits" in lever for lever in reason.levers)


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("goals: [[2, 2]]", "goals: [[11, 3]]", "6:11", "on an obstacle"),
        ("goals: [[2, 2]]", "goals: [[2, 2], [90, 1]]", "6:19", "cell (90, 1) is outside of the map of 24 × 36"),
        ("starts: {count: 12, seed: 1}", "starts: [[11, 3]]", "7:12", "on an obstacle"),
        ("block: [12, 18], iter", "blocks: [23, 2], iter", "9:36", "23 × 2 equal blocks do not part a map of 24 × 36"),
        (
            "relax: {component: fpga,",
            "relax: {component: fpga, style: bit_parallel,",
            "9:35",
            "no style 'bit_parallel'",
        ),
    ],
)
def test_what_only_the_map_tells_is_told_at_its_place(specs: Specs, old: str, new: str, place: str, words: str) -> None:
    text = specs[1].read_text(encoding="utf-8")
    assert old in text
    text = text.replace(old, new)
    specs[1].write_text(text, encoding="utf-8")
    with pytest.raises(SpecError) as caught:
        bind(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))
    (fault,) = caught.value.faults
    assert words in fault.what
    assert fault.hint
    assert f"{fault.line}:{fault.column}" == place


def test_a_task_apart_needs_its_cost(specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8")
    specs[1].write_text(text.replace("  decide: {component: fpga}", "  decide: {component: host}"), encoding="utf-8")
    with pytest.raises(SpecError) as caught:
        bind(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))
    (fault,) = caught.value.faults
    assert fault.key == "components.host.costs"
    assert "harmonic_decision" in fault.what
    assert "task decide" in fault.what


def test_no_link_no_run(specs: Specs) -> None:
    text = specs[0].read_text(encoding="utf-8").split("links:")[0]
    specs[0].write_text(text, encoding="utf-8")
    with pytest.raises(SpecError, match="no link joins host, which does load, and fpga, which does relax"):
        simulate(*loaded(specs))


@pytest.mark.parametrize(
    ("component", "style", "decide"),
    [("fpga", "bit_serial", "host"), ("fpga", "bit_serial", "fpga"), ("host", "software", "host")],
)
def test_a_task_is_told_once_wherever_it_is_done(specs: Specs, component: str, style: str, decide: str) -> None:
    listener = MemoryListener()
    settings = {"relax__component": component, "relax__style": style, "decide__component": decide}
    settings["host__costs__harmonic_decision"] = "5 us"
    result = simulate(*loaded(specs, **settings), listeners=(listener,))
    assert result.time is not None
    (told,) = [record for record in listener.of(TaskRecord) if record.task == "decide"]
    assert told.source == decide
    assert decide != "host" or told.end / SECOND == result.time.first_plan_s
    if decide == "host":
        # In cycles of the host, as all that it does, not in units of a kernel.
        clock = codesign.load_platform(specs[0]).components["host"].clock  # type: ignore[union-attr]
        assert told.cycles == -(-(told.end - told.time) * int(clock.value) // 10**12)


def test_a_share_of_no_cells_is_no_success(specs: Specs) -> None:
    put_map(specs, ".@\n@@\n", starts="[[0, 0]]")
    result = codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))
    assert result.quality.reachable_cells == 0
    assert result.quality.share_reaching_goal is None


def test_a_host_that_costs_nothing_keeps_nobody_busy(specs: Specs) -> None:
    put_map(specs)
    text = specs[0].read_text(encoding="utf-8").replace("40 ns", "0 ns").partition("links:")[0]
    specs[0].write_text(text.replace("  fpga:", "  # fpga:"), encoding="utf-8")
    text = specs[1].read_text(encoding="utf-8").replace("component: fpga", "component: host")
    specs[1].write_text(text, encoding="utf-8")
    result = codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))
    assert result.time.first_plan_s == 0
    assert result.utilisation == {"host": 0.0}
