"""Reports of synthesis and place-and-route tools: what is read, and what is refused with its line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.ground.errors import SpecError
from codesign.hardware.calibrate.reports import TOOLS, Report, Stage, read_report

SAMPLES = Path(__file__).parent / "samples"
TOP = "hwsw_00112233aabb"
DAMAGE = [b"", b"|", b";", b"-1", b"9" * 40, b"1.2.3", b"{", b"null", b"<td>", b"\xff"]


class Wanted(NamedTuple):
    """Tool, version, stage, top, part; resources; clocks in MHz with constraints; power in mW and its clock in MHz."""

    head: tuple[Any, ...]
    used: dict[str, float]
    clocks: Sequence[tuple[str, float, float | None]] = ()
    power: tuple[float, float, float | None] | None = None


EXPECTED: dict[str, tuple[Any, ...]] = {
    "vivado_utilization.rpt": (
        ("Vivado", "2023.2", Stage.PLACED, TOP, "xc7a100tcsg324-1"),
        {"lut4": 12345, "flip_flops": 9876, "slices": 4321, "block_rams": 25, "multipliers": 3},
    ),
    "vivado_hierarchy.rpt": (
        ("Vivado", "2023.2", Stage.ROUTED, TOP, "xc7a100tcsg324-1"),
        {"lut4": 500, "flip_flops": 400, "block_rams": 5, "multipliers": 2},
    ),
    "vivado_timing.rpt": (("Vivado", "2023.2", Stage.ROUTED, TOP, "7a100t-csg324-1"), {}, [("clk", 1000 / 5.5, 200.0)]),
    "vivado_power.rpt": (("Vivado", "2023.2", Stage.ROUTED, TOP, "xc7a100tcsg324-1"), {}, [], (98.0, 357.0, 200.0)),
    "ise_map.mrp": (
        ("ISE", "10.1.03", Stage.PLACED, "relax", "xc4vlx160ff1148-12"),
        {"lut4": 58500, "flip_flops": 31000, "slices": 33500, "block_rams": 144, "multipliers": 2},
    ),
    "ise.twr": (
        ("ISE", "10.1.03", Stage.ROUTED, "relax", "xc4vlx160ff1148-12"),
        {},
        [("clk", 125.0, 100.0), ("pci", 400.0, None)],
    ),
    "ise.syr": (
        ("ISE", "14.7", Stage.SYNTHESISED, "search", "3s500efg320-4"),
        {"lut4": 980, "flip_flops": 420, "slices": 560, "block_rams": 6, "multipliers": 1},
        [("design", 100.0, None)],
    ),
    "ise.par": (
        ("ISE", "14.7", Stage.ROUTED, "search", "xc3s500efg320-4"),
        {"lut4": 990, "flip_flops": 421, "slices": 571, "block_rams": 6, "multipliers": 1},
    ),
    "ise.pwr": (("ISE", "14.7", Stage.ROUTED, "search", "3s500efg320-4"), {}, [], (82.72, 59.27, None)),
    "quartus.fit.rpt": (
        ("Quartus", "18.1.0", Stage.ROUTED, TOP, "EP4CE22F17C6"),
        {"lut4": 1584, "flip_flops": 649, "block_rams": 3, "multipliers": 2},
    ),
    "quartus.fit.summary": (
        ("Quartus", "18.1.0", Stage.ROUTED, TOP, "EP4CE22F17C6"),
        {"lut4": 1584, "flip_flops": 649, "multipliers": 2},
    ),
    "quartus.sta.rpt": (("Quartus", "18.1.0", Stage.ROUTED, "search", "EP4CE22F17C6"), {}, [("clk", 150.0, 175.0)]),
    "quartus.pow.summary": (("Quartus", "18.1.0", Stage.ROUTED, TOP, "EP4CE22F17C6"), {}, [], (83.89, 30.46, None)),
    "diamond.mrp": (
        ("Diamond", "3.12.1.454", Stage.SYNTHESISED, TOP, "LFE5U-85FCABGA381-6"),
        {"lut4": 60000, "flip_flops": 31000, "slices": 34000, "block_rams": 144, "multipliers": 2},
    ),
    "diamond.twr": (("Diamond", "3.12.1.454", Stage.ROUTED, TOP, "LFE5U-85F-6"), {}, [("clk_c", 81.5, 100.0)]),
    "radiant.mrp": (
        ("Radiant", "2024.1.0.34.2", Stage.SYNTHESISED, TOP, "iCE40UP5K"),
        {"lut4": 2100, "flip_flops": 900, "block_rams": 12, "multipliers": 0},
    ),
    "radiant.twr": (("Radiant", "2024.1.0.34.2", Stage.ROUTED, TOP, "iCE40UP5K"), {}, [("clk", 28.571, 48.001)]),
    "gowin.rpt.txt": (
        ("Gowin EDA", "1.9.9.03 (64-bit)", Stage.ROUTED, TOP, "GW2A-LV18PG256C8/I7"),
        {"lut4": 3427, "flip_flops": 1454, "slices": 2099, "block_rams": 15, "multipliers": 2.5},
    ),
    "gowin_tr_content.html": (
        ("Gowin EDA", "1.9.9.03 (64-bit)", Stage.ROUTED, TOP, "GW2A-LV18PG256C8/I7"),
        {},
        [("clk", 186.543, 200.0)],
    ),
    "gowin.power.html": (
        ("Gowin EDA", "1.9.9.03 (64-bit)", Stage.ROUTED, TOP, "GW2A-LV18PG256C8/I7"),
        {},
        [],
        (93.544, 151.676, 180.0),
    ),
    "yosys_stat.txt": (
        ("Yosys", "", Stage.SYNTHESISED, TOP, ""),
        {"lut4": 8, "flip_flops": 24, "block_rams": 1, "multipliers": 1},
    ),
    "yosys_stat.json": (
        ("Yosys", "0.70", Stage.SYNTHESISED, TOP, ""),
        {"lut4": 8, "flip_flops": 24, "block_rams": 1, "multipliers": 1},
    ),
    "nextpnr.log": (
        ("nextpnr", "", Stage.ROUTED, "", ""),
        {"lut4": 14, "flip_flops": 24, "block_rams": 1, "multipliers": 1},
        [("clk", 106.25, 150.0)],
    ),
    "nextpnr_report.json": (
        ("nextpnr", "", Stage.ROUTED, "", ""),
        {"lut4": 14, "flip_flops": 24, "block_rams": 1, "multipliers": 1},
        [("clk", 106.247, 150.0)],
    ),
}


def numbers(report: Report) -> tuple[Any, ...]:
    """All that a report says, without lines."""
    return (
        {name: reading.value for name, reading in report.used.items()},
        [(clock.name, clock.fmax.value, clock.constraint) for clock in report.clocks],
        None if report.static is None else report.static.value,
        None if report.dynamic is None else report.dynamic.value,
    )


def test_every_sample_is_expected() -> None:
    assert {path.name for path in SAMPLES.iterdir()} == set(EXPECTED)


@pytest.mark.parametrize("name", EXPECTED)
def test_a_report_is_read(name: str) -> None:
    report = read_report(SAMPLES / name)
    head, used, clocks, power = Wanted(*EXPECTED[name])
    assert (report.tool, report.version, report.stage, report.top, report.part) == head
    assert {kind: reading.value for kind, reading in report.used.items()} == used
    assert [clock.name for clock in report.clocks] == [clock for clock, _, _ in clocks]
    for clock, (_, fmax, constraint) in zip(report.clocks, clocks, strict=True):
        assert clock.fmax.value / 1e6 == pytest.approx(fmax, abs=1e-3)
        assert clock.constraint == (None if constraint is None else pytest.approx(constraint * 1e6))
    if power is not None:
        assert report.static is not None
        assert report.dynamic is not None
        static, dynamic, at = power
        assert (report.static.value * 1e3, report.dynamic.value * 1e3) == pytest.approx((static, dynamic))
        assert report.power_clock == (None if at is None else pytest.approx(at * 1e6))


@pytest.mark.parametrize("name", EXPECTED)
def test_every_number_has_its_line(name: str) -> None:
    """The line of a count has its number; a count that is a sum of several cells or sites has the first."""
    report = read_report(SAMPLES / name)
    lines = (SAMPLES / name).read_text(encoding="utf-8").splitlines()
    for reading in [*report.used.values(), *(clock.fmax for clock in report.clocks)]:
        assert 1 <= reading.line <= len(lines)
    if report.tool in ("Vivado", "ISE", "Quartus", "Diamond") and "flip_flops" in report.used:
        reading = report.used["flip_flops"]
        line = lines[reading.line - 1]
        assert f"{reading.value:,.0f}" in line or f"{reading.value:.0f}" in line


@pytest.mark.parametrize("name", EXPECTED)
def test_a_report_that_is_cut_off_is_refused_or_whole(name: str, tmp_path: Path) -> None:
    """Cut after any line, a report never gives other numbers than the whole one."""
    content = (SAMPLES / name).read_bytes()
    lines = content.splitlines(keepends=True)
    cuts = [b"".join(lines[:count]) for count in range(1, len(lines))]
    if len(lines) < 3:
        cuts = [content[:length] for length in range(1, len(content), 41)]
    whole, refused = numbers(read_report(SAMPLES / name)), 0
    for cut in cuts:
        (tmp_path / "cut.txt").write_bytes(cut)
        try:
            report = read_report(tmp_path / "cut.txt")
        except SpecError:
            refused += 1
        else:
            assert numbers(report) == whole
    assert refused > len(cuts) / 3


def test_places_of_a_hierarchy_are_summed_over_their_instances() -> None:
    places = {place.modules: place.used for place in read_report(SAMPLES / "vivado_hierarchy.rpt").hierarchy}
    assert {name: reading.value for name, reading in places["node",].items()} == {
        "lut4": 405,
        "flip_flops": 302,
        "block_rams": 2,
        "multipliers": 2,
    }
    assert places["control",]["block_rams"].value == 3
    assert places[()]["lut4"].value == 10, "the row in brackets: what the top has by itself"
    places = {place.modules: place.used for place in read_report(SAMPLES / "yosys_stat.txt").hierarchy}
    assert places["node",]["flip_flops"].value == 8
    assert places[()]["flip_flops"].value == 16
    assert read_report(SAMPLES / "yosys_stat.json").hierarchy == (), "it was flattened"


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "latin-1"])
def test_encodings(tmp_path: Path, encoding: str) -> None:
    text = (SAMPLES / "quartus.fit.summary").read_text(encoding="utf-8").replace("search", "größe")
    (tmp_path / "r.summary").write_bytes(text.encode(encoding))
    assert read_report(tmp_path / "r.summary").used["flip_flops"].value == 649


def write(folder: Path, name: str, old: str, new: str) -> Path:
    """A sample with a change, in a folder."""
    text = (SAMPLES / name).read_text(encoding="utf-8")
    assert old in text
    (folder / name).write_text(text.replace(old, new, 1), encoding="utf-8")
    return folder / name


@pytest.mark.parametrize(
    ("name", "old", "new", "expected"),
    [
        ("vivado_utilization.rpt", "| 12345 |", "| viele |", ":30:1: 'viele' is not a number"),
        ("vivado_power.rpt", "| 0.357        |", "| -0.357       |", ":28:1: -0.357 is negative"),
        ("vivado_power.rpt", "Total On-Chip Power (W)", "Something else", ":1:1: is another report of Vivado"),
        ("vivado_timing.rpt", "| Clock Summary", "| Taktübersicht", "the Clock Summary is missing"),
        ("ise.twr", "   8.000ns.", "   0.000ns.", ":18:1: a period of 0.000"),
        ("quartus.fit.summary", "Successful", "Failed", ":1:1: Fitter Status: Failed"),
        ("diamond.mrp", "60000 out of", "99999999999 out of", ":25:1: 99999999999 is out of bounds"),
        ("yosys_stat.json", '"TRELLIS_FF": 24', '"TRELLIS_FF": -3', "the number of TRELLIS_FF is no count"),
        ("nextpnr_report.json", '"used": 14', '"used": "14"', "used of TRELLIS_COMB is no number"),
    ],
)
def test_faults_of_numbers_and_kinds(tmp_path: Path, name: str, old: str, new: str, expected: str) -> None:
    path = write(tmp_path, name, old, new)
    with pytest.raises(SpecError) as refused:
        read_report(path)
    assert expected in str(refused.value)
    assert str(refused.value).startswith(str(path))


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "is empty"),
        (b"module top(input clk); endmodule\n", "is no report that is known"),
        (b"Vivado\x00\x01\x02", "is no text: it has a zero byte"),
        (
            "| Werkzeugversion : Vivado v.2023\n設計の使用率レポート\n".encode(),
            ":2:1: mentions Vivado in another language",
        ),
        (b'{"fmax": {}, "utilization": ', "no JSON"),
    ],
)
def test_files_that_are_no_report(tmp_path: Path, content: bytes, expected: str) -> None:
    (tmp_path / "r.rpt").write_bytes(content)
    with pytest.raises(SpecError) as refused:
        read_report(tmp_path / "r.rpt")
    assert expected in str(refused.value)


def test_a_folder_and_a_missing_file(tmp_path: Path) -> None:
    for path, expected in ((tmp_path, "is a folder"), (tmp_path / "none.rpt", "does not exist")):
        with pytest.raises(SpecError, match=expected):
            read_report(path)


def test_every_reader_knows_only_its_own() -> None:
    from codesign.hardware.calibrate.reports.engine import read_text

    for name in EXPECTED:
        text = read_text(SAMPLES / name, name)
        assert sum(tool.wrote(text) for tool in TOOLS) == 1, name


@pytest.mark.parametrize("name", EXPECTED)
@settings(max_examples=examples(25))
@given(data=st.data())
def test_a_damaged_report_is_read_or_refused(name: str, data: st.DataObject, tmp_path: Path) -> None:
    """Lines lost, repeated, exchanged or damaged: a report or a fault with its place, and nothing else."""
    lines = (SAMPLES / name).read_bytes().splitlines(keepends=True)
    places = st.integers(0, len(lines) - 1)
    for _ in range(data.draw(st.integers(1, 5))):
        here, there = data.draw(places), data.draw(places)
        damage = data.draw(st.sampled_from(DAMAGE))
        column = data.draw(st.integers(0, len(lines[here])))
        lines[there], lines[here] = lines[here], lines[there][:column] + damage + lines[there][column:]
    (tmp_path / "r.txt").write_bytes(b"".join(lines))
    try:
        report = read_report(tmp_path / "r.txt")
    except SpecError:
        return
    assert all(reading.value >= 0 for reading in report.used.values())


class TestEdalize:
    """The parsers of edalize, where they read the same, as an independent oracle."""

    def test_vivado(self) -> None:
        vivado = pytest.importorskip("edalize.vivado_reporting").VivadoReporting
        resources = vivado.report_resources(str(SAMPLES / "vivado_utilization.rpt"))
        timing = vivado.report_timing(str(SAMPLES / "vivado_timing.rpt"))
        summary = vivado.report_summary(resources, timing)
        ours = read_report(SAMPLES / "vivado_utilization.rpt").used
        assert (summary["lut"], summary["reg"]) == (ours["lut4"].value, ours["flip_flops"].value)
        assert summary["dsp"] == ours["multipliers"].value
        assert 2 * summary["blkmem"] == ours["block_rams"].value
        (clock,) = read_report(SAMPLES / "vivado_timing.rpt").clocks
        assert summary["fmax"]["clk"] == pytest.approx(clock.fmax.value / 1e6, rel=1e-3)

    def test_ise(self) -> None:
        ise = pytest.importorskip("edalize.ise_reporting").IseReporting
        timing = ise.report_timing(str(SAMPLES / "ise.twr"))
        clock = read_report(SAMPLES / "ise.twr").clocks[0]
        assert timing["max clock"] == pytest.approx(clock.fmax.value / 1e6)

    def test_quartus(self) -> None:
        quartus = pytest.importorskip("edalize.quartus_reporting").QuartusReporting
        tables = quartus.report_timing(str(SAMPLES / "quartus.sta.rpt"))
        fmax = tables["Slow 1200mV 85C Model Fmax Summary"].iloc[0]["Restricted Fmax"]
        (clock,) = read_report(SAMPLES / "quartus.sta.rpt").clocks
        assert float(str(fmax).split()[0]) == clock.fmax.value / 1e6
