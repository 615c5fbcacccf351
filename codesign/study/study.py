"""A study, the result of an exploration: its table, and all that is asked of it."""

from __future__ import annotations

import json
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codesign.ground.figures import ResultFigure
from codesign.ground.notebooks import InNotebooks, data_frame
from codesign.ground.progress import Show, silent
from codesign.study.certificates.check import Verdict
from codesign.study.certify import certify
from codesign.study.columns import study_columns, write_parquet
from codesign.study.designs import Design, Rows, StudyPoint, checked_index, designs_of, points_of
from codesign.study.document import study_document
from codesign.study.reasons import ReasonCount, nearest_designs, reason_counts
from codesign.study.sensitivity import axis_effects
from codesign.study.table import Table
from codesign.system.explanation import AxisEffect, Explanation

if TYPE_CHECKING:
    from pandas import DataFrame


class Study(Table, InNotebooks):
    """Every design of an exploration, and every point: a design in one condition; see ``Table``."""

    @property
    def points(self) -> Rows[StudyPoint]:
        """Every point. ``points[i].index`` is ``i``."""
        return points_of(self)

    @property
    def designs(self) -> Rows[Design]:
        """Every combination of the decisions, with its points. ``designs[i].index`` is ``i``."""
        return designs_of(self)

    @cached_property
    def reasons(self) -> tuple[ReasonCount, ...]:
        """The reasons that kept designs out, the most frequent first. A design counts once, by its largest gap."""
        return reason_counts(self)

    def lacking(self, design: Design) -> tuple[ResultFigure, ...]:
        """The objectives that keep a feasible design off the front because it does not have them."""
        if not design.feasible:
            return ()
        return tuple(name for name in self.objectives if design.figure(name) is None)

    def nearest(self, count: int = 3) -> tuple[int, ...]:
        """Indices of the infeasible designs that pass their limits by least: by the largest relative gap of each."""
        return nearest_designs(self, count)

    def point(self, index: int) -> StudyPoint:
        """The point of that index.

        Raises:
            InputError: there is none.
        """
        return self.points[checked_index("point", index, len(self.points))]

    def sensitivity(self, *figures: ResultFigure) -> tuple[AxisEffect, ...]:
        """The share of the spread of each figure (by default, objective) that each axis moves: ``axis_effects``."""
        return axis_effects(self, figures or self.objectives)

    def explain(self, index: int, show: Show = silent) -> Explanation:
        """Explain why a design is as it is: time, energy, what keeps it out, its neighbours, and how sure that is.

        ``index``: of a design; without conditions a design is a point. ``show`` is told what is run.

        Raises:
            InputError: there is no such design, it failed, or it was not computed.
        """
        kind = "design" if self.conditions else "point"
        return self.designs[checked_index(kind, index, len(self.designs))].explain(show)

    def certify(self, path: Path | str) -> Verdict:
        """Write the certificate of the front, which ``hwsw verify-front`` checks; see ``study.certify``."""
        return certify(self, path)

    def to_dict(self) -> dict[str, Any]:
        """The study as JSON has it: the same at any worker count, and whether computed now or read from a store."""
        return study_document(self).model_dump(mode="json")

    def frame(self) -> DataFrame:
        """The computed points as a data frame of pandas, with the columns of ``study.columns.study_columns``.

        Raises:
            InputError: pandas is not installed.
        """
        return data_frame(study_columns(self))

    def to_parquet(self, path: Path | str, show: Show = silent) -> None:
        """Write every computed point as a Parquet file; see ``study.columns.write_parquet``."""
        write_parquet(self, Path(path), show)

    def to_json(self) -> str:
        """``to_dict`` as text, one line."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False)
