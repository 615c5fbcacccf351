"""The self-contained page of a reproduction: led by its score, then plots, what is missed, and each paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from codesign.ground.units import counted
from codesign.planners.reproduction import Reproduction, joined
from codesign.views.report.page import rendered, write_page
from codesign.views.report.reproduction_plots import against, error_ticks, strips
from codesign.views.report.reproduction_score import WITHIN, Score, missed_table, score_table, scores, unheld_table
from codesign.views.report.reproduction_tables import (
    joined_findings_table,
    reproduction_sources_table,
    reproduction_table,
)
from codesign.views.report.table import Table
from codesign.views.report.wording import share_text

if TYPE_CHECKING:
    from codesign.views.report.canvas import Picture

_FATES = tuple(
    zip(
        ("met-1", "met-2", "met-3", "missed", "unheld"),
        (*(f"within {share_text(most)}" for most in WITHIN), "missed", "cannot be held"),
        strict=True,
    )
)
"""The parts of a bar of the score: class and words."""

Pictures = Mapping[str, Sequence["Picture"]]
"""The figures of each paper, drawn again, by the name of the paper."""


def reproduction_page(
    reproductions: Sequence[Reproduction],
    path: Path,
    *,
    pictures: Pictures | None = None,
    command: str = "hwsw reproduce",
) -> None:
    """Write the page of papers held against the model: score, plots, missed rows, findings, rows, sources.

    Raises:
        RunError: the file cannot be written. ValueError: there is no reproduction.
    """
    write_page(path, reproduction_html(reproductions, pictures=pictures, command=command))


def reproduction_html(
    reproductions: Sequence[Reproduction], *, pictures: Pictures | None = None, command: str = "hwsw reproduce"
) -> str:
    """The page of ``reproduction_page`` as text."""
    whole, each = joined(reproductions), scores(reproductions)
    total = each[-1]
    counts = list(zip(total.within, (words for _, words in _FATES), strict=False))
    return rendered(
        "reproduction.html.j2",
        None,
        title="Published against modelled",
        compared=f"{counted(total.rows, 'row')} of {counted(len(reproductions), 'paper')};"
        f" {total.compared:,} have figures on both sides. Their relative errors:",
        counts=[*counts, (total.missed, "missed"), (total.unheld, "cannot be held")],
        score=score_table(each),
        bars=[(score.name, _bar(score)) for score in each if score.rows],
        fates=_FATES,
        against=against(reproductions),
        strips=strips(reproductions),
        error_ticks=error_ticks(),
        missed=missed_table(reproductions),
        unheld=unheld_table(reproductions),
        papers=[_paper(one, (pictures or {}).get(one.paper, ())) for one in reproductions],
        sources=reproduction_sources_table(whole),
        command=command,
    )


def _bar(score: Score) -> list[tuple[str, str, int, float]]:
    """The parts of a bar: class, words, number of rows, percent of the width."""
    parts = zip(_FATES, score.parts, strict=True)
    return [(kind, words, count, 100 * count / score.rows) for (kind, words), count in parts]


@dataclass(frozen=True)
class _Paper:
    """What the page has of one paper."""

    name: str
    note: str
    findings: Table | None
    rows: Table
    pictures: Sequence[Picture]


def _paper(reproduction: Reproduction, pictures: Sequence[Picture]) -> _Paper:
    moved = reproduction.settings and f"not as published: {reproduction.settings}"
    note = "; ".join(filter(None, (moved, reproduction.note)))
    findings = joined_findings_table(reproduction) if reproduction.findings else None
    return _Paper(reproduction.paper, note, findings, reproduction_table(reproduction), pictures)
