"""What docs and code say of RTL holds for this repository: a circuit, a synthesis or a placement is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from levels import ROOMS
from places import ROOT

from codesign.planners.measured import clock_rows, resource_rows
from codesign.system import catalog

REFUSED = re.compile(r"\b(?:our own|own|our) RTL\b|\bRTL of (?:ours|our own)\b", re.IGNORECASE)
"""RTL that a reader cannot find."""

CLAIM = re.compile(r"RTL of this package", re.IGNORECASE)
PLACED = re.compile(r"\bplaced\b|nextpnr|routed", re.IGNORECASE)
COUNTED = re.compile(r"synthe|yosys|\bLUT\b|\bcounted from\b", re.IGNORECASE)

PAGES = {"laws.md": "harmonic", **{f"{room}.md": room for room in ROOMS}}
"""The pages about one planner."""

FILES = sorted(
    path
    for folder, patterns in (("docs", ("*.md",)), ("codesign", ("*.py", "*.v")), ("platforms", ("*.yaml",)))
    for pattern in patterns
    for path in (ROOT / folder).rglob(pattern)
)


def room_of(path: Path) -> str | None:
    """The planner that a page or a module is about."""
    if path.parent == ROOT / "docs":
        return PAGES.get(path.name)
    parts = path.relative_to(ROOT).parts
    return parts[2] if parts[:2] == ("codesign", "planners") and parts[2] in ROOMS else None


def unfounded(room: str, line: str) -> list[str]:
    """What a line about the RTL of a room claims, and the repository does not hold."""
    if re.search(r"\bnot of the RTL of this package", line):
        return []
    circuits = [key for key in catalog.circuits() if key[0] == room]
    missing = [] if circuits and list(ROOT.glob(f"codesign/planners/{room}/rtl/*.v")) else ["a circuit"]
    if COUNTED.search(line) and not any(resource_rows(*key) for key in circuits):
        missing.append("a row of synthesis")
    if PLACED.search(line) and not any(clock_rows(*key) for key in circuits):
        missing.append("a row of placement")
    return missing


def test_no_text_rests_on_rtl_that_is_not_here() -> None:
    lines = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in FILES
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if REFUSED.search(line)
    ]
    assert not lines, "say 'RTL of this package', and only of what is here:\n" + "\n".join(lines)


def test_what_a_room_says_of_its_rtl_is_in_the_repository() -> None:
    wrong = [
        f"{path.relative_to(ROOT)}:{number}: no {' and no '.join(missing)} of {room}"
        for path in FILES
        if (room := room_of(path)) is not None
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if CLAIM.search(line)
        if (missing := unfounded(room, line))
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("room", "line", "missing"),
    [
        ("breadth_first", "2 a cell of the path | measured: RTL of this package", []),
        ("breadth_first", "synthesis of the RTL of this package", []),
        ("relaxation", "RTL of this package", ["a circuit"]),
        ("relaxation", "RTL of this package, Yosys", ["a circuit", "a row of synthesis"]),
        ("relaxation", "an earlier synthesis, not of the RTL of this package", []),
    ],
)
def test_the_check_finds_a_claim_without_a_row(room: str, line: str, missing: list[str]) -> None:
    assert unfounded(room, line) == missing


@pytest.mark.parametrize("text", ["measured on own RTL", "our RTL, Yosys", "Our own RTL says", "RTL of ours"])
def test_the_check_finds_rtl_that_is_not_here(text: str) -> None:
    assert REFUSED.search(text)
