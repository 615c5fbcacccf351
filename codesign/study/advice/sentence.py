"""The verdict in a sentence: the board that suffices, and why no cheaper one does; or what excludes them all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import attrgetter

from more_itertools import map_reduce

from codesign.ground.units import Dimension, counted, format_power, format_quantity
from codesign.study.advice.answer import BoardAdvice, Design, Proof, cheaper_than
from codesign.study.advice.certainty import Certainty, Judged, amount
from codesign.study.advice.needs import Needs
from codesign.study.advice.trials import Shortfall

_MOST_NAMED = 3
"""Boards that a list in a sentence names."""


def verdict(
    boards: Sequence[BoardAdvice],
    needs: Needs,
    alone: Mapping[str, tuple[str, ...]],
    certainty: Certainty | None,
    proof: Proof,
    witness: tuple[BoardAdvice, Certainty | None] | None,
    by_price: Judged | None,
) -> str:
    """The answer.

    ``boards``: best first. ``alone``: see ``met_alone``. ``by_price``: see ``cheapest``. All others: as in ``Advice``.
    """
    best = boards[0]
    if certainty is None or best.design is None:
        nothing = _nothing(boards, needs, alone, proof)
        near = "" if witness is None or witness[1] is None else f". The nearest is {_witness(*witness, needs)}"
        return f"{nothing}{near}{_searched(proof)}"
    time = best.design.trial.time_s
    assert time is not None, "a design that suffices was run"
    taken = time_text(time, certainty.time_low_s, certainty.time_high_s)
    text = (
        f"{best.board} suffices: {design_text(best.design)} answers in {taken},"
        f" {margin_text(best)} {rate_text(needs)} asks"
    )
    sure = "" if certainty.rate.state == "proved" else _surely_fast(boards, needs)
    dearer = f"; {by_price.text}" if by_price is not None and by_price.text else ""
    return f"{text}; {certainty.text}{sure}; {_cheaper(best, boards, needs, proof, witness)}{dearer}"


def _searched(proof: Proof) -> str:
    """The designs that a statement rests on, by what became of them."""
    each = proof.searched
    counts = {
        "excluded by their size": each.unfit,
        "by a bound of their time": each.bound,
        "by a count of their cycles": each.counted,
        "simulated": each.tried,
        "left, as the budget was spent": each.left,
    }
    parts = ", ".join(f"{count:,} {what}" for what, count in counts.items() if count)
    least = "at least " if each.left else ""
    return f" (of {least}{counted(each.designs, 'design')}, {parts})" if each.designs else ""


def _unended(proof: Proof) -> str:
    """The reason why a search did not end."""
    what = "the budget was spent" if proof.searched.left else "the code of a planner failed"
    return f"{what} before all their designs were looked at"


def _surely_fast(boards: Sequence[BoardAdvice], needs: Needs) -> str:
    """The first board with a design that suffices, fits, and is fast enough at every value inside the intervals.

    With a limit on power it is not said: whether a board keeps that is a matter of its own figures.
    """
    if needs.power_w is not None:
        return ""
    others = needs.detour is not None or needs.limits
    for board in boards:
        # The fastest design need not keep the other needs.
        for design in (board.design,) if others else (board.design, board.fastest):
            if not board.suffices or design is None or not design.trial.surely_fits:
                continue
            high = design.trial.time_high_s
            if high is not None and high <= needs.period_s:
                return f"; {board.board} ({cost_text(board)}) is at every value, with {design_text(design)}"
    return "; of the designs that were looked at, none is at every value inside the intervals"


def time_text(time: float, low: float | None, high: float | None) -> str:
    """A time with its interval, s."""
    if low is None or high is None or low == high:
        return amount(time, "s")
    return f"{amount(time, 's')} ({amount(low, 's')} to {amount(high, 's')})"


def design_text(design: Design) -> str:
    """A design in words: its planner, its style, and where it runs."""
    (planning, *others) = design.mapping.items()
    where = f"{design.style} on its {planning[1]['component']}"
    apart = "".join(f", {task} on its {mapped['component']}" for task, mapped in others)
    return f"{design.planner} ({where}{apart})"


def margin_text(board: BoardAdvice) -> str:
    """The factor by which it is faster than asked, in words that end before the rate: ``8 times faster than``."""
    assert board.margin is not None, "a design that suffices was run"
    return f"{board.margin:.3g} times faster than" if board.margin >= 1.05 else "just as fast as"


def rate_text(needs: Needs) -> str:
    """The rate that is asked for."""
    return format_quantity(needs.rate_hz, Dimension.RATE)


def shortfall_text(short: Shortfall, needs: Needs) -> str:
    """The fault that keeps a design from sufficing, and its size."""
    if short.demand is None:
        return short.name if short.need == "refused" else f"its {short.name} is not known"
    demand, limit = amount(short.demand, short.unit), amount(short.limit, short.unit)
    over = amount(short.demand - short.limit, short.unit)
    texts = {
        "figure": f"its {short.name} is {demand}, against {limit}",
        "detour": f"a path is {demand} times the shortest, {limit} is allowed",
        "arrive": f"{demand} of {limit} starts arrive",
        "rate": f"a plan takes {demand}, {short.ratio:.3g} times the {limit} that {rate_text(needs)} leaves",
        "power": f"it draws {demand}, {over} more than {limit}",
        "price": f"it costs {demand}, {over} more than {limit}",
    }
    return texts.get(short.need, f"{short.name}: {demand} against {limit}")


def cost_text(board: BoardAdvice) -> str:
    """The price of a board, or else its mean power."""
    if board.price_usd is not None:
        return amount(board.price_usd, "USD")
    power = None if board.design is None else board.design.mean_power_w
    return f"price not known, {format_power(board.idle_w if power is None else power)}"


def _cheaper(
    best: BoardAdvice,
    boards: Sequence[BoardAdvice],
    needs: Needs,
    proof: Proof,
    witness: tuple[BoardAdvice, Certainty | None] | None,
) -> str:
    dear = best.price_usd is not None
    if witness is None:
        return f"no other board is {'cheaper' if dear else 'of less power of its components'} ({cost_text(best)})"
    if witness[0].suffices:
        # Only a board without a price may come after one with a price.
        return f"{witness[0].board} suffices too ({cost_text(witness[0])})"
    what = "cheaper board" if dear else "board of less power of its components"
    sure = {
        "proved": f"no {what} does, at any value inside the declared intervals",
        "at own values": f"no {what} does, at the figures' own values",
        "not proved": f"no {what} was found to, and {_unended(proof)}",
    }[proof.state]
    others = [board for board in cheaper_than(best, boards) if board.perhaps and board is not witness[0]]
    more = f"; not sure either: {_unsure(others)}" if others else ""
    return f"{sure}{_searched(proof)}; the nearest is {_witness(*witness, needs)}{more}"


def _witness(board: BoardAdvice, certainty: Certainty | None, needs: Needs) -> str:
    """A board that does not suffice: what its best design falls short of, and whether that is sure."""
    why = _main_reason(board, needs)
    if certainty is not None and certainty.text:
        why += f" ({certainty.text})"
    elif board.perhaps and not all(short.is_unknown for short in board.shortfalls):
        why += f" (not sure: {board.perhaps})"
    return f"{board.board} ({cost_text(board)}): {why}"


def _unsure(boards: Sequence[BoardAdvice]) -> str:
    """Boards by the reason why they may suffice, the reason of most boards first."""
    by_reason = map_reduce(boards, attrgetter("perhaps"), attrgetter("board"))
    reasons = sorted(by_reason.items(), key=lambda each: -len(each[1]))
    shown = [f"{_named(names)} ({reason})" for reason, names in reasons[:_MOST_NAMED]]
    left = sum(len(names) for _, names in reasons[_MOST_NAMED:])
    return "; ".join(shown) + (f"; and {counted(left, 'board')} more" if left else "")


def _nothing(boards: Sequence[BoardAdvice], needs: Needs, alone: Mapping[str, tuple[str, ...]], proof: Proof) -> str:
    """No board suffices: the needs that exclude them, each with its nearest board."""
    parts = []
    for need, excluded in map_reduce(boards, lambda board: _worst(board).need).items():
        nearest = min(excluded, key=_distance)
        names = counted(len(excluded), "board") if len(excluded) > 1 else nearest.board
        the_nearest = f"of these the nearest is {nearest.board}: " if len(excluded) > 1 else ""
        parts.append(f"{_NEEDS[need]} excludes {names} ({the_nearest}{_main_reason(nearest, needs)})")
    unsure = [board for board in boards if board.perhaps]
    how = {
        "proved": "no board suffices at any value inside the declared intervals",
        "at own values": "no board suffices at the figures' own values",
        "not proved": f"no board was found to suffice, and {_unended(proof)}",
    }[proof.state]
    text = f"{how}: {'; '.join(parts)}"
    text += f". Not sure, as they may at other values: {_unsure(unsure)}" if unsure else ""
    if len(alone) > 1 and all(alone.values()):
        each = "; ".join(f"{_NEEDS[need]} by {_named(names)}" for need, names in alone.items())
        text += f". Each need alone is met, {each}, but no board meets all of them together"
    return text[0].upper() + text[1:]


_NEEDS = {
    "rate": "the rate",
    "power": "the power",
    "price": "the price",
    "figure": "a limit",
    "detour": "the length of the paths",
    "arrive": "that all starts arrive",
    "fit": "the size of the part or the memory",
    "refused": "what cannot be tried",
}


def _main_reason(board: BoardAdvice, needs: Needs) -> str:
    """The shortfall of a board that is passed by most, with its design."""
    text = shortfall_text(_worst(board), needs)
    return text if board.design is None else f"{text}, with {design_text(board.design)}"


def _worst(board: BoardAdvice) -> Shortfall:
    """The shortfall that is passed by most; one whose demand is not known only where there is no other."""
    return max(board.shortfalls, key=lambda short: (not short.is_unknown, short.ratio))


def _distance(board: BoardAdvice) -> float:
    return _worst(board).ratio


def _named(names: Sequence[str]) -> str:
    more = len(names) - _MOST_NAMED
    return ", ".join(names[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
