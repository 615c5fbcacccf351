"""The verdict in a sentence: the board that suffices, and why no cheaper one does; or what excludes them all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from codesign.advice.answer import BoardAdvice, Design, cheaper_than
from codesign.advice.certainty import Certainty
from codesign.advice.needs import Needs
from codesign.advice.trials import Shortfall
from codesign.units import (
    PICOSECONDS_PER_SECOND,
    Dimension,
    counted,
    format_power,
    format_quantity,
    format_time,
)

_MOST_NAMED = 3
"""Boards that a list in a sentence names."""


def verdict(
    boards: Sequence[BoardAdvice],
    needs: Needs,
    alone: Mapping[str, tuple[str, ...]],
    certainty: Certainty | None,
    next_certainty: Certainty | None,
    *,
    complete: bool = True,
) -> str:
    """The answer. ``boards``: best first. ``alone``: see ``met_alone``. The certainties are those of ``Advice``.

    ``complete``: whether every design was searched. If not, "no board suffices" would say more than is known.
    """
    best = boards[0]
    if certainty is None or best.design is None:
        nothing = _nothing(boards, needs, alone)
        if complete:
            return nothing
        return (
            f"No answer yet, as the budget was spent: of what was searched, {nothing[0].lower()}{nothing[1:]}"
        )
    time = best.design.trial.time_s
    assert time is not None, "a design that suffices was run"
    text = (
        f"{best.board} suffices: {design_text(best.design)} answers in {_time(time, certainty)},"
        f" {margin_text(best)} {rate_text(needs)} asks"
    )
    sure = "" if certainty.rate.state == "proved" else _surely_fast(boards, needs)
    return f"{text}; {certainty.text}{sure}; {_cheaper(best, boards, needs, next_certainty)}"


def _surely_fast(boards: Sequence[BoardAdvice], needs: Needs) -> str:
    """The first board that suffices with a design that fits and is fast enough at every value inside the intervals."""
    for board in boards:
        for design in (board.design, board.fastest):
            if not board.suffices or design is None or not design.trial.surely_fits:
                continue
            high = design.trial.time_high_s
            if high is not None and high <= needs.period_s:
                return f"; {board.board} ({cost_text(board)}) is at every value, with {design_text(design)}"
    return "; no board is at every value inside the intervals"


def _time(time: float, certainty: Certainty) -> str:
    """A time with its interval."""
    low, high = certainty.time_low_s, certainty.time_high_s
    if low is None or high is None or low == high:
        return _amount(time, "s")
    return f"{_amount(time, 's')} ({_amount(low, 's')} to {_amount(high, 's')})"


def design_text(design: Design) -> str:
    """A design in words: its planner, its style, and where it runs."""
    (planning, *others) = design.mapping.items()
    where = f"{design.style} on its {planning[1]['component']}"
    apart = "".join(f", {task} on its {mapped['component']}" for task, mapped in others)
    return f"{design.planner} ({where}{apart})"


def margin_text(board: BoardAdvice) -> str:
    """How many times faster than asked, in words that end before the rate: ``8 times faster than``."""
    assert board.margin is not None, "a design that suffices was run"
    return f"{board.margin:.3g} times faster than" if board.margin >= 1.05 else "just as fast as"


def rate_text(needs: Needs) -> str:
    """The rate that is asked for."""
    return format_quantity(needs.rate_hz, Dimension.RATE)


def shortfall_text(short: Shortfall, needs: Needs) -> str:
    """What keeps a design from sufficing, and by how much."""
    if short.demand is None:
        return short.name if short.need == "refused" else f"its {short.name} is not known"
    demand, limit = _amount(short.demand, short.unit), _amount(short.limit, short.unit)
    over = _amount(short.demand - short.limit, short.unit)
    texts = {
        "arrive": f"{demand} of {limit} starts arrive",
        "rate": f"a plan takes {demand}, {short.ratio:.3g} times the {limit} that {rate_text(needs)} leaves",
        "power": f"it draws {demand}, {over} more than {limit}",
        "price": f"it costs {demand}, {over} more than {limit}",
    }
    return texts.get(short.need, f"{short.name}: {demand} against {limit}")


def cost_text(board: BoardAdvice) -> str:
    """The price of a board, or else its mean power."""
    if board.price_usd is not None:
        return _amount(board.price_usd, "USD")
    power = None if board.design is None else board.design.mean_power_w
    return f"price not known, {format_power(board.idle_w if power is None else power)}"


def _cheaper(
    best: BoardAdvice, boards: Sequence[BoardAdvice], needs: Needs, next_certainty: Certainty | None
) -> str:
    cheaper = cheaper_than(best, boards)
    what = "cheaper" if best.price_usd is not None else "of less mean power"
    if not cheaper:
        return f"no other board is {what} ({cost_text(best)})"
    first = cheaper[0]
    if first.suffices:
        # Only a board without a price may come after one with a price.
        return f"{first.board} suffices too ({cost_text(first)})"
    why = _main_reason(first, needs)
    if next_certainty is not None:
        why += f" ({next_certainty.text})"
    return f"nothing {what} does: the next, {first.board} ({cost_text(first)}), fails: {why}"


def _nothing(boards: Sequence[BoardAdvice], needs: Needs, alone: Mapping[str, tuple[str, ...]]) -> str:
    """No board suffices: the needs that exclude them, each with its nearest board."""
    by_need: dict[str, list[BoardAdvice]] = {}
    for board in boards:
        worst = max(board.shortfalls, key=lambda short: short.ratio)
        by_need.setdefault(worst.need, []).append(board)
    parts = []
    for need, excluded in by_need.items():
        nearest = min(excluded, key=_distance)
        names = counted(len(excluded), "board") if len(excluded) > 1 else nearest.board
        the_nearest = f"of these the nearest is {nearest.board}: " if len(excluded) > 1 else ""
        parts.append(f"{_NEEDS[need]} excludes {names} ({the_nearest}{_main_reason(nearest, needs)})")
    text = f"no board suffices: {'; '.join(parts)}"
    if len(alone) > 1 and all(alone.values()):
        each = "; ".join(f"{_NEEDS[need]} by {_named(names)}" for need, names in alone.items())
        text += f". Each need alone is met, {each}, but no board meets all of them together"
    return text[0].upper() + text[1:]


_NEEDS = {
    "rate": "the rate",
    "power": "the power",
    "price": "the price",
    "arrive": "that all starts arrive",
    "fit": "the size of the part or the memory",
    "refused": "what the platform lacks or the budget left out",
}


def _main_reason(board: BoardAdvice, needs: Needs) -> str:
    """The shortfall of a board that is passed by most, with its design."""
    worst = max(board.shortfalls, key=lambda short: short.ratio)
    text = shortfall_text(worst, needs)
    return text if board.design is None else f"{text}, with {design_text(board.design)}"


def _distance(board: BoardAdvice) -> float:
    return max(short.ratio for short in board.shortfalls)


def _named(names: Sequence[str]) -> str:
    more = len(names) - _MOST_NAMED
    return ", ".join(names[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


def _amount(value: float, unit: str) -> str:
    """A number in ``unit`` for people."""
    if unit == "s":
        return format_time(round(float(f"{value:.3g}") * PICOSECONDS_PER_SECOND))
    if unit in _DIMENSIONS:
        return format_quantity(value, _DIMENSIONS[unit], 3)
    return f"{number_text(value)} {unit}".rstrip()


def number_text(value: float) -> str:
    """A number with at most two decimals.

    >>> number_text(31.5), number_text(1500)
    ('31.5', '1,500')
    """
    return f"{value:,.2f}".rstrip("0").rstrip(".")


_DIMENSIONS = {"W": Dimension.POWER, "Hz": Dimension.FREQUENCY}
