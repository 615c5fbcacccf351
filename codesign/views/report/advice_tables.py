"""The tables of an answer about boards."""

from __future__ import annotations

from collections.abc import Sequence

from more_itertools import map_reduce

from codesign.ground.figures import label
from codesign.ground.units import counted
from codesign.study.advice.answer import Advice, BoardAdvice, Design
from codesign.study.advice.certainty import number_text
from codesign.study.advice.motion import Driven
from codesign.study.advice.needs import Needs
from codesign.study.advice.sentence import design_text, shortfall_text
from codesign.system.results.result import reach_text
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
    yes_cell,
)

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
