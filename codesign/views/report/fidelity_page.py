"""The page about fidelity, in Markdown, and its picture: law over measured by term and family, on one axis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from more_itertools import map_reduce

from codesign.ground.figures import label
from codesign.ground.late import late
from codesign.ground.units import counted, format_count
from codesign.hardware.fidelity import WORST, Fidelity, Mismatch, Spread, reason_of, spread
from codesign.hardware.fidelity.claims import Claim
from codesign.hardware.fidelity.points import TOTAL, Point, width_of
from codesign.planners.measured import PARTS
from codesign.views.report.canvas import canvas, legend, picture_bytes, style
from codesign.views.report.hardware_tables import verification_table
from codesign.views.report.render import render_markdown
from codesign.views.report.wording import Cell, Table, formed_cell, left, number_cell, right, word, words

# The comparison of laws, circuits and papers as tables.

FAMILY_NAMES = {family: ", ".join(name for name, rows in PARTS.items() if rows == family) for family in PARTS.values()}
"""A family of rows by the names of its families of parts."""


def fidelity_tables(result: Fidelity) -> Iterator[Table]:
    """Cycles, resources by family and by line, clocks, papers, and what does not match."""
    yield verification_table(result.cycles)
    yield _families(result)
    yield _lines(result)
    yield _clocks(result.points)
    yield _paths(result.points)
    yield _claims("Power, laws against published figures", [each for each in result.claims if each.unit == "W"])
    yield _claims("Papers against circuits", [each for each in result.claims if each.unit != "W"])
    yield _open(result)


_PERCENT, _OFF = "{:.1%}", "{:+z.1%}"


def _errors(errors: Sequence[float]) -> tuple[Cell, Cell, Cell]:
    """Rows, mean and worst."""
    mean = sum(errors) / len(errors) if errors else None
    worst = max(errors, default=None)
    return number_cell(len(errors)), formed_cell(mean, _PERCENT), formed_cell(worst, _PERCENT)


_ERRORS = right("fitted rows", "mean", "worst", "rows held out", "their mean", "their worst")


def _families(result: Fidelity) -> Table:
    whole = [each for each in result.by_family if each.line == TOTAL]
    rows = [_spread_row(each, FAMILY_NAMES[each.family]) for each in whole]
    columns = (*left("planner", "style", "family", "resource"), *_ERRORS)
    totals = [point.present for point in result.points if point.line == TOTAL]
    earlier = (
        f"{format_count(totals.count(False))} of {counted(len(totals), 'sum')} are of an earlier state of the Verilog:"
        " its digest has changed since"
    )
    notes = ("errors are sizes: law over synthesised less 1, of whole circuits", *(() if all(totals) else (earlier,)))
    return Table("Resources, law against synthesis", columns, tuple(rows), notes)


def _spread_row(each: Spread, of: str) -> tuple[Cell, ...]:
    """A row of errors; ``of``: the family or the line."""
    return *words(each.planner, each.style, of, label(each.quantity)), *_errors(each.fitted), *_errors(each.held)


def _lines(result: Fidelity) -> Table:
    rows = [(*_spread_row(each, each.line), _range(each)) for each in result.by_line if each.line != TOTAL]
    columns = (*left("planner", "style", "line", "resource"), *_ERRORS, *right("law / synthesised, least to greatest"))
    notes = ("others: lines and modules that only the demand, or only the circuit, has by that name",)
    return Table("Resources by line of the demand, all families", columns, tuple(rows), notes)


def _range(each: Spread) -> Cell:
    if each.least is None or each.most is None:
        return Cell("-")
    same = f"{each.least:.2f}" == f"{each.most:.2f}"
    return Cell(f"{each.least:.2f}" if same else f"{each.least:.2f} to {each.most:.2f}", each.most)


def _clock_points(points: Sequence[Point]) -> list[Point]:
    return [point for point in points if point.quantity == "clock"]


def _clocks(points: Sequence[Point]) -> Table:
    rows = []
    for point in _clock_points(points):
        low, high = (bound / 1e6 for bound in point.predicted.interval)
        rows.append(
            (
                *words(point.planner, point.style, point.part, point.design),
                formed_cell(point.predicted.value / 1e6, "{:.0f}"),
                Cell(f"{low:.0f} to {high:.0f}"),
                formed_cell(width_of(point.predicted), _PERCENT),
                formed_cell(point.measured / 1e6, "{:.1f}"),
                *(formed_cell(error, _OFF) for error in (point.error, point.without)),
                *words("yes" if point.holds else "no", point.note.split(";")[0]),
            )
        )
    columns = (
        *left("planner", "style", "part", "design"),
        *right("law, MHz", "interval", "±", "placed, MHz", "error", "held out"),
        *left("in it", "median of"),
    )
    notes = (
        "error: law over placed less 1, with this placement in the fit; held out: by the fit to all others, - where"
        " none of them speaks of it",
    )
    return Table("Clocks, law against placement", columns, tuple(rows), notes)


def _paths(points: Sequence[Point]) -> Table:
    """The critical path of the slowest placement of each style on each part."""
    slowest: dict[tuple[str, str, str], Point] = {}
    for point in _clock_points(points):
        key = point.planner, point.style, point.part
        if key not in slowest or point.measured < slowest[key].measured:
            slowest[key] = point
    rows = [words(*key, point.design, point.note.split("; ", 1)[1]) for key, point in slowest.items()]
    columns = left("planner", "style", "part", "design", "critical path of the median seed")
    return Table("What limits the slowest placement", columns, tuple(rows))


def _value(claim: Claim, value: float | None) -> Cell:
    if value is None:
        return Cell("-")
    scale, digits = {"Hz": (1e-6, "{:,.1f} MHz"), "W": (1e3, "{:,.1f} mW")}.get(claim.unit, (1, "{:,.4g}"))
    text = f"{value:,.0f}" if claim.unit == "1" and value >= 1000 else digits.format(value * scale)
    return Cell(text, value)


def _claims(title: str, claims: Sequence[Claim]) -> Table:
    rows = tuple(
        (
            *words(claim.place, claim.quantity),
            *(_value(claim, value) for value in (claim.published, claim.law, claim.circuit)),
            formed_cell(claim.error, _OFF),
            word(claim.how),
        )
        for claim in claims
    )
    columns = (*left("paper", "figure"), *right("published", "law", "circuit", "error"), *left("what it is taken from"))
    notes = ("error: of the circuit against the paper; of the law where no circuit was counted",)
    return Table(title, columns, rows, notes)


def _explained(mismatch: Mismatch) -> tuple[str, str]:
    reason = reason_of(mismatch)
    return (reason.words, reason.experiment) if reason else ("open", "open")


def _open(result: Fidelity) -> Table:
    """The mismatches, gathered by their reason."""
    groups = map_reduce(result.mismatches, _explained, lambda each: f"{each.key}: {each.words}")
    rows = tuple(words("; ".join(texts), why, experiment) for (why, experiment), texts in groups.items())
    columns = left("what does not match, or was never measured", "why", "the experiment that would settle it")
    return Table("Open points", columns, rows)


HEAD = """# How far the model carries

    {command}

