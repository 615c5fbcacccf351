"""The certainty of an answer: if a design meets the needs at every value inside the intervals of its figures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, Literal

from pydantic import Field

from codesign.ground.figures import Figure
from codesign.ground.units import (
    PICOSECONDS_PER_SECOND,
    Dimension,
    format_frequency,
    format_power,
    format_quantity,
    format_time,
)
from codesign.inputs.constraint import LOWER, STRICT
from codesign.study.advice.candidates import Board
from codesign.study.advice.needs import Needs
from codesign.study.advice.trials import WORST_TIME, Need, Shortfall, Trial, fit_of, trial_of
from codesign.system.results.model import ResultModel
from codesign.system.results.result import Result
from codesign.system.verdicts import Decider, Fit, Verdict, constraint_verdict, need_verdict, together
from codesign.system.verdicts.fits import ends_text

# A design against the needs: what it falls short of, whether that is sure, and the power of its board.


def mean_power(trial: Trial, board: Board, needs: Needs) -> float | None:
    """Mean power of the components of a board at the rate that is asked for, W; None of a design that was not run.

    The energy of a plan at every period, and the idle power of the board for the rest of the period. A board that is
    too slow plans all the time.
    """
    if trial.energy_j is None or trial.mean_time_s is None:
        return None
    busy = needs.rate_hz * trial.mean_time_s
    if busy >= 1:
        return trial.energy_j / trial.mean_time_s
    return needs.rate_hz * trial.energy_j + (1 - busy) * board.idle_w


def input_power(trial: Trial, board: Board, needs: Needs) -> float | None:
    """Mean power at the input of a board, W: measured while it waits, and what a plan adds to its components' power."""
    power, idle = mean_power(trial, board, needs), board.input_idle_w
    if idle is None:
        return None
    return idle[0] + (0.0 if power is None else max(0.0, power - board.idle_w))


def power_interval(trial: Trial, board: Board, needs: Needs) -> tuple[float, float] | None:
    """Bounds of the mean power at the input inside all intervals, W; without such a figure, of the components' power.

    A component draws no less while it works than while it waits: so the least belongs to the quickest plan, the most
    to the slowest one. Of components alone the upper bound is infinite, as they are a part of a board. None if
    energy or time has no interval.
    """
    # The energy of a plan is that of the mean time.
    ends = trial.mean_low_s, trial.mean_high_s, trial.energy_low_j, trial.energy_high_j
    if None in ends:
        return None
    quick, slow, least, most = (end or 0.0 for end in ends)
    (idle_low, idle_high), at_input = board.idle_interval_w, board.input_idle_w
    often, seldom = (min(needs.rate_hz, 1 / max(time, 1e-12)) for time in (quick, slow))
    if at_input is None:
        return often * least + max(0.0, 1 - needs.rate_hz * quick) * idle_low, math.inf
    adds = often * max(0.0, least - quick * idle_high), seldom * max(0.0, most - slow * idle_low)
    return at_input[1] + adds[0], at_input[2] + adds[1]


def excluded(board: Board, needs: Needs) -> tuple[Shortfall, bool] | None:
    """The need that no design on a board meets, whatever it is, and whether that is sure; None: there is none.

    A board draws at least what it draws while it waits. Power at the input that nobody measured is met by no design.
    """
    for short in _too_dear(board, needs):
        ends = board.price_interval_usd
        return short, ends is not None and ends[0] > short.limit
    idle = board.input_idle_w
    for short in _too_hungry(needs, None if idle is None else idle[0]):
        least = board.idle_interval_w[0] if idle is None else idle[1]
        return short, least > short.limit
    return None


def _too_dear(board: Board, needs: Needs) -> Iterator[Shortfall]:
    """The price of a board that passes what it may cost, or that nobody knows."""
    price, limit = board.price_usd, needs.price_usd
    if limit is not None and (price is None or price > limit):
        yield Shortfall(need="price", name="price", demand=price, limit=limit, unit="USD")


def _too_hungry(needs: Needs, power_w: float | None) -> Iterator[Shortfall]:
    """The power at the input of a board that passes what it may be, or that nobody knows."""
    limit = needs.power_w
    if limit is not None and (power_w is None or power_w > limit):
        name = "power at its input (board.power)" if power_w is None else "mean power"
        yield Shortfall(need="power", name=name, demand=power_w, limit=limit, unit="W")


