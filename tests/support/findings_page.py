"""docs/findings.md against a run: every statement is checked, and every number is measured or stands in the paper."""

from __future__ import annotations

import re
from collections.abc import Collection

from places import ROOT

from codesign.planners.reproduction import Finding, Reproduction

NUMBER = re.compile(r"\d[\d,]*(?:\.\d+)?")

GIVEN = {
    "Girau": "1 2 3 4 5 6 4.4 4.5 8 16 20 32 64 100 128 255 270 400 9,500",
    "Vacariu": "1 2 3 10 25 40 41 50 100",
    "Möller": "1 2 2.5 3 4 5 7 8 24 26.6 32 63 68 255 256",
    "Dubey": "2 3 4 6 8 16 20 36 115,200",
    "Saudi": "0 0.05 1 2 15 18 1.95 1.975 1.99",
}
"""By first author, numbers on the page that no run measures: those of the paper, and those that explain them."""


def items(paper: str) -> dict[str, str]:
    """The text of each item of the paper's section, statement included, by its statement."""
    page = (ROOT / "docs" / "findings.md").read_text(encoding="utf-8")
    section = page.split(f"## {paper}\n")[1].split("\n## ")[0]
    texts = [" ".join(each.split()) for each in re.findall(r"^- (.*?)(?=^- |^\S|\Z)", section, re.M | re.S)]
    return {re.findall(r"\*\*(.+?)\*\*", text)[0]: text for text in texts}


def check_statements(reproduction: Reproduction, left_out: Collection[str] = ()) -> None:
    """Every statement of the run is on the page, and the reverse but for those that a quick run leaves out."""
    assert {each.statement for each in reproduction.findings} == set(items(reproduction.paper)) - set(left_out)


def check_figures(reproduction: Reproduction, beginnings: Collection[str] = ("",)) -> None:
    """Every statement holds, has all of its figures on the page, and no number beside them.

    ``beginnings``: how the statements begin that are checked; a quick run shares the figures of some with the full one.
    """
    page, author = items(reproduction.paper), reproduction.paper.split(",")[0]
    faults = []
    for finding in reproduction.findings:
        if finding.statement.startswith(tuple(beginnings)):
            faults += [f"{finding.statement} {fault}" for fault in _faults(finding, page, GIVEN[author])]
    assert not faults, "\n".join(faults)
    for beginning in beginnings:
        assert any(each.statement.startswith(beginning) for each in reproduction.findings), beginning


def figures(reproduction: Reproduction, beginning: str) -> dict[str, str]:
    """The measured figures of the statement that begins so."""
    (finding,) = (each for each in reproduction.findings if each.statement.startswith(beginning))
    return finding.figures


def _faults(finding: Finding, page: dict[str, str], given: str) -> list[str]:
    text = page[finding.statement]
    faults = [] if finding.holds else ["does not hold"]
    for name, measured in finding.figures.items():
        if not re.search(rf"(?<![\d.,]){re.escape(measured)}(?!\d|[.,]\d)", text):
            faults.append(f"{name}: {measured} is not on the page")
    measured_numbers = NUMBER.findall(" ".join([*finding.figures, *finding.figures.values(), finding.statement]))
    unknown = set(map(_plain, NUMBER.findall(text))) - set(map(_plain, [*measured_numbers, *given.split()]))
    return [*faults, *(f"{number} is not measured" for number in sorted(unknown))]


def _plain(number: str) -> str:
    return number.rstrip(",")
