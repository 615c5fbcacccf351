"""The catalogue: every board, part and host that ships cites its figures; hosts are found, filled in and refused."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import BaseModel

import codesign
from codesign.ground.errors import InputError, SpecError
from codesign.ground.figures import FIGURES, Figure, Status, last_day
from codesign.hardware.calibrate.host_costs import all_probes
from codesign.inputs import Platform, design_point, list_platforms, load_part, load_platform
from codesign.inputs.components import FpgaComponent, ProcessorComponent
from codesign.inputs.files import data_folder
from codesign.inputs.library import HOSTS, PARTS
from codesign.inputs.links import BusLink
from codesign.inputs.platform import Board
from codesign.planners.styles import Architecture
from codesign.system import catalog
from codesign.system.place import RENDER_KERNEL
from codesign.system.scenarios import simulate

PLATFORMS = {name: load_platform(name) for name in list_platforms()}
WITH_FABRIC = [name for name, platform in PLATFORMS.items() if "fabric" in platform.filled]
ON_BOARDS = [name for name, platform in PLATFORMS.items() if platform.board is not None and "fabric" in platform.filled]

# Not from the part files: reports of tools on designs for these parts, and pages of their makers.
COUNTS = {
    "iCE40UP5K": (
        5280,
        5280,
        30,
        8,
    ),  # nextpnr-ice40: ICESTORM_LC 5280, ICESTORM_RAM 30; README of the iCEBreaker: 8 DSP
    "iCE40HX8K": (7680, 7680, 32, 0),  # nextpnr-ice40: ICESTORM_LC 7680, ICESTORM_RAM 32
    "LFE5U-25F": (24288, 24288, 56, 28),  # nextpnr-ecp5: TRELLIS_FF 24288, DP16KD 56, MULT18X18D 28
    "LFE5U-85F": (83640, 83640, 208, 156),  # Diamond: LUTS_avail 83640, EBR_avail 208; nextpnr-ecp5: MULT18X18D 156
    "GW1NR-9": (8640, 6480, 26, 20),  # Sipeed, page of the Tang Nano 9K
    "GW2A-18": (20736, 20736 * 6 // 8, 828 // 18, 48),  # 20K LUT, 828 kbit: Sipeed, page of the Tang Primer 20K
    "GW2AR-18": (20736, 15552, 828 // 18, 48),  # as the GW2A-18, with SDRAM in its package
    "XC7A35T": (20800, 41600, 100, 90),  # Vivado on 7a35t: 20800, 41600, 50 tiles, 90
    "XC7A100T": (63400, 126800, 270, 240),  # Vivado on 7a100t: 63400, 126800, 135 tiles, 240
    "XC7A200T": (134600, 269200, 730, 740),  # Vivado on xc7a200t: 134600, 269200, 365 tiles, 740
    "XC7Z010": (17600, 35200, 120, 80),  # Vivado on xc7z010: 17600; 60 tiles and 80 DSP in a user's table of his boards
    "XC7Z020": (53200, 106400, 280, 220),  # Vivado on 7z020: 53200, 106400, 140 tiles, 220
    "XCZU3EG": (70560, 141120, 432, 360),  # Vivado on xczu3eg: 70560, 141120, 432 RAMB18, 360
    "XCZU7EV": (230400, 460800, 624, 1728),  # Vivado on xczu7ev: 230400, 460800; a tool's limits: 312 BRAM, 1728 DSP
    "XCK26": (117120, 234240, 288, 1248),  # Vivado on xck26: 117120, 234240, 288 RAMB18, 1248
    "MPFS250T": (254000, 254000, 812, 784),  # Microchip, table of interface logic: 812 LSRAM, 784 math blocks; 254K LE
    "MPF100T": (108600, 108600, 352, 336),  # Microchip, table of interface logic: 352 LSRAM, 336 math blocks; 109K LE
}
"""LUT, flip-flops, block RAMs, multipliers."""


@pytest.mark.parametrize("name", COUNTS)
def test_parts_have_what_tools_report(name: str) -> None:
    resources = PARTS.find(name).resources
    luts = resources.lut4 or resources.lut6
    assert luts is not None
    counted = (luts, resources.flip_flops, resources.block_rams, resources.multipliers)
    assert tuple(int(figure.value) for figure in counted) == COUNTS[name]


@pytest.mark.parametrize(
    ("name", "slices", "a_slice"), [("XC7A35T-1", 10400, 2), ("XCZU3EG-1", 35280, 4), ("LFE5U-85F-6", 41820, 1)]
)
def test_slices_count_as_two_lut_and_two_flip_flops(name: str, slices: int, a_slice: int) -> None:
    part = load_part(name)
    file = PARTS.find(part.name)
    assert part.resources["slices"].value == slices == a_slice * file.resources.slices.value
    assert part.resources["slices"].interval[1] == slices * (1 if a_slice == 1 else 2)
    assert part.dynamic_power.value == pytest.approx(file.power.dynamic.value / a_slice)


def figures_in(value: Any) -> Iterator[Figure]:
    """Every figure inside a model."""
    if isinstance(value, Figure):
        yield value
    elif isinstance(value, BaseModel):
        yield from figures_in(dict(value))
    elif isinstance(value, dict):
        for inner in value.values():
            yield from figures_in(inner)


@pytest.mark.parametrize("name", PLATFORMS)
def test_every_figure_of_a_platform_says_where_it_is_from(name: str) -> None:
    figures = list(figures_in(PLATFORMS[name]))
    assert figures
    for figure in figures:
        assert isinstance(figure.status, Status)
        assert len(figure.source) > 3
        assert not figure.source.startswith("declared")
        assert figure.interval[0] <= figure.value <= figure.interval[1]


@pytest.mark.parametrize("folder", ["parts", "hosts"])
def test_every_figure_of_a_part_or_host_says_where_it_is_from(folder: str) -> None:
    library: Any = PARTS if folder == "parts" else HOSTS
    for name in library.names():
        for figure in figures_in(library.find(name)):
            assert len(figure.source) > 3, name
            assert not figure.source.startswith("declared"), name


def test_the_catalogue_has_the_boards_and_hosts_that_it_must_have() -> None:
    assert len(ON_BOARDS) >= 15
    used = {part.part.rpartition("-")[0] for part in _fabrics()}
    assert set(COUNTS) - {"MPF100T"} <= used
    assert {"cortex-m7", "cortex-a53", "cortex-a72", "cortex-a76", "laptop-i7", "pc-ryzen"} <= set(HOSTS.names())
    alone = {"jetson-orin-nano", "nucleo-h743zi", "pico", "pico-2", "esp32-s3-devkitc"}
    assert alone <= set(PLATFORMS)
    assert {"basys-3", "cmod-a7-35t", "tang-nano-20k", "icesugar", "ax7020"} <= set(ON_BOARDS)


def test_a_computer_without_an_operating_system_declares_its_memory() -> None:
    """It has no swap, and its RAM is some KiB: a map that is too large has to be refused."""
    bare = [file for file in map(HOSTS.find, HOSTS.names()) if "No operating system" in file.description]
    assert len(bare) >= 5
    for file in bare:
        assert file.memory is not None, file.name
        assert file.memory.value < 8 * 2**21, "less than 2 MiB"


SPI = [name for name in ON_BOARDS if PLATFORMS[name].filled["link"] == "spi"]


@pytest.mark.parametrize("name", SPI)
def test_an_spi_is_a_bus_of_one_bit(name: str) -> None:
    """Its set-up is a time: cycles at its clock come to 20 us, and 4,096 bytes are one burst."""
    bus = PLATFORMS[name].links["spi"]
    assert isinstance(bus, BusLink)
    assert (bus.width.value, bus.burst_words.value) == (1, 8 * 4096)
    assert bus.setup_cycles.value / bus.clock.value == pytest.approx(20e-6, rel=0.01)
    assert bus.clock.interval[1] <= 62_500_000


def _fabrics() -> list[FpgaComponent]:
    parts = [PLATFORMS[name].components[PLATFORMS[name].filled["fabric"]] for name in ON_BOARDS]
    return [part for part in parts if isinstance(part, FpgaComponent)]


@pytest.mark.parametrize("name", ON_BOARDS)
def test_boards_fill_every_role(name: str) -> None:
    platform = PLATFORMS[name]
    assert set(platform.filled) == {"fabric", "host", "link"}
    between = platform.links[platform.filled["link"]].between
    assert {platform.filled["fabric"], platform.filled["host"]} <= set(between)


def test_prices_are_figures() -> None:
    for platform in PLATFORMS.values():
        if platform.board is not None and platform.board.price is not None:
            price = platform.board.price
            assert price.unit == "USD"
            assert 1 < price.value < 5000
            assert price.interval[0] < price.interval[1]
            assert price.date
            assert price.date[:4] in price.source
            assert last_day(price.date).isoformat() < "2027", "of a year that is over, or of this one"


def processors(platform: Platform) -> list[ProcessorComponent]:
    return [spec for spec in platform.components.values() if isinstance(spec, ProcessorComponent)]


ON_SALE = sorted(
    {spec.host or "" for name in PLATFORMS if PLATFORMS[name].board is not None for spec in processors(PLATFORMS[name])}
    | {"epyc-9004"}
)
"""The hosts of boards, and the one that was measured. The others are the machines of papers."""


@pytest.mark.parametrize("name", ON_SALE)
def test_hosts_have_a_cost_of_every_kernel(name: str) -> None:
    costs = HOSTS.find(name).all_costs()
    assert set(costs) == {*all_probes(), RENDER_KERNEL}
    for cost in costs.values():
        assert isinstance(cost.value, int)
        assert cost.interval[0] < cost.value < cost.interval[1]


SOFTWARE = [style for style in catalog.architectures().values() if style.component_type == "processor"]


@pytest.mark.parametrize("name", sorted(set(HOSTS.names()) - set(ON_SALE)))
def test_the_machine_of_a_paper_has_all_costs_of_a_program_or_none(name: str) -> None:
    """A cost of 0 names the cost that holds it."""
    costs = HOSTS.find(name).all_costs()
    families = ("breadth_first_(?!java)", "wavefront_", "relaxation_", "grid_search_")
    for family in families:
        known = {kernel for kernel in all_probes() if re.match(family, kernel)}
        assert known & set(costs) in (set(), known)
    for cost in costs.values():
        holder = re.match(r"held in (\w+), ", cost.source)
        assert (cost.value == 0) == (holder is not None)
        assert holder is None or costs[holder[1]].value > 0


def test_one_computer_is_one_file() -> None:
    """No platform has a list of costs of its own, so a computer plans alike wherever it stands."""
    for path in data_folder("platforms").glob("*.yaml"):
        tree = yaml.safe_load(path.read_text(encoding="utf-8"))
        for component in tree["components"].values():
            if component["type"] == "processor":
                assert "host" in component, path.name
                assert "costs" not in component, path.name


@pytest.mark.parametrize("host", sorted(HOSTS.names()))
def test_platforms_with_one_host_give_one_software_time(host: str) -> None:
    times: dict[str, set[float | None]] = {}
    for platform in PLATFORMS.values():
        for name, spec in platform.components.items():
            if not isinstance(spec, ProcessorComponent) or spec.host != host:
                continue
            for style in SOFTWARE:
                if {style.kernel} <= set(spec.costs):
                    question = in_software(style, name)
                    time = simulate(platform, codesign.load_workload(question)).figure(FIGURES["plan_time_worst_s"])
                    times.setdefault(f"{style.planner} {style.style}", set()).add(time)
    assert all(len(each) == 1 for each in times.values()), times
    assert times or host == "pc-2013"


def in_software(style: Architecture, component: str) -> dict[str, Any]:
    """A plan on a component, in that style."""
    planner = catalog.planner(style.planner)
    parameters: dict[str, Any] = {"component": component, "style": style.style}
    if style.planner == "harmonic":
        parameters |= {"block": [12, 16], "iterations": 40, "schedule": [15, 31]}
    return {
        "kind": "workload",
        "name": "here",
        "planner": style.planner,
        "problem": {
            "map": {"generate": "rooms", "rows": 24, "columns": 32, "room": [11, 15], "door": 3, "seed": 5},
            "goals": [[2, 2]],
            "starts": [[20, 28]],
            "arrive": 0,
        },
        "mapping": {planner.planning_task: parameters},
    }


def test_a_host_that_was_not_measured_is_a_measured_one_times_its_factor() -> None:
    measured, pi = HOSTS.find("epyc-9004"), HOSTS.find("cortex-a72")
    assert pi.costs_of is not None
    statuses = {kernel: cost.status for kernel, cost in measured.costs.items()}
    assert statuses["breadth_first_cell"] == statuses["sparse_solve_cell"] == Status.MEASURED
    for kernel, cost in pi.all_costs().items():
        other, factor = measured.costs[kernel], pi.costs_of.factor
        assert cost.value == round(other.value * factor.value)
        assert cost.interval == (
            round(other.interval[0] * factor.interval[0]),
            round(other.interval[1] * factor.interval[1]),
        )
        assert cost.status == Status.ASSUMED
        assert "epyc-9004" in cost.source


PLATFORM = """kind: platform
name: p
components:
  host: {type: processor, host: HOST}