def shortfalls_of(trial: Trial, board: Board, needs: Needs) -> tuple[Shortfall, ...]:
    """Every need that a design does not meet."""
    short = list(trial.shortfalls)
    if trial.time_s is not None and trial.time_s > needs.period_s:
        short.append(Shortfall(need="rate", name="time of a plan", demand=trial.time_s, limit=needs.period_s, unit="s"))
    if needs.power_w is not None:
        # The power of the components alone may be too much already.
        power, parts = input_power(trial, board, needs), mean_power(trial, board, needs) or board.idle_w
        short += _too_hungry(needs, parts if power is None and parts > needs.power_w else power)
    if (
        needs.detour is not None
        and (trial.detour is None or trial.detour > needs.detour * (1 + ROUNDING))
        and trial.time_s is not None
    ):
        short.append(Shortfall(need="detour", name="length of its paths", demand=trial.detour, limit=needs.detour))
    if trial.time_s is not None:
        short += _beyond(trial, needs)
    return (*short, *_too_dear(board, needs))


def _beyond(trial: Trial, needs: Needs) -> Iterator[Shortfall]:
    """The limits on other figures that a design passes, or has no such figure for."""
    for each in needs.limits:
        value = trial.figures.get(each.figure.name)
        for bound, limit in each.bounds.items():
            kept = value is not None and (
                value > limit * (1 - ROUNDING) if bound in LOWER else value < limit * (1 + ROUNDING)
            )
            if not kept or (value == limit and bound in STRICT):
                unit = {"1": "", "cells": "cells"}.get(each.figure.unit, each.figure.unit)
                yield Shortfall(
                    need="figure", name=each.figure.label, demand=value, limit=limit, unit=unit, lower=bound in LOWER
                )


def may_suffice(trial: Trial, board: Board, needs: Needs) -> str:
    """The reason why a design that falls short may suffice inside the intervals; "" if it falls short everywhere."""
    whys = [_may(short, trial, board, needs) for short in shortfalls_of(trial, board, needs)]
    return "; ".join(dict.fromkeys(whys)) if all(whys) else ""


def _may(short: Shortfall, trial: Trial, board: Board, needs: Needs) -> str:
    """The reason for which a need may be met inside the intervals; "" if it is not."""
    if short.need == "fit":
        return f"whether it fits depends on {trial.may_fit}" if trial.may_fit else ""
    if short.need in {"arrive", "detour", "figure", "refused"}:
        return ""
    if short.demand is None:
        return f"its {short.name} is not known"
    power = power_interval(trial, board, needs)
    least = {
        "rate": trial.time_low_s,
        "power": board.idle_interval_w[0] if power is None else power[0],
        "price": (board.price_interval_usd or (None,))[0],
    }[short.need]
    if least is None:
        return f"its {short.name} has no bound"
    return f"its {short.name} may be as low as {amount(least, short.unit)}" if least <= short.limit else ""


def amount(value: float, unit: str) -> str:
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


ROUNDING = 1e-9
"""Relative: a sum of the lengths of steps may be off by so much."""

Standing = Literal["holds", "fails", "depends"]


class Judged(ResultModel):
    """A need of one design: if it is met at every value inside the intervals of all figures, at none, or at some."""

    need: Need = Field(description="the need")
    state: Standing = Field(description="holds: at every value; fails: at none; depends: at some, or not known")
    name: str = Field(default="", description="the figure that it depends on")
    changes_at: float | None = Field(
        default=None, description="the value of that figure at which it changes, all others at their own, in unit"
    )
    together: dict[str, float] = Field(
        default={},
        description="where none changes it by itself: the figures that do together, each moved by the same share of the"
        " way to an end of its interval, with their values there, in their own units",
    )
    value: float | None = Field(default=None, description="its own value; None where it is not known")
    low: float | None = Field(default=None, description="least value of its interval")
    high: float | None = Field(default=None, description="greatest value of its interval")
    unit: str = Field(default="", description="unit of these")
    source: str = Field(default="", description="status and source of that figure")
    text: str = Field(description="the same in words; empty where it holds")


class Certainty(ResultModel):
    """The certainty that a design meets the needs, or that it does not."""

    state: Standing = Field(description="holds where every need does, fails where one does, else depends")
    needs: tuple[Judged, ...] = Field(description="each need that is asked for")
    time_low_s: float | None = Field(description="least time of a plan inside all intervals, the clock's too, s")
    time_high_s: float | None = Field(description="greatest, s")
    least_clock_hz: float | None = Field(
        description="the slowest clock of the fabric at which it is fast enough, other figures at their own values, Hz"
    )
    power_low_w: float | None = Field(
        description="a lower bound of the mean power at the input of the board inside all intervals, W"
    )
    power_high_w: float | None = Field(description="an upper bound of it, W; None without a power of the whole board")
    rate: Verdict = Field(description="the time of a plan against the period that is asked for")
    fit: Fit = Field(description="the design against the share of its part that it may use")
    text: str = Field(description="the same in words")


