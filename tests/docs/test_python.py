"""The examples of docs/python.md are run."""

from __future__ import annotations

import doctest

import pytest
from places import ROOT


def test_the_examples_of_the_page() -> None:
    pytest.importorskip("pandas")
    run = doctest.testfile(str(ROOT / "docs" / "python.md"), module_relative=False)
    assert run.attempted > 10
    assert run.failed == 0
