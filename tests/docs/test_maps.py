"""The page on maps and the docstrings say what the code does."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from pathlib import Path

import yaml
from click.testing import Result
from places import ROOT

from codesign import maps
from codesign.inputs.document import Document
from codesign.inputs.faults import validate
from codesign.inputs.map_spec import FileMap
from codesign.inputs.problem import ProblemSpec

PAGE = ROOT / "docs" / "maps.md"
PICTURE = re.compile(r"^    (\w+): (.*)\n((?:    [.#]+\n)+)", re.MULTILINE)


def test_the_pictures_are_what_the_generators_draw() -> None:
    pictures = PICTURE.findall(PAGE.read_text(encoding="utf-8"))
    assert {kind for kind, _, _ in pictures} == set(maps.GENERATORS) - {"empty"}
    for kind, arguments, picture in pictures:
        call = ast.parse(f"f({arguments})", mode="eval").body
        assert isinstance(call, ast.Call)
        parameters = {str(each.arg): ast.literal_eval(each.value) for each in call.keywords}
        assert maps.to_text(maps.generate(kind, **parameters)).split() == picture.split()


def test_hwsw_map_prints_what_the_page_shows(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    text = PAGE.read_text(encoding="utf-8")
    (drawn,) = re.findall(r"```text\n(.*?)```", text, re.DOTALL)
    (tmp_path / "floor.txt").write_text(drawn, encoding="utf-8")
    (command, output) = re.findall(r"```console\n\$ hwsw (.*?)\n(.*?)```", text, re.DOTALL)[0]
    assert hwsw(*command.split()).stdout == output


def test_the_example_of_steps_loads(tmp_path: Path) -> None:
    text = PAGE.read_text(encoding="utf-8")
    (example,) = re.findall(r"^    problem:\n(?:      .*\n)+", text, re.MULTILINE)
    tree = yaml.safe_load(example)["problem"]
    (tmp_path / "floor.yaml").touch()
    problem = validate(ProblemSpec, Document("page", tmp_path, tree))
    assert isinstance(problem.map, FileMap)
    assert (str(problem.map.inflate), problem.map.downsample, problem.map.crop) == ("0.3 m", 2, "free")
