"""A paper is data: ``rows.yaml`` says what it printed and what computes the same, and one engine walks over it.

A sheet has the rows of the paper, the findings about it and its plots, and numbers and tables that no law needs.
``published.json`` of the room has the others. Each row, finding and plot names a measure: a function in Python that
computes the figure in a run. A text of a sheet may name numbers in braces, as ``str.format`` takes them: numbers of the
paper, columns of the table that the row is of, and words that the measure found. A text that is one name in braces is
the value itself.

``hwsw reproduce`` compares the rows with the model. ``hwsw fidelity`` compares those with a ``circuit`` with Verilog.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from operator import itemgetter
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Generic, Literal, Self, TypeVar

from more_itertools import map_reduce
from pydantic import Field, model_validator

from codesign.ground.errors import InputError, choose_hint
from codesign.ground.figures import Status
from codesign.ground.models import RefusalError, SpecModel
from codesign.inputs.faults import validate
from codesign.inputs.files import shown
from codesign.inputs.yaml_tree import read_document
from codesign.planners.reproduction import (
    Finding,
    Plot,
    Printed,
    Progress,
    Reproduction,
    Row,
    Series,
    Settings,
    Use,
    row,
    silent,
)

Words = dict[str, Any]
"""Figures and words of a measure by name, for a row and for the texts that name them."""

Scalar = bool | int | float | str | None
S = TypeVar("S", bound=Settings)
F = TypeVar("F", bound=Callable[..., Any])

_ALONE = re.compile(r"\{(\w+)\}")


class Table(SpecModel):
    """A table of the paper, as printed: the names of its columns, and its rows."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Scalar, ...], ...]

    @model_validator(mode="after")
    def _full_rows(self) -> Self:
        for number, each in enumerate(self.rows):
            if len(each) != len(self.columns):
                what = f"{len(each)} values for {len(self.columns)} columns"
                raise RefusalError(what, f"write {', '.join(self.columns)}", ("rows", number))
        return self

    @property
    def records(self) -> list[dict[str, Any]]:
        """Each row by the names of the columns."""
        return [dict(zip(self.columns, each, strict=True)) for each in self.rows]


class Common(SpecModel):
    """The keys that a row says itself, or its part for all of its rows.

    - ``place``: table, figure or section. ``unit``: of the row, as in ``Row``. ``measure``: what computes the figure.
    - ``status``, ``use``, ``source``, ``note``: as in ``Row``. ``map``: what it is computed on, for texts that name it.
    """

    place: str | None = None
    unit: str | None = None
    measure: str | None = None
    status: str | None = None
    use: str | None = None
    source: str | None = None
    note: str | None = None
    map: str | None = None


class Counted(SpecModel):
    """The keys of a row that fidelity compares: the ``name`` that reasons have, and the ``measure`` of the circuit.

    ``what``, ``unit``, ``place``: given if they differ from the row's. ``over``: as in ``Entry``.
    """

    name: str
    measure: str
    what: str | None = None
    unit: str | None = None
    place: str | None = None
    over: int | float = 1


class Entry(Common):
    """A row of the paper.

    - ``what``: the quantity. ``published``: as printed, or words; absent where the paper gives nothing.
    - ``over``: the printed figure is divided by it to come to ``unit``. ``gives``: its name in the measure.
    - ``of``: constants that the measure is given. ``circuit``: how circuits have the same figure.
    """

    what: str
    published: int | float | str | None = None
    over: int | float = 1
    gives: str = "value"
    of: dict[str, Scalar] = Field(default_factory=dict)
    circuit: Counted | None = None


class Part(Common):
    """Rows with something in common. ``each``: a table, or a measure that lists cases; the rows are of each of them."""

    each: str | None = None
    rows: tuple[Entry, ...]

    @model_validator(mode="after")
    def _whole_rows(self) -> Self:
        for number, entry in enumerate(self.entries):
            needed = ("place", "measure", "status", "use", "source") if entry.measure else ("place", "circuit")
            for name in needed:
                if getattr(entry, name) is None:
                    raise RefusalError(f"there is no {name}", f"write {name}: here or of the part", ("rows", number))
        return self

    @cached_property
    def entries(self) -> list[Entry]:
        """The rows with what the part says for all of them."""
        common = {name: getattr(self, name) for name in Common.model_fields}
        return [
            entry.model_copy(update={name: value for name, value in common.items() if getattr(entry, name) is None})
            for entry in self.rows
        ]


