"""The searches of a space: their evaluations and hypervolumes, as a table and a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from codesign.ground.units import counted, format_count
from codesign.study.hypervolume import REFERENCE, Curve, curves_of, scale_of
from codesign.views.report.canvas import Picture, canvas, drawn, legend, style
from codesign.views.report.table import Cell, Table, left, right, word
from codesign.views.report.wording import ABSENT, count_cell, quantity_text

if TYPE_CHECKING:
    from codesign.study import Study
    from codesign.study.search import Trace

_QUARTERS = (0.25, 0.5, 1.0)


def search_table(study: Study) -> Table | None:
    """The searches side by side, at the same number of evaluations; None where all designs were asked for."""
    if study.search is None:
        return None
    if why := study.search.traces[0].enumerated:
        return _in_its_place(study, study.search.traces[0], why)
    curves = curves_of(study)
    columns = (
        *left("search"),
        *right("seed", "evaluated", "asked again", "excluded"),
        *right(*(f"hypervolume at {share:.0%}" for share in _QUARTERS)),
        *left("end"),
    )
    rows = tuple(_row(curve) for curve in curves)
    return Table("Searches", columns, rows, _notes(study, curves))


def _in_its_place(study: Study, trace: Trace, why: str) -> Table:
    count = len(study.outcomes) - len(study.missing)
    end = "all points computed" if trace.proved else trace.ended
    columns = (*left("search asked for"), *right("points"), *left("end"))
    return Table("Searches", columns, ((word(trace.name), count_cell(count), word(end)),), (why,))


def _row(curve: Curve) -> tuple[Cell, ...]:
    trace = curve.trace
    excluded = sum(box.designs for box in trace.excluded)
    end = "front proved" if trace.proved else trace.ended or "as many evaluations"
    return (
        word(trace.name),
        Cell(str(trace.seed), trace.seed),
        count_cell(len(trace.designs)),
        count_cell(trace.repeated),
        count_cell(excluded),
        *(_at(curve, share) for share in _QUARTERS),
        word(end),
    )


def _at(curve: Curve, share: float) -> Cell:
    places = [
        place
        for place, count in enumerate(curve.evaluations)
        if count <= max(1, round(share * len(curve.trace.designs)))
    ]
    value = curve.hypervolumes[places[-1]] if places else None
    return Cell(ABSENT) if value is None else Cell(f"{value:.4f}", value)


def _notes(study: Study, curves: tuple[Curve, ...]) -> tuple[str, ...]:
    assert study.search is not None, "the caller looks"
    scale = scale_of(study)
    signs = [-1.0 if study.world.maximise(figure) else 1.0 for figure in study.objectives]
    point = "; ".join(
        f"{figure.label} {quantity_text(float(sign * value), figure.unit)}"
        for figure, sign, value in zip(study.objectives, signs, scale.reference, strict=True)
    )
    notes = [
        f"hypervolume: the share of the space up to the reference point that the designs dominate. 0 is the best value"
        f" of all designs here, 1 the worst, and the reference {REFERENCE}: {point}"
    ]
    if curves and curves[0].hypervolumes and curves[0].hypervolumes[0] is None:
        notes = ["hypervolume: pip install 'hwsw-codesign[search]'"]
    boxes = study.search.excluded
    if boxes:
        notes.append(f"excluded: designs in {format_count(len(boxes))} boxes that a bound or a limit keeps out")
    found = study.search
    notes.append(f"{format_count(found.simulated)} simulations, {counted(found.kept, 'point')} from the store")
    return tuple(notes)


def search_picture(study: Study) -> Picture | None:
    """The hypervolume over the evaluations of each search; None where there is none."""
    curves = [curve for curve in curves_of(study) if curve.hypervolumes and None not in curve.hypervolumes]
    if not curves:
        return None
    with style():
        picture, axes = canvas((7.2, 3.4))
        for curve in curves:
            axes.plot(curve.evaluations, curve.hypervolumes, label=curve.trace.name, drawstyle="steps-post")
        axes.set(xlabel="evaluated designs", ylabel="hypervolume")
        axes.grid(visible=True, alpha=0.3)
        legend(picture)
        names = ", ".join(curve.trace.name for curve in curves)
        alt = f"Hypervolume over the number of evaluated designs, of {names}"
        return drawn(picture, "svg", "Hypervolume over evaluations", alt)
