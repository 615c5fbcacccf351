"""Requests: keyword arguments of Python are their fields, and a platform is named in one way everywhere."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import pytest
from click.testing import Result

import codesign
from codesign.cli.request import ANSWER, SENTENCE, Request, fields_of
from codesign.cli.requests import COMMANDS, Explain, Explore, Report, Run, VerifyFront
from codesign.ground.records import Level

Runs = Callable[..., Result]

OTHERWISE: dict[str, dict[str, str]] = {
    "simulate": {
        "platform": "specs",
        "workload": "specs",
        "listeners": "objects of Python, as --trace is",
        "keeping": "goes with listeners",
        "progress": "a function, in place of a bar",
        "lever_progress": "a function, in place of a bar",
        "levers": "runs of levers take long: in Python they are asked for",
    },
    "explain": {"platform": "what", "workload": "which", "show": "a function, in place of a bar"},
    "explore": {
        "platform": "specs",
        "workload": "specs",
        "executor": "an object of Python, as --cluster is",
        "budget": "an object of Python, as --points and --time are",
        "progress": "a function, in place of a bar",
        "workers": "a program has other uses for the cores",
    },
}
"""The keyword arguments that are no option of the same default, with the reason."""


def kinds(annotation: Any) -> set[Any]:
    """The members of a type; a choice of texts is a text."""
    members = get_args(annotation) if type(None) in get_args(annotation) else (annotation,)
    return {str if get_origin(each) is Literal else get_origin(each) or each for each in members} - {type(None)}


@pytest.mark.parametrize(
    ("asked", "request_of"), [(codesign.simulate, Run), (codesign.explain, Explain), (codesign.explore, Explore)]
)
def test_a_keyword_argument_is_a_field_of_the_request(asked: Callable[..., Any], request_of: type[Request]) -> None:
    fields, exceptions = fields_of(request_of), OTHERWISE[asked.__name__]
    parameters = inspect.signature(asked).parameters
    assert exceptions.keys() <= parameters.keys()
    for name, parameter in parameters.items():
        if name not in exceptions:
            kind, option = fields[name]
            written = eval(str(parameter.annotation), {"Path": Path, "Mapping": Mapping, "Any": Any})
            assert kinds(kind) <= kinds(written), name
            # None and nothing are one.
            assert (parameter.default or None) == (option.default_of(kind) or None), name


def test_the_levels_of_a_trace_are_those_of_its_records() -> None:
    assert get_args(fields_of(Run)["trace_level"][0]) == tuple(Level)


def test_a_request_has_the_defaults_of_its_fields() -> None:
    asked = Report(store=Path("a.sqlite"), detail=SENTENCE)
    assert (asked.csv, asked.as_json, asked.needs, asked.quiet) == (None, False, (), True)
    assert not VerifyFront(file=Path("a")).quiet
    assert VerifyFront(file=Path("a")).detail == ANSWER


@pytest.mark.parametrize("name", [name for name, command in COMMANDS.items() if command.does])
def test_all_that_a_command_needs_is_said(name: str) -> None:
    # A field without a default is a required option or argument, or any number of arguments.
    fields = fields_of(COMMANDS[name].request)
    for each, (kind, field) in fields.items():
        required = [parameter.required for parameter in field.parameters(each, kind)]
        assert any(required) == (field.default_of(kind) is ...), each


HOUSE = ("house", "--goal", "133,144", "--rate", "20Hz")


@pytest.mark.parametrize(
    "words",
    [
        ("run", "{}", "labyrinth"),
        ("explore", "{}", "labyrinth"),
        ("explore", "labyrinth", "--set", "platform={}"),
        ("explore", "labyrinth", "--axis", "platform={}"),
        ("compare", "{}:labyrinth"),
        ("explain", "{}", "labyrinth"),
        ("advise", *HOUSE, "--boards", "{}"),
        ("init", "mine", "--board", "{}"),
        ("plot", "timeline", "{}", "labyrinth", "-o", "a.svg"),
        ("rtl", "{}", "labyrinth", "-o", "circuit"),
        ("verify", "{}", "labyrinth"),
        ("synth", "{}", "labyrinth"),
        ("calibrate", "fpga", "{}", "labyrinth", "--report", "a.rpt"),
        ("explore", "many.yaml"),
    ],
    ids=" ".join,
)
@pytest.mark.parametrize(
    ("platform", "fault"),
    [
        ("zynk", "there is no shipped platform 'zynk'\n  hint: did you mean zynq?"),
        ("labyrinth", "labyrinth is a workload, and a platform is asked for\n  hint: are the two files swapped?"),
    ],
)
def test_a_platform_that_is_none_is_refused_in_the_same_words(
    hwsw: Runs, tmp_path: Path, words: tuple[str, ...], platform: str, fault: str
) -> None:
    (tmp_path / "a.rpt").touch()
    shipped = Path(codesign.__file__).parents[1] / "workloads/labyrinth.yaml"
    head = shipped.read_text(encoding="utf-8").partition("\nexplore:")[0]
    many = f"{head}\nexplore:\n  axes: {{platform: [{platform}]}}\n  objectives: [cycles]\n"
    (tmp_path / "many.yaml").write_text(many, encoding="utf-8")
    done = hwsw(*(word.format(platform) for word in words))
    assert done.exit_code == 2, done.output
    assert fault in done.output


@pytest.mark.parametrize("value", ["3", "{a: 1}", "[3]"])
@pytest.mark.parametrize("option", ["--set", "--axis"])
def test_what_is_no_name_names_no_platform(hwsw: Runs, option: str, value: str) -> None:
    done = hwsw("explore", "labyrinth", option, f"platform={value}")
    assert done.exit_code == 2
    assert "names no platform\n  hint: write the name of a shipped platform, or a file" in done.output


def test_a_first_platform_is_made_of_a_file(hwsw: Runs, tmp_path: Path) -> None:
    shipped = Path(codesign.__file__).parents[1] / "platforms"
    board = (shipped / "arty-a7.yaml").read_text(encoding="utf-8")
    (tmp_path / "board.yaml").write_text(board, encoding="utf-8")
    assert hwsw("init", "named", "--board", "arty-a7").exit_code == 0
    assert hwsw("init", "filed", "--board", "./board.yaml").exit_code == 0
    for name in ("my-platform.yaml", "my-workload.yaml"):
        assert (tmp_path / "filed" / name).read_bytes() == (tmp_path / "named" / name).read_bytes()
    # A part that stands beside the board is not found beside the new file.
    (tmp_path / "parts").mkdir()
    part = (shipped / "parts/XC7A35T.yaml").read_text(encoding="utf-8").replace("name: XC7A35T", "name: MINE")
    (tmp_path / "parts/MINE.yaml").write_text(part, encoding="utf-8")
    (tmp_path / "board.yaml").write_text(board.replace("XC7A35T-1", "MINE-1"), encoding="utf-8")
    done = hwsw("init", "again", "--board", "./board.yaml")
    assert done.exit_code == 2
    assert "components.fpga.part: there is no part 'MINE'" in done.output
    assert not (tmp_path / "again").exists()