class Statement(SpecModel):
    """A finding: the sentence, the measure, and the texts of its figures, each with its unit, by name.

    The measure says by ``holds`` whether the run confirms it, and by ``figures`` those that depend on the run.
    """

    says: str
    measure: str
    figures: dict[str, str] = Field(default_factory=dict)


class Drawing(SpecModel):
    """A plot; the measure gives its curves. The other fields are as in ``Plot``."""

    name: str
    title: str
    published: str
    x_label: str
    y_label: str
    measure: str
    x_scale: Literal["linear", "log"] = "linear"
    y_scale: Literal["linear", "log"] = "linear"


class Sheet(SpecModel):
    """A paper: its full name; what a quick run leaves out; numbers and tables beside those that laws use; its rows."""

    paper: str
    quick: str
    figures: dict[str, int | float | str] = Field(default_factory=dict)
    tables: dict[str, Table] = Field(default_factory=dict)
    parts: tuple[Part, ...]
    findings: tuple[Statement, ...] = ()
    plots: tuple[Drawing, ...] = ()

    def published(self, place: str) -> dict[str, Any]:
        """The figures of the rows at a place that are numbers, by quantity."""
        entries = (entry for part in self.parts for entry in part.entries)
        return {each.what: each.published for each in entries if each.place == place}


@cache
def read_sheet(path: Path) -> Sheet:
    """The sheet in a file.

    Raises:
        SpecError: all faults of the file, each with its place.
    """
    return validate(Sheet, read_document(path, shown(path)))


@dataclass
class Runs(Generic[S]):
    """The data that the measures of one run share; each room derives its own. ``rows``: all, when findings are made."""

    quick: bool
    progress: Progress
    settings: S
    rows: tuple[Row, ...] = ()


class Case(SimpleNamespace):
    """The input of a measure: numbers of the paper, columns of the table, constants of the row."""