"""

HOST = """kind: host
name: mine
clock: 1 GHz
costs: {breadth_first_cell: 10 ns}
costs_of: {host: epyc-9004, factor: 3}
power: {busy: 2 W, idle: 1 W}
"""


def host_of(folder: Path, host: str, platform: str = PLATFORM, file: str | None = None) -> ProcessorComponent:
    """The processor of a platform in a folder, on that host; ``file``: the text of hosts/mine.yaml."""
    if file is not None:
        (folder / "hosts").mkdir(exist_ok=True)
        (folder / "hosts" / "mine.yaml").write_text(file)
    (folder / "p.yaml").write_text(platform.replace("HOST", host))
    component = load_platform(folder / "p.yaml").components["host"]
    assert isinstance(component, ProcessorComponent)
    return component


def test_a_host_beside_the_platform_is_found_first(tmp_path: Path) -> None:
    host = host_of(tmp_path, "mine", file=HOST)
    assert host.clock.value == 10**9
    assert host.clock.source == "declared in mine.yaml:3"
    assert host.costs["breadth_first_cell"].value == 10_000
    assert host.costs["wavefront_cell"].value == 3 * 6230


def test_keys_beside_a_host_take_the_place_of_its_own(tmp_path: Path) -> None:
    own = PLATFORM.replace("HOST}", "HOST, clock: 2 GHz, cores: 4, costs: {wavefront_cell: 7 ns}}")
    host = host_of(tmp_path, "cortex-a72", own)
    assert (host.clock.value, host.cores) == (2 * 10**9, 4)
    assert host.costs["wavefront_cell"].value == 7000
    assert host.costs["breadth_first_cell"].value == 4 * 5881


@pytest.mark.parametrize(
    ("host", "file", "expected"),
    [
        ("cortex-a71", None, "p.yaml:4:33: components.host.host: there is no host 'cortex-a71'\n  hint: did you mean"),
        ("3", None, "components.host.host: 3 is not text"),
        ("mine", HOST.replace("factor: 3", "factor: 0"), "mine.yaml:5:37: costs_of.factor: 0 is out of bounds"),
        ("mine", HOST.replace("factor: 3", "factor: 3 s"), "costs_of.factor: '3 s' is not a number"),
        ("mine", HOST.replace("epyc-9004", "cortex-a72"), "host cortex-a72, which has none of its own"),
        ("mine", HOST.replace("epyc-9004", "nobody"), "there is no host 'nobody'"),
        ("mine", HOST.replace("name: mine", "name: yours"), "mine.yaml:2:7: name: 'yours' in file mine.yaml"),
        ("mine", HOST.replace("clock: 1 GHz", "clok: 1 GHz"), "mine.yaml:3:1: clok: unknown key"),
    ],
)
def test_hosts_are_refused_with_their_place(tmp_path: Path, host: str, file: str | None, expected: str) -> None:
    with pytest.raises(SpecError) as caught:
        host_of(tmp_path, host, file=file)
    assert expected in str(caught.value)


def test_a_processor_without_a_host_needs_clock_and_power(tmp_path: Path) -> None:
    with pytest.raises(SpecError) as caught:
        host_of(tmp_path, "", PLATFORM.replace(", host: HOST", ""))
    assert {fault.key for fault in caught.value.faults} == {"components.host.clock", "components.host.power"}


def test_the_digest_sees_the_files_of_the_host(tmp_path: Path) -> None:
    """Its own file, and that of the host it takes its costs from; a source alone changes nothing."""

    def digest() -> str:
        return load_platform(tmp_path / "p.yaml").digest()

    host_of(tmp_path, "mine", file=HOST)
    before = digest()
    host_of(tmp_path, "mine", file=HOST.replace("clock: 1 GHz", "clock: {value: 1 GHz, status: assumed, source: x}"))
    assert digest() == before
    host_of(tmp_path, "mine", file=HOST.replace("10 ns", "11 ns"))
    assert digest() != before
    host_of(tmp_path, "mine", file=HOST)
    text = (HOSTS.shipped / "epyc-9004.yaml").read_text(encoding="utf-8")
    (tmp_path / "hosts" / "epyc-9004.yaml").write_text(text.replace("4449 ps", "4450 ps"), encoding="utf-8")
    assert digest() != before


def test_an_axis_moves_the_host_and_a_key_of_it() -> None:
    workload = catalog.load_workload("breadth-first-java")
    platform = load_platform("raspberry-pi-4")
    moved, _ = design_point(platform, workload, {"host.host": "cortex-a76"}, "--set ")
    assert moved.components["host"].clock.value == 2_400_000_000  # type: ignore[union-attr]
    moved, _ = design_point(platform, workload, {"host.cores": 2}, "--set ")
    assert moved.components["host"].cores == 2  # type: ignore[union-attr]
    with pytest.raises(SpecError, match="there is no host 'cortex'"):
        design_point(platform, workload, {"host.host": "cortex"}, "--set ")


def test_a_board_changes_no_result(tmp_path: Path) -> None:
    shipped = PLATFORMS["pynq-z2"]
    assert shipped.board is not None
    cheaper = Board(product="another", maker="another", price=None)
    assert shipped.model_copy(update={"board": cheaper}).digest() == shipped.digest()
    assert isinstance(shipped, Platform)
    (tmp_path / "p.yaml").write_text(
        PLATFORM.replace("HOST", "cortex-a72") + "board: {product: x, price: 5 EUR, colour: red}\n"
    )
    with pytest.raises(SpecError) as caught:
        load_platform(tmp_path / "p.yaml")
    assert "board.price: '5 EUR' has no unit of price\n  hint: accepted units: USD" in str(caught.value)
    assert "board.colour: unknown key" in str(caught.value)


SEARCH = """kind: workload
name: search
planner: breadth_first
problem: {map: {generate: rooms, rows: 32, columns: 32, room: [8, 8], door: 2}, goals: [[1, 1]], starts: [[30, 30]]}
mapping: {search: {component: fpga, style: state_machine}, track: {component: host}}
"""


PLACED = ("orangecrab-25f", "ulx3s-85f")
"""Boards with a part of a family that the search was placed on at this size: its clock limit is measured."""


@pytest.mark.parametrize("name", ON_BOARDS)
def test_one_search_runs_on_every_board(tmp_path: Path, name: str) -> None:
    (tmp_path / "w.yaml").write_text(SEARCH)
    result = simulate(PLATFORMS[name], catalog.load_workload(tmp_path / "w.yaml"))
    assert result.feasible, result.reasons
    assert result.time is not None
    assert result.time.first_plan_s > 0
    assert result.clock is not None
    limit = result.clock.limit
    assert limit.status is (Status.MEASURED if name in PLACED else Status.ASSUMED)
    assert result.clock.hz < limit.interval[0]
    if name not in PLACED and not limit.source.startswith("block RAM"):
        assert "was never placed" in limit.source
        assert limit.interval[1] - limit.interval[0] >= 0.6 * limit.value


def test_part_names_may_hold_dashes() -> None:
    assert load_part("LFE5U-85F-8").full_name == "LFE5U-85F-8"
    with pytest.raises(InputError, match="part LFE5U-85F has several speed grades"):
        load_part("LFE5U-85F")
    with pytest.raises(InputError, match="part GW2A-18 has no speed grade '-9'"):
        load_part("GW2A-18-9")