def certainty_of(result: Result, board: Board, needs: Needs) -> Certainty:
    """The certainty that the design of a result meets the needs on a board. Mean power: see ``power_interval``."""
    trial = trial_of(result)
    power = power_interval(trial, board, needs)
    rate, fit = need_verdict(result, WORST_TIME, needs.period_s), fit_of(result)
    clock = least_clock(result, needs.period_s)
    judged = [_fit(fit)]
    judged += [Judged(need="arrive", state="fails", text=_arrive_text(trial))] if trial.arrived < trial.starts else []
    for limit in needs.limits:
        held = constraint_verdict(result, limit)
        state: Standing = {"proved": "holds", "refuted": "fails"}.get(held.state, "depends")  # type: ignore[assignment]
        text = (
            ""
            if state == "holds"
            else f"{limit.figure.label} {'passes its limit' if state == 'fails' else 'may pass its limit'}"
        )
        judged.append(Judged(need="figure", state=state, name=limit.figure.name, text=text))
    if needs.detour is not None and trial.detour is not None:
        longer = trial.detour > needs.detour * (1 + ROUNDING)
        text = f"a path is {trial.detour:.4g} times the shortest" if longer else ""
        judged.append(Judged(need="detour", state="fails" if longer else "holds", text=text))
    if trial.time_s is not None:
        judged.append(_rate(rate, result, clock, needs.period_s))
    judged += _power(power, needs)
    judged += _price(board, needs)
    order: tuple[Standing, ...] = ("fails", "depends", "holds")
    state = min((each.state for each in judged), key=order.index)
    down = _clock_text(result, clock)
    holds = f"holds at every value inside the declared intervals{_late_text(result)}{down and f', {down}'}"
    return Certainty(
        state=state,
        needs=tuple(judged),
        time_low_s=trial.time_low_s,
        time_high_s=trial.time_high_s,
        least_clock_hz=clock,
        power_low_w=None if power is None else power[0],
        power_high_w=None if power is None or math.isinf(power[1]) else power[1],
        rate=rate,
        fit=fit,
        text="; ".join(each.text for each in judged if each.state == state) if state != "holds" else holds,
    )


def least_clock(result: Result, period_s: float) -> float | None:
    """The slowest clock of the fabric at which a plan takes at most ``period_s``, Hz; None where no clock moves it.

    Other figures are at their own values. A time is a sum of a constant and of cycles over the clock.
    """
    name = f"{result.component}.clock"
    if result.terms is None or name not in result.terms.inputs:
        return None
    values = {each: figure.value for each, figure in result.terms.inputs.items()}
    clocks = [0.0]
    for plan in result.terms.plans(WORST_TIME.name):
        fixed = sum(float(term.at(values)) for term in plan if name not in term.powers)
        cycles = sum(float(term.at(values)) for term in plan if name in term.powers) * values[name]
        clocks.append(cycles / (period_s - fixed) if fixed < period_s else math.inf)
    return max(clocks) or None


def _late_text(result: Result) -> str:
    """The words for a declared load or jitter: its bound is no proof. "" where none is declared."""
    paces = () if result.terms is None else (name for name in result.terms.inputs if name.endswith(".pace"))
    return "".join(f", with {name} at its least (jitter counts to its 99th percentile)" for name in paces)


def _clock_text(result: Result, least: float | None) -> str:
    """The clock down to which a verdict about time holds, and the clocks that the circuit reaches by its law."""
    if least is None or result.clock is None or not math.isfinite(least):
        return ""
    ends = " to ".join(_figure_text(end, "Hz") for end in result.clock.limit.interval)
    return f"down to a clock of {_figure_text(least, 'Hz')} (by its law it reaches {ends})"


def _rate(rate: Verdict, result: Result, clock: float | None, period_s: float) -> Judged:
    if rate.state == "proved":
        return Judged(need="rate", state="holds", text="")
    if rate.state == "refuted":
        return Judged(need="rate", state="fails", text="too slow at every value inside the declared intervals")
    if rate.decides is None:
        text = f"whether it is fast enough is not assessed: {rate.reason}"
        return Judged(need="rate", state="depends", text=text)
    figure, flips = rate.decides.figure, rate.decides.flips_at
    several = () if flips is not None else together(result, WORST_TIME, period_s)
    name, own = _name_text(rate.decides, result), _interval_text(figure)
    if flips is not None:
        text = f"whether it is fast enough depends on {name}, and changes at {_figure_text(flips, figure.unit)} ({own})"
    elif several:
        text = (
            f"whether it is fast enough depends on several figures at once: it changes where {_places(several, result)}"
        )
    else:
        text = f"whether it is fast enough is not sure: {rate.reason}; {name} moves it most ({own})"
    # The widest figure need not be the clock: a clock that flips it is said too.
    limit = None if result.clock is None else result.clock.limit
    if clock is not None and limit is not None and limit.interval[0] < clock <= limit.interval[1]:
        down = _clock_text(result, clock) if rate.decides.name != f"{result.component}.clock" else ""
        text += down and f"; it is fast enough {down}"
    values = {_name_text(each, result): each.flips_at for each in several if each.flips_at is not None}
    return Judged(need="rate", state="depends", changes_at=flips, text=text, together=values, **_decider(name, figure))


