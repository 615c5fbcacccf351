"""The page of an answer about boards, which people mail: the question, the verdict, its doubts, all boards drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from more_itertools import map_reduce

from codesign.ground.figures import label
from codesign.ground.late import late
from codesign.ground.records import RECORD_TYPES, Record, Recorder, Subject
from codesign.ground.units import Dimension, counted, format_quantity
from codesign.study.advice.answer import Advice, BoardAdvice, Design
from codesign.study.advice.certainty import number_text
from codesign.study.advice.motion import Driven
from codesign.study.advice.needs import Needs, Question
from codesign.study.advice.sentence import design_text, rate_text, shortfall_text
from codesign.system.results.result import reach_text
from codesign.views.report.canvas import Picture, with_palette
from codesign.views.report.page import rendered, write_page
from codesign.views.report.wording import (
    ABSENT,
    Cell,
    Table,
    axis_text,
    left,
    quantity_cell,
    quantity_text,
    right,
    share_text,
    word,
    words,
    yes_cell,
)

pictures = late("codesign.views.report.pictures")

_KEYS = {"component", "style"}


def advice_table(advice: Advice) -> Table:
    """A row for each board: its design, what that comes to, and what binds or excludes it."""
    columns = (
        *left("board", "suffices"),
        *right("price", unit="USD"),
        *right("rate", unit="Hz"),
        *(right("speed", unit="m/s") if advice.driven else ()),
        *right("margin"),
        *right("power at plug", unit="W"),
        *left("design", "parameters", "binds, or fails by", "fastest"),
    )
    pocket = "" if advice.reach in (None, 1) else f"; {reach_text([advice.reach])}"
    notes = [
        f"A map of {advice.rows} × {advice.columns} cells, {advice.free_cells:,} free;"
        f" {counted(advice.starts, 'start')}{pocket}."
        " Rate: one over the time of a plan, the worst over the starts. Margin: rate over the rate that is asked for.",
        *([_SPEED] if advice.driven else []),
        "Power at plug: the mean at the rate that is asked for, idle between plans; ≥: of its components alone,"
        " as nobody measured the whole board (board.power).",
        *_folded(advice.boards),
        *_left_out(advice.not_searched),
        *_beyond(advice.proof.beyond),
        *advice.remarks,
    ]
    shown = [board for board in advice.boards if board.under is None or board.board == advice.recommended]
    strong = {index for index, board in enumerate(shown) if board.board == advice.recommended}
    return Table("boards", columns, tuple(_row(board, advice) for board in shown), tuple(notes), frozenset(strong))


_SPEED = (
    "Speed: the greatest with which the robot stops in time, and what binds it: its body (range and brakes), compute,"
    " the sensor, or a delay."
)


def _speed(driven: Driven | None) -> Cell:
    return Cell(ABSENT) if driven is None else Cell(f"{driven.speed_mps:.3g} m/s, {driven.binds}", driven.speed_mps)


_MOST_LEFT = 3
"""Boards with designs that were not looked at that the note names."""


def _left_out(left: Sequence[str]) -> list[str]:
    """The designs that were not looked at."""
    more = len(left) - _MOST_LEFT
    names = ", ".join(left[:_MOST_LEFT]) + (f", and those of {counted(more, 'board')} more" if more > 0 else "")
    return [f"Designs not looked at, as the budget was spent: {names}."] if left else []


def _beyond(left_out: Sequence[str]) -> list[str]:
    """The designs that no statement of the answer is about."""
    return [f"Designs that are not searched, so nothing is said of them: {'; '.join(left_out)}."] if left_out else []


def _folded(boards: Sequence[BoardAdvice]) -> list[str]:
    """The boards whose chip has no part in their best design, by the computer beside them."""
    by_computer = map_reduce((each for each in boards if each.under), lambda each: each.under, lambda each: each.board)
    return [
        f"As {computer}, whose processor does all the work, with more to pay: {', '.join(names)}."
        for computer, names in by_computer.items()
    ]


def _row(board: BoardAdvice, advice: Advice) -> tuple[Cell, ...]:
    design = board.design
    margin = Cell(ABSENT) if board.margin is None else Cell(f"{board.margin:.3g}", board.margin)
    return (
        word(board.board),
        yes_cell(board.suffices),
        Cell(ABSENT) if board.price_usd is None else Cell(number_text(board.price_usd), board.price_usd),
        quantity_cell(None if design is None else design.rate_hz, "Hz"),
        *([_speed(advice.driven.get(board.board))] if advice.driven else []),
        margin,
        _power(board),
        word(ABSENT if design is None else design_text(design)),
        word(ABSENT if design is None else _parameters(design)),
        word(_binds(board, advice.needs)),
        word(_fastest(board)),
    )


def _power(board: BoardAdvice) -> Cell:
    """Mean power at the plug; of a board that declares none, the power of its components, which is less."""
    design = board.design
    if design is not None and design.input_power_w is not None:
        return quantity_cell(design.input_power_w, "W")
    parts = quantity_cell(board.idle_w if design is None else design.mean_power_w, "W")
    return parts if parts.value is None else Cell(f"≥ {parts.text}", parts.value)


def _fastest(board: BoardAdvice) -> str:
    """The fastest design, where it is another one."""
    fastest = board.fastest
    if fastest is None or fastest == board.design or fastest.rate_hz is None:
        return ABSENT
    return f"{quantity_text(fastest.rate_hz, 'Hz')}: {design_text(fastest)}"


def _parameters(design: Design) -> str:
    planning = next(iter(design.mapping.values()))
    chosen = {key: value for key, value in planning.items() if key not in _KEYS} | design.settings
    return ", ".join(f"{key} {axis_text(key, value)}" for key, value in chosen.items()) or ABSENT


def _binds(board: BoardAdvice, needs: Needs) -> str:
    if board.shortfalls:
        text = "; ".join(shortfall_text(short, needs) for short in board.shortfalls)
        return f"{text} (not sure)" if board.perhaps else text
    design = board.design
    if design is None or design.binds_share is None:
        return ABSENT
    return f"{label(design.binds)}: {share_text(float(f'{design.binds_share:.3g}'))} of the limit"


# Charts of boards as places in percent of their width and height: a template draws them as inline SVG.

_MOST_TICKS = 6
_HEIGHT, _WIDTH = 320, 320
"""Pixels: the height of a chart, and the width that its labels must not overlap at, which is the width of a phone."""

_OFFSETS = ((9, 4), (-9, 4), (0, -9), (0, 17), (9, -9), (-9, -9), (9, 17), (-9, 17), (22, 4), (-22, 4))


class PathKeeper(Recorder):
    """Keeps the paths of a run, in ``paths``. A run with no other listener makes no other records."""

    def __init__(self) -> None:
        self.paths: list[Any] = []

    @property
    def unwanted(self) -> frozenset[type[Record]]:
        """All but paths."""
        return frozenset(kind for kind in RECORD_TYPES.values() if kind.ROLE.about is not Subject.PATH)

    def __call__(self, record: Record) -> None:
        """Take one record."""
        if record.ROLE.about is Subject.PATH:
            self.paths.append(record)


@dataclass(frozen=True)
class Axis:
    """An axis from ``least`` to ``most``: the places of values in percent of its length."""

    least: float
    most: float
    logarithmic: bool
    text: Callable[[float], str]

    @classmethod
    def logarithm(cls, values: Sequence[float], text: Callable[[float], str]) -> Axis:
        """The logarithmic axis of these values, with room at both ends."""
        return cls(min(values) / 1.4, max(values) * 1.4, True, text)

    def place(self, value: float) -> float:
        """Percent of the length."""
        if self.logarithmic:
            share = math.log(value / self.least) / math.log(self.most / self.least)
        else:
            share = (value - self.least) / (self.most - self.least)
        return round(100 * min(max(share, 0.0), 1.0), 2)

    @property
    def ticks(self) -> list[tuple[float, str]]:
        """Round values as (place, text): of a logarithmic axis 1, 2 and 5 of each decade where there is room."""
        if self.logarithmic:
            decades = range(math.floor(math.log10(self.least)), math.ceil(math.log10(self.most)) + 1)
            steps: tuple[int, ...]
            for steps in ((1, 2, 5), (1, 3), (1,)):
                values = [step * 10.0**power for power in decades for step in steps]
                values = [value for value in values if self.least <= value <= self.most]
                if len(values) <= _MOST_TICKS:
                    break
            values = values[:: math.ceil(len(values) / _MOST_TICKS) or 1]
        else:
            size = 10.0 ** math.floor(math.log10(self.most / 4))
            step = next(size * factor for factor in (1, 2, 5, 10) if self.most / (size * factor) <= _MOST_TICKS)
            values = [step * number for number in range(math.floor(self.most / step) + 1)]
        return [(self.place(value), self.text(value)) for value in values]


@dataclass(frozen=True)
class Mark:
    """A board on a chart: the number of its row in the table, its place, its interval, and the place of its number.

    ``kind``: best, plain (it suffices) or short. ``ends``: of the interval, upwards or, ``flat``, to the right.
    """

    number: int
    name: str
    text: str
    kind: str
    x: float
    y: float
    ends: tuple[float, float] | None
    flat: bool
    label: tuple[int, int]


@dataclass(frozen=True)
class Chart:
    """A chart of boards: axes, marks, lines across (``levels``: place from above, text), and a curve (an SVG path)."""

    title: str
    alt: str
    x_label: str
    y_label: str
    x_ticks: Sequence[tuple[float, str]]
    y_ticks: Sequence[tuple[float, str]]
    marks: tuple[Mark, ...]
    levels: tuple[tuple[float, str], ...]
    notes: tuple[str, ...]
    curve: str = ""


_Drawn = tuple[BoardAdvice, float, float, tuple[float | None, float | None], str]
"""A board, its x and y, the ends of its interval, and what it comes to in words."""


def _marks(advice: Advice, drawn: Sequence[_Drawn], x: Axis, y: Axis, *, flat: bool) -> tuple[Mark, ...]:
    """The marks, each with its number where it covers no other one."""
    places = [(x.place(each[1]), 100 - y.place(each[2])) for each in drawn]
    taken = [(right * _WIDTH / 100, down * _HEIGHT / 100 + 4) for right, down in places]
    marks = []
    along = x if flat else y
    for (board, _, _, ends, text), at, pixels in zip(drawn, places, list(taken), strict=True):
        labels = [(pixels[0] + 1.4 * shift[0], pixels[1] - 4 + shift[1]) for shift in _OFFSETS]
        free = next((number for number, label in enumerate(labels) if _is_free(*label, taken)), 0)
        taken.append(labels[free])
        low, high = (None if end is None else along.place(end) for end in ends)
        bar = None if low is None or high is None else (low, high) if flat else (100 - high, 100 - low)
        kind = "best" if board.board == advice.recommended else "plain" if board.suffices else "short"
        number = advice.boards.index(board) + 1
        marks.append(Mark(number, board.board, f"{number} {board.board}: {text}", kind, *at, bar, flat, _OFFSETS[free]))
    return tuple(marks)


def _is_free(x: float, y: float, taken: Sequence[tuple[float, float]]) -> bool:
    return all(abs(x - other[0]) > 13 or abs(y - other[1]) > 11 for other in taken)


def price_chart(advice: Advice) -> Chart | None:
    """The boards by price and rate, with the line of the rate that is asked for; None where none has both."""
    drawn: list[_Drawn] = []
    for board in advice.boards:
        design = board.design
        if board.price_usd and design is not None and design.rate_hz is not None:
            trial = design.trial
            low, high = (1 / time if time else None for time in (trial.time_high_s, trial.time_low_s))
            text = f"{_usd(board.price_usd)}, {quantity_text(design.rate_hz, 'Hz')}"
            drawn.append((board, board.price_usd, design.rate_hz, (low, high), text))
    if not drawn:
        return None
    rate = advice.needs.rate_hz
    rates = [rate, *(value for each in drawn for value in (each[2], *each[3]) if value is not None)]
    x = Axis.logarithm([each[1] for each in drawn], number_text)
    y = Axis.logarithm(rates, lambda rate: format_quantity(rate, Dimension.RATE, 3))
    levels = ((100 - y.place(rate), f"asked: {rate_text(advice.needs)}"),)
    marks = _marks(advice, drawn, x, y, flat=False)
    title = "Boards by price and rate"
    alt = f"{title}, both axes logarithmic, with the line of {rate_text(advice.needs)}: {_read_out(marks)}"
    notes = ("A vertical line is the interval of a rate: what the assumed figures leave open.", *_absent(advice, drawn))
    return Chart(title, alt, "price, USD", "plans a second", x.ticks, y.ticks, marks, levels, notes)


_CURVE_POINTS = 120


def speed_chart(advice: Advice) -> Chart | None:
    """The speed that a plan of each length allows, and the boards on that curve; None where no motion was asked."""
    motion = advice.needs.motion
    boards = [board for board in advice.boards if board.board in advice.driven]
    if motion is None or not boards:
        return None
    drawn: list[_Drawn] = []
    for board in boards:
        driven = advice.driven[board.board]
        trial = board.design.trial if board.design is not None else None
        assert trial is not None, "a board is driven with its design"
        assert trial.time_s is not None, "which was run"
        text = f"a plan takes {quantity_text(trial.time_s, 's')}: {driven.speed_mps:.3g} m/s, {driven.binds} binds"
        drawn.append((board, trial.time_s, driven.speed_mps, (trial.time_low_s, trial.time_high_s), text))
    times = [motion.plan_s, *(value for each in drawn for value in (each[1], *each[3]) if value)]
    x = Axis.logarithm([*times, 10 * max(times)], lambda time: quantity_text(time, "s"))
    y = Axis(0.0, 1.08 * float(motion.body.speed(0.0)), False, lambda speed: f"{speed:.3g} m/s")
    curve = [
        (time, motion.driven(time, None, None).speed_mps)
        for time in np.geomspace(x.least, x.most, _CURVE_POINTS).tolist()
    ]
    path = "M" + "L".join(f"{x.place(time):g} {100 - y.place(speed):g}" for time, speed in curve)
    wanted = f"asked: {motion.wanted_mps:.3g} m/s, a plan of {quantity_text(motion.plan_s, 's')} at most"
    if advice.needs.rate_is_asked:
        levels: tuple[tuple[float, str], ...] = ()
    else:
        levels = ((100 - y.place(motion.wanted_mps), wanted),)
    marks = _marks(advice, drawn, x, y, flat=True)
    title = "Speed that a board allows"
    alt = f"{title}: a curve that falls with the time of a plan, and on it {_read_out(marks)}"
    notes = ("A horizontal line is the interval of a time of a plan.", *_absent(advice, drawn))
    return Chart(title, alt, "time of a plan", "speed", x.ticks, y.ticks, marks, levels, notes, path)


def _absent(advice: Advice, drawn: Sequence[_Drawn]) -> tuple[str, ...]:
    shown = {each[0].board for each in drawn}
    missing = [board.board for board in advice.boards if board.board not in shown]
    return (f"Not drawn, as a figure is missing: {', '.join(missing)}.",) if missing else ()


def _read_out(marks: Sequence[Mark]) -> str:
    return "; ".join(mark.text for mark in marks)


def _usd(price: float) -> str:
    return f"{number_text(price)} USD"


# The page.


def doubts_table(advice: Advice) -> Table:
    """The doubts about the verdict: of the winner, of the witness, and of those that may suffice."""
    rows = []
    if advice.certainty is not None and advice.recommended is not None:
        rows.append(words(advice.recommended, "recommended", advice.certainty.text))
    if advice.witness is not None and advice.witness_certainty is not None:
        rows.append(words(advice.witness, "witness", advice.witness_certainty.text))
    rows += [words(board.board, "may suffice", board.perhaps) for board in advice.boards if board.perhaps]
    rows += [words(what, "not searched", "the budget was spent") for what in advice.not_searched]
    return Table("How sure it is", left("board", "as", "why"), tuple(rows))


def question_picture(question: Question, records: Sequence[Any]) -> Picture:
    """The map with goals and starts, and with the paths of the winner's plan, of which ``records`` are."""
    paths = [path for path in records if len(path.points)]
    problem = question.problem
    drawn = f", with the paths of the recommended design from {len(paths)} of {counted(len(problem.starts), 'start')}"
    picture = pictures.map_picture(
        problem.free,
        [problem.named(cell) for cell in problem.goals],
        starts=[problem.named(cell) for cell in problem.starts],
        trajectories=[path.points for path in paths],
        title=f"The map that is planned on{drawn if paths else ''}",
        corner=problem.corner,
    )
    return with_palette(picture)


