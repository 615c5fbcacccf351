"""The page on maps and the docstrings say what the code does."""

from __future__ import annotations

import ast
import doctest
import importlib
import re

import pytest
from places import ROOT

from codesign import maps

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


@pytest.mark.parametrize("module", ["generate", "reach", "text"])
def test_docstring_examples(module: str) -> None:
    results = doctest.testmod(importlib.import_module(f"codesign.maps.{module}"))
    assert results.attempted > 0
    assert results.failed == 0