def _name_text(decides: Decider, result: Result) -> str:
    """A figure with the platform that declares it."""
    name = f"{decides.platform}'s {decides.name}" if decides.platform else decides.name
    return f"the clock that its circuit reaches ({name})" if decides.name == f"{result.component}.clock" else name


def _interval_text(figure: Figure) -> str:
    low, high = (_figure_text(end, figure.unit) for end in figure.interval)
    return f"{figure.status} {_figure_text(figure.value, figure.unit)}, {low} to {high}"


_MOST_PLACES = 3
"""Figures of several that a sentence names."""


def _places(several: Sequence[Decider], result: Result) -> str:
    """The values of several figures, those that move most."""
    shown = [
        f"{_name_text(each, result)} is {_figure_text(each.flips_at, each.figure.unit)} ({_interval_text(each.figure)})"
        for each in several[:_MOST_PLACES]
        if each.flips_at is not None
    ]
    left = len(several) - _MOST_PLACES
    return ", ".join(shown) + (f", and {left} more by the same share of their intervals" if left > 0 else "")


def _decider(name: str, figure: Figure) -> dict[str, Any]:
    low, high = map(float, figure.interval)
    source = f"{figure.status}: {figure.source}"
    return {"name": name, "value": float(figure.value), "low": low, "high": high, "unit": figure.unit, "source": source}


def _figure_text(value: float, unit: str) -> str:
    if unit == "s":
        return format_time(round(value * PICOSECONDS_PER_SECOND))
    if unit == "Hz":
        return format_frequency(round(float(f"{value:.3g}")))
    return f"{value:.4g} {unit}".removesuffix(" 1")


def _power(power: tuple[float, float] | None, needs: Needs) -> list[Judged]:
    if needs.power_w is None:
        return []
    if power is None or (math.isinf(power[1]) and power[0] <= needs.power_w):
        text = "its power at its input (board.power) is not known"
        return [Judged(need="power", state="depends", name="board.power", unit="W", text=text)]
    low, high = ("" if math.isinf(watts) else format_power(float(f"{watts:.3g}")) for watts in power)
    if power[1] <= needs.power_w:
        return [Judged(need="power", state="holds", low=power[0], high=power[1], unit="W", text="")]
    fails = power[0] > needs.power_w
    text = f"it draws {low} at least" if fails else f"its mean power may be {low} to {high}"
    most = None if math.isinf(power[1]) else power[1]
    state: Standing = "fails" if fails else "depends"
    name, limit = ("", None) if fails else ("mean power", needs.power_w)
    return [
        Judged(need="power", state=state, name=name, changes_at=limit, low=power[0], high=most, unit="W", text=text)
    ]


def _price(board: Board, needs: Needs) -> list[Judged]:
    if needs.price_usd is None:
        return []
    ends = board.price_interval_usd
    if ends is None:
        return [Judged(need="price", state="depends", name="board.price", unit="USD", text="its price is not known")]
    low, high = ends
    state: Standing = "holds" if high <= needs.price_usd else "fails" if low > needs.price_usd else "depends"
    texts = {"holds": "", "fails": f"it costs {low:,.4g} USD at least"}
    text = texts.get(state, f"its price may be {low:,.4g} USD to {high:,.4g} USD")
    at = needs.price_usd if state == "depends" else None
    return [
        Judged(
            need="price",
            state=state,
            name="board.price",
            changes_at=at,
            value=board.price_usd,
            low=low,
            high=high,
            unit="USD",
            text=text,
        )
    ]


def _arrive_text(trial: Trial) -> str:
    return f"{trial.arrived} of {trial.starts} starts arrive"


def _fit(fit: Fit) -> Judged:
    if fit.fits == "yes":
        return Judged(need="fit", state="holds", text="")
    if fit.demand is None:
        return Judged(need="fit", state="fails", name=fit.decides, text=f"it does not fit: {fit.decides}")
    words = "it does not fit at any value: " if fit.fits == "no" else "whether it fits depends on "
    more = {} if fit.figure is None else _decider(fit.decides, fit.figure)
    state: Standing = "fails" if fit.fits == "no" else "depends"
    return Judged(need="fit", state=state, changes_at=fit.flips_at, text=f"{words}{ends_text(fit)}", **more)
