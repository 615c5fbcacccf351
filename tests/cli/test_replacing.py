"""What a command may replace: an empty file, or one of the kind that it writes; anything else only with --force."""

from __future__ import annotations

import builtins
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import Result
from hypothesis import given
from hypothesis import strategies as st

from codesign.cli import main
from codesign.cli.outputs import KINDS, check_replaceable
from codesign.ground.errors import InputError

Run = Callable[..., Result]

FOREIGN = {
    "json": b'{"result": "of a week"}',
    "table": b"name,phone\nAda,1\n",
    "page": b"<!DOCTYPE html>\n<html><title>Mine</title></html>",
    "zip": b"PK\x03\x04 of another program",
    "mcap": b"\x89MCAP0\r\n of a robot",
    "sqlite": b"SQLite format 3\x00" + bytes(100),
    "yaml": b"kind: platform\n",
    "text": b"dear diary\n",
}

CHECKED_ELSEWHERE = {
    ("explore", "--store"): "the store refuses a file of another program (exploration/test_store_faults.py)",
    ("rtl", "--output"): "refuses a folder that is not empty (rtl)",
    ("init", "FOLDER"): "refuses files that are there (test_begin.py)",
    ("workload from-bag", "--out"): "refuses files that are there",
    ("workload from-bag", "BAG"): "is read",
    ("run", "--ros2"): "refuses a folder that is not empty",
    ("trace export", "--ros2"): "refuses a folder that is not empty",
    ("calibrate fpga", "--report"): "is read",
    ("calibrate fpga", "--with"): "is read",
    ("advise", "--write"): "a file in a folder (below)",
    ("measured", "FILE"): "is read",
    ("measured", "--write"): "refuses a file of another kind (hardware/calibrate)",
    ("calibrate host", "--from"): "is read",
    ("calibrate host", "--write"): "refuses a file of another kind (hardware/calibrate)",
    ("reproduce", "--plots"): "files in a folder (below)",
}

WRITERS = {
    ("run", "--trace"): ["run", "board.yaml", "rooms.yaml", "--trace"],
    ("run", "--html"): ["run", "board.yaml", "rooms.yaml", "--html"],
    **{
        (command, option): [command, *given, option]
        for command, given in (("explore", ["board.yaml", "rooms.yaml"]), ("report", ["old.sqlite"]))
        for option in ("--csv", "--parquet", "--html", "--certify")
    },
    ("advise", "--html"): ["advise", "house", "--goal", "0.0,-0.5", "--rate", "10Hz", "--html"],
    ("compare", "--html"): ["compare", "board.yaml:rooms.yaml", "board.yaml:rooms.yaml", "--html"],
    **{
        ("trace export", option): ["trace", "export", "old.mcap", option]
        for option in ("--perfetto", "--vcd", "--poses", "--html")
    },
    ("advise", "--certify"): [
        "advise",
        "house",
        "--goal",
        "0.0,-0.5",
        "--rate",
        "1 Hz",
        "--boards",
        "pico",
        "--certify",
    ],
    ("trace layout", "--output"): ["trace", "layout", "old.mcap", "-o"],
    ("trace show", "--picture"): ["trace", "show", "old.mcap", "--at", "0 s", "--picture"],
    **{
        (f"plot {name}", "--output"): ["plot", name, given, "-o"]
        for name, given in (
            *((each, "old.sqlite") for each in ("front",)),
            *((each, "old.mcap") for each in ("map", "timeline", "schedule")),
        )
    },
    ("map", "--png"): ["map", "house", "--png"],
    ("verify", "--waves"): ["verify", "board.yaml", "rooms.yaml", "--waves"],
    ("reproduce", "--html"): ["reproduce", "--quick", "--html"],
    ("reproduce", "--csv"): ["reproduce", "--quick", "--csv"],
    ("fidelity", "--output"): ["fidelity", "--quick", "-o"],
    ("fidelity", "--picture"): ["fidelity", "--quick", "--picture"],
    ("calibrate fpga", "--output"): ["calibrate", "fpga", "--report", "board.yaml", "-o"],
}
ENDINGS = {"--picture": ".png", "--output": ".svg"}


def walked(command: click.Command, name: str = "") -> Iterator[tuple[str, click.Command]]:
    if isinstance(command, click.Group):
        context = click.Context(command)
        for each in command.list_commands(context):
            inner = command.get_command(context, each)
            assert inner is not None
            yield from walked(inner, f"{name} {each}".strip())
    else:
        yield name, command


def test_every_option_that_names_a_file_to_write_is_checked() -> None:
    named = set()
    for name, command in walked(main):
        for each in command.params:
            if isinstance(each.type, click.Path) and not each.type.exists:
                long = max(each.opts, key=len)
                named.add((name, long if isinstance(each, click.Option) else (each.human_readable_name)))
    assert named - {("map", "FILE")} == {*WRITERS, *CHECKED_ELSEWHERE}


