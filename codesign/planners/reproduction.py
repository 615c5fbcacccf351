"""The parts of a reproduction: rows, plots and findings."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from functools import cache
from pathlib import Path
from typing import Any, Literal

from pydantic import TypeAdapter

from codesign.ground.errors import clip
from codesign.ground.figures import Status
from codesign.ground.files import date_of_writing
from codesign.ground.models import SpecModel
from codesign.ground.notebooks import InNotebooks
from codesign.ground.units import counted
from codesign.version import __version__

SCHEMA_VERSION = 1

Progress = Callable[[str], None]
"""Called with a line that names the next part of the work."""


def silent(_line: str) -> None:
    """A ``Progress`` that shows nothing."""


class Use(StrEnum):
    """The use of a figure of a paper before the model was compared with it."""

    FITTED = "fitted"
    """A law was fitted to it, or a map was chosen by it."""
    HELD_OUT = "held out"
    """No law was made from it."""
    KNOWN = "known when chosen"
    """Nothing was fitted to it, but a rule or an assumption was chosen in view of it."""
    NOTHING = "nothing to hold out"
    """The paper gives no figure."""


@dataclass(frozen=True)
class Row:
    """One figure of a paper beside the model's figure.

    Attributes:
        table: table, figure or section of the paper.
        quantity: the quantity that is counted, timed or stated.
        published, modelled: in ``unit``; text for a bound or a sentence; the value of a formula where the paper gives
            one; None where the paper gives nothing.
        error: (modelled - published) / published; None where one of them is no number.
        unit: Hz, s, %, "1" for a count or a ratio, or a word.
        status: the status of the modelled figure. source: its law or its run.
        use: the use of the published figure before the comparison.
        note: a remark on the row.
    """

    table: str
    quantity: str
    published: float | str | None
    modelled: float | str | None
    error: float | None
    unit: str
    status: Status
    source: str
    use: Use
    note: str = ""


def row(
    table: str,
    quantity: str,
    published: float | str | None,
    modelled: float | str | None,
    *,
    status: Status,
    source: str,
    unit: str = "1",
    use: Use = Use.HELD_OUT,
    note: str = "",
) -> Row:
    """A row with its relative error, where both sides are numbers.

    Every row gives ``use``, but for estimates of a paper that nothing was made from.

    Raises:
        ValueError: ``use`` needs a published figure and there is none, or the reverse.

    >>> row("Table 2", "slices", 235, 234, status=Status.PUBLISHED, source="13 a node", use=Use.HELD_OUT).error
    -0.00425531914893617
    """
    missing, number = published is None, isinstance(published, int | float)
    if (missing and use is not Use.NOTHING) or (number and use is Use.NOTHING):
        raise ValueError(f"{table}, {quantity}: {use} with {published} published")
    error = None
    if isinstance(published, int | float) and isinstance(modelled, int | float) and published:
        error = (modelled - published) / published
    return Row(table, quantity, published, modelled, error, unit, status, source, use, note)


class Settings(SpecModel):
    """The settings of a paper's runs that a reader may move; each room derives its own. None: as published."""

    def moved(self) -> dict[str, Any]:
        """Those that were given, by name."""
        return {name: value for name, value in self if value is not None}


@dataclass(frozen=True)
class Printed:
    """The numbers that laws take from a paper: how it is cited, figures by name, tables as rows by column."""

    cited: str
    figures: Mapping[str, Any]
    tables: Mapping[str, Sequence[Mapping[str, Any]]]


@cache
def printed_numbers(path: Path) -> Printed:
    """The numbers of a ``published.json``; laws read them where they are imported, so they are JSON and not YAML."""
    tree = json.loads(path.read_text(encoding="utf-8"))
    figures = {name: figure["value"] for name, figure in tree["figures"].items()}
    tables = {
        name: [dict(zip(table["columns"], row, strict=True)) for row in table["rows"]]
        for name, table in tree["tables"].items()
    }
    return Printed(tree["cited"], figures, tables)


@dataclass(frozen=True)
class Series:
    """One curve: its name in the legend and its points."""

    name: str
    x: tuple[float, ...]
    y: tuple[float, ...]