def advice_html(advice: Advice, question: Question, paths: Sequence[Any] = (), command: str = "") -> str:
    """The page of ``advice_page`` as text."""
    charts = [chart for chart in (price_chart(advice), speed_chart(advice)) if chart is not None]
    best = next((board for board in advice.boards if board.board == advice.recommended), None)
    table = advice_table(advice)
    numbered = Table(
        "All boards",
        (*left("no."), *table.columns),
        tuple((*words(str(number)), *row) for number, row in enumerate(table.rows, 1)),
        table.notes,
        table.strong,
    )
    return rendered(
        "advice.html.j2",
        None,
        title=advice.verdict.partition(":")[0].partition(",")[0],
        advice=advice,
        best=None if best is None or best.design is None else _head(best),
        picture=question_picture(question, paths),
        charts=charts,
        height=_HEIGHT,
        doubts=doubts_table(advice),
        boards=numbered,
        command=command or "hwsw advise",
    )


def _head(board: BoardAdvice) -> list[tuple[str, str]]:
    """The first figures of the board that is recommended."""
    design = board.design
    assert design is not None, "a board suffices by a design"
    price = [] if board.price_usd is None else [(_usd(board.price_usd), "price")]
    rate = [] if design.rate_hz is None else [(quantity_text(design.rate_hz, "Hz"), "plans a second")]
    times = None if board.margin is None else quantity_text(float(f"{board.margin:.3g}"), "")
    margin = [] if times is None else [(f"{times}×", "the rate that is asked for")]
    return [*price, *rate, *margin]


def advice_page(
    advice: Advice, question: Question, path: Path, *, paths: Sequence[Any] = (), command: str = ""
) -> None:
    """Write the page of an answer: question, verdict and doubts, the map, and all boards, drawn and as a table.

    ``paths``: the records of the winner's paths (``PathKeeper``). ``command``: the one that makes the page again.

    Raises:
        RunError: the file cannot be written.
    """
    write_page(path, advice_html(advice, question, paths, command))