@pytest.mark.parametrize("writer", WRITERS, ids=" ".join)
def test_a_file_of_another_kind_stays(hwsw: Run, specs: tuple[Path, Path], writer: tuple[str, str]) -> None:
    folder, (command, option) = specs[0].parent, writer
    for name in ("old.sqlite", "old.mcap"):
        (folder / name).write_bytes(b"read later than outputs are checked")
    ending = ".yaml" if command.startswith("calibrate") else ENDINGS.get(option, ".out")
    path = folder / f"mine{ending}"
    for what, content in FOREIGN.items():
        path.write_bytes(content)
        result = hwsw(*WRITERS[writer], path.name)
        assert (what, result.exit_code) == (what, 2), result.output
        assert "would replace a file that is not" in result.stderr
        assert "--force" in result.stderr
        assert path.read_bytes() == content


def test_what_a_command_wrote_is_replaced_by_the_same_command(hwsw: Run, specs: tuple[Path, Path]) -> None:
    folder = specs[0].parent
    store = folder / "small-board-two-rooms.sqlite"
    words: list[list[Any]] = [
        ["explore", *specs, "--workers", 1, "--csv", "a.csv", "--html", "a.html", "--certify", "a.front"],
        ["report", store, "--csv", "a.csv", "--html", "a.html", "--certify", "a.front"],
        ["run", *specs, "--trace", "a.mcap", "--html", "a.html"],
        ["trace", "export", "a.mcap", "--perfetto", "a.pftrace", "--vcd", "a.vcd", "--html", "a.html"],
        ["trace", "export", "a.mcap", "--poses", "poses.csv"],
        ["trace", "layout", "a.mcap"],
        ["plot", "timeline", "a.mcap", "-o", "a.svg"],
        ["plot", "timeline", "a.mcap", "-o", "a.pdf"],
        ["map", "house", "--png", "a.png"],
    ]
    for each in words:
        for _ in range(2):
            result = hwsw(*each)
            assert result.exit_code == 0, (each, result.output)


def test_force_replaces_what_is_there(hwsw: Run, specs: tuple[Path, Path]) -> None:
    path = specs[0].parent / "mine.png"
    path.write_bytes(b"dear diary\n")
    assert hwsw("map", "house", "--png", path).exit_code == 2
    assert hwsw("map", "house", "--png", path, "--force").exit_code == 0
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_result_beside_a_trace_is_no_layout(hwsw: Run, specs: tuple[Path, Path]) -> None:
    folder = specs[0].parent
    assert hwsw("run", *specs, "--trace", "run.mcap").exit_code == 0
    result = hwsw("run", *specs, "--json").stdout
    (folder / "run.json").write_text(result)
    assert hwsw("trace", "layout", "run.mcap").exit_code == 2
    assert (folder / "run.json").read_text() == result


@given(kind=st.sampled_from(sorted(KINDS)), content=st.binary(min_size=1) | st.text(min_size=1).map(str.encode))
def test_nothing_drawn_at_random_is_taken_for_an_output(tmp_path: Path, kind: str, content: bytes) -> None:
    path = tmp_path / "drawn"
    path.write_bytes(content)
    if not content.startswith(KINDS[kind].begins):
        with pytest.raises(InputError):
            check_replaceable("--csv", path, kind)
    path.write_bytes(b"")
    check_replaceable("--csv", path, kind)


def test_a_folder_of_plots_or_of_a_winner_keeps_what_is_there(
    hwsw: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("codesign.study.advice.advise", lambda *_, **__: pytest.fail("the search was begun"))
    (tmp_path / "plots").mkdir()
    for name in ("mine.svg", "zynq.yaml"):
        (tmp_path / "plots" / name).write_text("dear diary\n")
    asked = ("--goal", "133,144", "--rate", "10Hz", "--boards", "zynq", "--write", "plots")
    for words in (("reproduce", "--quick", "--plots", "plots"), ("advise", "house", *asked)):
        result = hwsw(*words)
        assert result.exit_code == 2
        assert "would replace" in result.stderr


def test_what_a_table_needs_is_asked_for_before_anything_is_computed(
    hwsw: Run, specs: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = builtins.__import__

    def without(name: str, *more: Any) -> Any:
        if name.partition(".")[0] == "pyarrow":
            raise ImportError(name)
        return real(name, *more)

    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.setattr("codesign.explore", lambda *_, **__: pytest.fail("the exploration was begun"))
    result = hwsw("explore", *specs, "--parquet", "points.parquet")
    assert result.exit_code == 2
    assert "needs pyarrow" in result.stderr