writes this page and its picture: what the laws predict, against circuits of the Verilog of this package that were
simulated, synthesised and placed, and against what papers published. Every number is read from the rows in
`codesign/planners/ROOM/measured/` or counted in a run. Nothing is left out because it does not fit.
[laws.md](laws.md) has the laws, and [reproduction.md](reproduction.md) holds the model against every row of the papers.
"""

PICTURE = """
![law over measured, by style, resource and family of parts]({picture})

A ratio beyond the ends of the axis stands at its end.
"""

SECTIONS = (
    (
        "Cycles",
        "Random design points on random maps, sample {first} to {last} of each circuit. Every event of the circuit is"
        " compared with the model in its kind, its value and its cycle, and every phase in its cycles (`hwsw verify`).",
    ),
    (
        "Resources",
        "Yosys counts the LUT, flip-flops, block RAMs and multipliers (`hwsw synth`). A row that is held out was not in"
        " the fit of the law. Slices are a matter of packing and are not compared.",
    ),
    ("Resources by line", "The same rows, line by line of the demand."),
    (
        "Clocks",
        "nextpnr places and routes each design once for each seed (`hwsw synth --place`). The law is asked about the"
        " same design on the same part.",
    ),
    ("Critical paths", "The path that decides, in words, from the clock edge to the clock edge."),
    ("Power", "No circuit was measured. The laws are held against what was published."),
    (
        "Papers",
        "Figures of the papers that the Verilog has too. A clock stands beside the fastest placement of the same style"
        " on another part: open tools do not route the papers' parts.",
    ),
    (
        "What does not match",
        "Beyond 5 % mean or 10 % worst of LUT and flip-flops, any difference of block RAMs, multipliers and cycles, any"
        " clock outside its interval or with one of more than ±15 %, any figure of a paper that is more than 5 % off.",
    ),
)
"""Heading and text of each table, in the order of ``fidelity_tables``."""


def fidelity_page(result: Fidelity, seeds: range, command: str, picture: str | None = None) -> str:
    """The page. ``picture``: the path of the picture, relative to the page."""
    parts = [HEAD.format(command=command)]
    if picture is not None:
        parts.append(PICTURE.format(picture=picture))
    for (heading, text), table in zip(SECTIONS, fidelity_tables(result), strict=True):
        about = text.format(first=seeds[0], last=seeds[-1])
        parts.append(f"\n## {heading}\n\n{about}\n\n{render_markdown(table)}")
    return "".join(parts)


ticker = late("matplotlib.ticker")

MARKERS = {
    "xc2v": ("o", "#1b9e77"),
    "xc2vp": ("s", "#66a61e"),
    "xc3se": ("D", "#a6761d"),
    "xc4v": ("^", "#e6ab02"),
    "xc7": ("v", "#d95f02"),
    "ecp5": ("P", "#7570b3"),
    "gowin": ("X", "#e7298a"),
    "ice40": ("*", "#666666"),
}
LEAST, MOST = 0.25, 4.0
"""The ends of the axis; a ratio beyond stands at its end."""


def fidelity_picture(result: Fidelity) -> bytes:
    """The picture as SVG: a line for each style and resource, a mark for each family, its bar from least to most."""
    terms = _terms(result.points)
    with style():
        picture, axes = canvas((8.2, 1.4 + 0.3 * len(terms)))
        axes.axvspan(1 - WORST, 1 + WORST, color="#2c7fb8", alpha=0.12, linewidth=0, label=f"±{WORST:.0%}")
        axes.axvline(1, color="#444444", linewidth=0.8)
        seen: set[str] = set()
        for line, (_, families) in enumerate(terms):
            for place, (family, group) in enumerate(families.items()):
                errors = spread(group)
                if errors.least is None or errors.middle is None or errors.most is None:
                    continue
                low, middle, high = (min(MOST, max(LEAST, each)) for each in (errors.least, errors.middle, errors.most))
                marker, colour = MARKERS[family]
                y = line + 0.64 * ((place + 0.5) / len(families) - 0.5)
                axes.plot([low, high], [y, y], color=colour, linewidth=1.2)
                name = "" if family in seen else FAMILY_NAMES[family]
                axes.plot(
                    [middle], [y], marker, color=colour, markersize=4.5, label=name, linestyle="none", clip_on=False
                )
                seen.add(family)
        axes.set(xscale="log", xlim=(LEAST, MOST), ylim=(len(terms) - 0.4, -0.6))
        axes.set_yticks(range(len(terms)), [name for name, _ in terms])
        axes.set_xticks([0.25, 0.5, 0.8, 1, 1.25, 2, 4])
        axes.xaxis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_formatter(ticker.NullFormatter())
        axes.xaxis.set_minor_locator(ticker.NullLocator())
        axes.grid(visible=True, axis="x", alpha=0.3)
        axes.set_xlabel("law / measured (synthesised, or placed); bar: least to most, mark: middle row")
        legend(picture)
        return picture_bytes(picture, "svg")


def _terms(points: tuple[Point, ...]) -> list[tuple[str, dict[str, list[Point]]]]:
    """Planner, style and quantity in words, and its points by family."""
    shown = [point for point in points if point.line == TOTAL or point.quantity == "clock"]
    terms = map_reduce(
        shown,
        lambda point: f"{point.planner} {point.style}, {label(point.quantity)}".replace("_", " "),
        reducefunc=lambda group: dict(map_reduce(group, lambda point: point.family)),
    )
    return list(terms.items())
