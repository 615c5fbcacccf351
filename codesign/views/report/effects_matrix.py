"""Which axis moves which figure, as a matrix to be looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from codesign.ground.figures import ResultFigure
from codesign.system.explanation import AxisEffect
from codesign.views.report.aggregated import figure_label
from codesign.views.report.axes import short_names
from codesign.views.report.wording import ABSENT, share_text

if TYPE_CHECKING:
    from codesign.study import Study

_STEPS = 10


@dataclass(frozen=True)
class Effect:
    """A cell: the share of the spread of a figure that an axis moves, in all and by itself; how dark it is, 0 to 10."""

    text: str
    alone: str
    shade: int


@dataclass(frozen=True)
class Matrix:
    """Axes by figures. Each row has the name of its axis, and a cell for each figure that varies."""

    figures: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Effect, ...]], ...]


def effects_matrix(study: Study, figures: Sequence[ResultFigure], effects: Sequence[AxisEffect]) -> Matrix:
    """The total share of each axis in the spread of each figure that varies over the feasible designs.

    ``effects``: those of the figures (``Study.sensitivity``).
    """
    if not study.feasible:
        return Matrix((), ())
    moving = [
        figure for figure in figures if any(each.figure == figure.name and each.total is not None for each in effects)
    ]
    held = {(each.axis, each.figure): each for each in effects}
    axes = tuple(dict.fromkeys(each.axis for each in effects))
    rows = []
    for axis, name in zip(axes, short_names(axes), strict=True):
        cells = []
        for figure in moving:
            effect = held[axis, figure.name]
            if effect.total is None or effect.main is None:
                cells.append(Effect(ABSENT, ABSENT, 0))
            else:
                shade = round(_STEPS * min(max(effect.total, 0.0), 1.0))
                cells.append(Effect(_percent(effect.total), _percent(effect.main), shade))
        rows.append((name, tuple(cells)))
    return Matrix(tuple(figure_label(study, figure) for figure in moving), tuple(rows) if moving else ())


def _percent(share: float) -> str:
    """A share as whole percent; a little of it is not 0 %."""
    return share_text(round(share, 2)) if share >= 0.01 or share == 0 else "<1 %"