class Paper:
    """A sheet with its measures; called, it compares the model with the paper.

    Args:
        path: ``rows.yaml``.
        printed: the numbers that laws use.
        runs: makes what the measures of a run share.
        settings: the settings of a run; by default as published.
    """

    def __init__(self, path: Path, printed: Printed, runs: type[Runs[Any]], settings: type[Settings]) -> None:
        self.path, self.printed, self.runs, self.settings = path, printed, runs, settings
        self.measures: dict[str, Callable[..., Any]] = {}

    @property
    def sheet(self) -> Sheet:
        """The sheet that is compared."""
        return read_sheet(self.path)

    @cached_property
    def figures(self) -> dict[str, Any]:
        """All numbers of the paper by name."""
        return {**self.printed.figures, **self.sheet.figures}

    @cached_property
    def tables(self) -> dict[str, Any]:
        """The rows of all tables of the paper, each by the names of the columns."""
        return {**self.printed.tables, **{name: table.records for name, table in self.sheet.tables.items()}}

    def measure(self, function: F) -> F:
        """Let rows, findings and plots name a function; it is called with the runs and a ``Case``.

        A measure of rows and findings returns a figure, or several with words for texts, by name; of a plot its curves,
        and of the cases of a part a mapping for each. None: this run does not have it.
        """
        self.measures[function.__name__] = function
        return function

    def __call__(self, quick: bool = False, progress: Progress = silent, settings: Any = None) -> Reproduction:
        """Every row of the paper that the model can be compared with, with plots and findings.

        Args:
            quick: fewer and smaller maps: seconds instead of a minute or two.
            progress: called with a line for each part of the work.
            settings: of the runs; by default as published.
        """
        sheet, runs = self.sheet, self.runs(quick, progress, settings or self.settings())
        runs.rows = tuple(self.rows(runs))
        return Reproduction(
            paper=sheet.paper,
            rows=runs.rows,
            figures=tuple(self.plots(runs)),
            findings=tuple(self.findings(runs)),
            note=sheet.quick if quick else "",
        ).with_settings(runs.settings)

    def rows(self, runs: Any, places: Collection[str] | None = None) -> Iterator[Row]:
        """The rows of a run in the order of the sheet; ``places``: of these tables and sections alone."""
        for part in self.sheet.parts:
            entries = [each for each in part.entries if each.measure and _may_be_at(each, places)]
            for case in self.cases(part, runs) if entries else ():
                for entry in entries:
                    if places is None or filled(entry.place, case) in places:
                        made = self.row(entry, case, runs)
                        if made is not None:
                            yield made

    def cases(self, part: Part, runs: Any) -> Iterator[Mapping[str, Any]]:
        """The cases that the rows of a part are made for: the rows of a table, the cases of a run, or one without any.

        A case of a run that is no mapping is known as ``item``.
        """
        if part.each is None:
            yield {}
        elif part.each in self.tables:
            yield from self.tables[part.each]
        else:
            for case in self._measured(part.each, runs, {}) or ():
                yield case if isinstance(case, Mapping) else {"item": case}

    def row(self, entry: Entry, case: Mapping[str, Any], runs: Any) -> Row | None:
        """One row; None where the run does not have it."""
        assert entry.measure is not None, "a row that reproductions have"
        found = self._measured(entry.measure, runs, {**case, **entry.of})
        if found is None:
            return None
        words = found if isinstance(found, Mapping) else {"value": found}
        values = {"map": entry.map, **self.figures, **case, **entry.of, **words}
        return row(
            filled(entry.place, values),
            filled(entry.what, values),
            printed(entry.published, entry.over, values),
            words[entry.gives],
            unit=filled(entry.unit or "1", values),
            status=Status(filled(entry.status, values)),
            source=filled(entry.source, values),
            use=Use(filled(entry.use, values)),
            note=filled(entry.note or "", values),
        )

    def plots(self, runs: Any) -> Iterator[Plot]:
        """The plots of a run."""
        for each in self.sheet.plots:
            drawing = each.model_dump(exclude={"measure"})
            yield Plot(**drawing, series=tuple(self._measured(each.measure, runs, {})))

    def findings(self, runs: Any, sheet: Sheet | None = None) -> Iterator[Finding]:
        """The findings of a run; ``sheet``: another one, whose findings they are."""
        for each in (sheet or self.sheet).findings:
            found = self._measured(each.measure, runs, {})
            if found is not None:
                words = found if isinstance(found, Mapping) else {"holds": found}
                values = {**self.figures, **words}
                figures = {name: str(filled(text, values)) for name, text in each.figures.items()}
                figures |= words.get("figures", {})
                yield Finding(filled(each.says, values), figures, bool(words.get("holds", True)))

    def _measured(self, name: str, runs: Any, values: Mapping[str, Any]) -> Any:
        if name not in self.measures:
            raise InputError(f"no measure is named {name!r}", str(self.path), choose_hint(name, self.measures))
        return self.measures[name](runs, Case(**{**self.figures, **values}))


def _may_be_at(entry: Entry, places: Collection[str] | None) -> bool:
    return places is None or "{" in (entry.place or "") or entry.place in places


def filled(text: str | None, values: Mapping[str, Any]) -> Any:
    """A text with the values that it names; the value itself where it is one name alone.

    >>> filled("{side}×{side}", {"side": 30}), filled("{side}", {"side": 30})
    ('30×30', 30)
    """
    alone = _ALONE.fullmatch(text or "")
    return values[alone[1]] if alone else (text or "").format_map(values)


def printed(published: float | str | None, over: float, values: Mapping[str, Any]) -> Any:
    """A printed figure in the unit of its row."""
    value = filled(published, values) if isinstance(published, str) else published
    return value / over if over != 1 and isinstance(value, int | float) else value


def curves(points: Iterable[tuple[str, tuple[float, float]]]) -> list[Series]:
    """A curve for each name, through its points in their order."""
    return [
        Series(name, *(tuple(map(float, each)) for each in zip(*pairs, strict=True)))
        for name, pairs in map_reduce(points, itemgetter(0), itemgetter(1)).items()
    ]