@dataclass(frozen=True)
class Plot:
    """A figure of the paper, drawn again from own data.

    ``name`` is a file name without suffix. ``published`` describes the figure of the paper.
    """

    name: str
    title: str
    published: str
    x_label: str
    y_label: str
    series: tuple[Series, ...]
    x_scale: Literal["linear", "log"] = "linear"
    y_scale: Literal["linear", "log"] = "linear"


@dataclass(frozen=True)
class Finding:
    """A statement about a paper, written by a person, and the figures of a run that it rests on.

    Attributes:
        statement: one sentence without a computed figure; ``docs/findings.md`` has it too.
        figures: measured figures by name, each with its unit.
        holds: whether this run confirms the statement.
    """

    statement: str
    figures: dict[str, str]
    holds: bool = True


@dataclass(frozen=True, repr=False)
class Reproduction(InNotebooks):
    """A paper beside the model: rows in the order of the paper, plots, and statements that the run checks.

    ``note`` names the parts that a quick run leaves out. ``settings`` names those that are not the published ones.
    """

    paper: str
    rows: tuple[Row, ...]
    figures: tuple[Plot, ...]
    findings: tuple[Finding, ...]
    note: str = ""
    settings: str = ""

    def __repr__(self) -> str:
        rows, findings = counted(len(self.rows), "row"), counted(len(self.findings), "finding")
        return f"Reproduction({clip(self.paper)!r}: {rows}, {findings})"

    def with_settings(self, settings: Settings) -> Reproduction:
        """The same, where head and rows say which settings are not the published ones."""
        moved = ", ".join(f"{name}={_setting_text(value)}" for name, value in settings.moved().items())
        if not moved:
            return self
        rows = tuple(
            replace(each, note="; ".join(filter(None, (each.note, f"not as published: {moved}")))) for each in self.rows
        )
        return replace(self, rows=rows, settings=moved)

    def to_json(self) -> str:
        """Everything as one JSON object, as ``reproduction_schema`` describes it."""
        head = {"schema_version": SCHEMA_VERSION, "codesign": __version__, "date": date_of_writing()}
        return json.dumps(head | asdict(self), indent=2, ensure_ascii=False)


def _setting_text(value: Any) -> str:
    return f"[{', '.join(map(str, value))}]" if isinstance(value, tuple) else str(value)


def reproduction_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of what ``hwsw reproduce --json`` prints."""
    schema = TypeAdapter(Reproduction).json_schema(mode="serialization")
    for described in (schema, *schema["$defs"].values()):
        if described["type"] == "object":
            described |= {"additionalProperties": False, "required": list(described["properties"])}
    version = {"const": SCHEMA_VERSION, "type": "integer"}
    head = {
        "schema_version": version,
        "codesign": {"type": "string", "description": "version of hwsw"},
        "date": {"type": "string", "description": "the day on which it was written, UTC, or of SOURCE_DATE_EPOCH"},
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "properties": head | schema["properties"],
        "required": [*head, *schema["required"]],
    }


def joined(reproductions: Sequence[Reproduction]) -> Reproduction:
    """Several papers as one: rows and findings name their paper.

    Raises:
        ValueError: there is no reproduction.
    """
    if not reproductions:
        raise ValueError("no reproduction to join")
    if len(reproductions) == 1:
        return reproductions[0]
    rows = tuple(
        replace(row, table=f"{short_name(each.paper)}, {row.table}") for each in reproductions for row in each.rows
    )
    figures = tuple(figure for each in reproductions for figure in each.figures)
    findings = tuple(
        replace(finding, statement=f"{short_name(each.paper)}: {finding.statement}")
        for each in reproductions
        for finding in each.findings
    )
    papers = "; ".join(short_name(each.paper) for each in reproductions)
    notes = "; ".join(f"{short_name(each.paper)}: {each.note}" for each in reproductions if each.note)
    moved = "; ".join(f"{short_name(each.paper)}: {each.settings}" for each in reproductions if each.settings)
    return Reproduction(papers, rows, figures, findings, notes, moved)


def short_name(paper: str) -> str:
    """First author and year.

    >>> short_name("Vacariu, Roman, Timar 2008, Mobile robot path-planning in software and hardware")
    'Vacariu 2008'
    """
    year = re.search(r"\b(?:19|20)\d\d\b", paper)
    author = re.match(r"\w+", paper)
    return " ".join(match.group() for match in (author, year) if match)
