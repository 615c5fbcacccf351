"""docs/findings.md: a full run of every paper bears its statements out, and has measured its numbers."""

from __future__ import annotations

import re

import pytest
from findings_page import check_figures, check_statements
from places import ROOT

from codesign.planners.reproduction import Finding, Reproduction
from codesign.system import catalog


@pytest.mark.slow
@pytest.mark.parametrize("planner", catalog.papers())
def test_a_full_run_bears_the_page_out(planner: str) -> None:
    reproduction = catalog.papers()[planner](quick=False)
    check_statements(reproduction)
    check_figures(reproduction)


def sample(**changed: str) -> Reproduction:
    """A run of one finding of the page, with figures changed."""
    page = (ROOT / "docs" / "findings.md").read_text(encoding="utf-8")
    (paper,) = re.findall(r"^## (Girau.*)$", page, re.M)
    figures = {"residual": "0.003 ns", "miss": "+11%"} | changed
    finding = Finding("The clock law misses the one clock that it has not seen.", figures)
    return Reproduction(paper, (), (), (finding,))


def test_the_check_finds_a_number_that_differs() -> None:
    check_figures(sample())
    with pytest.raises(AssertionError, match=r"miss: \+12% is not on the page\n.*11 is not measured"):
        check_figures(sample(miss="+12%"))


def test_the_check_finds_a_statement_that_fails() -> None:
    good = sample()
    bad = Finding(good.findings[0].statement, good.findings[0].figures, holds=False)
    with pytest.raises(AssertionError, match="does not hold"):
        check_figures(Reproduction(good.paper, (), (), (bad,)))


def test_the_check_finds_a_statement_that_is_not_there() -> None:
    with pytest.raises(AssertionError):
        check_statements(sample())
