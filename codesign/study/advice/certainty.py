"""The certainty of an answer: if a design meets the needs at every value inside the intervals of its figures."""

from __future__ import annotations

import math

from pydantic import Field

from codesign.ground.units import (
    PICOSECONDS_PER_SECOND,
    Dimension,
    format_frequency,
    format_power,
    format_quantity,
    format_time,
)
from codesign.study.advice.candidates import Board
from codesign.study.advice.needs import Needs
from codesign.study.advice.trials import WORST_TIME, Shortfall, Trial, trial_of
from codesign.system.results.model import ResultModel
from codesign.system.results.result import Result
from codesign.system.verdicts import Fit, Verdict, fit_verdict, need_verdict
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
    ends = trial.time_low_s, trial.time_high_s, trial.energy_low_j, trial.energy_high_j
    if None in ends:
        return None
    quick, slow, least, most = (end or 0.0 for end in ends)
    (idle_low, idle_high), at_input = board.idle_interval_w, board.input_idle_w
    often, seldom = (min(needs.rate_hz, 1 / max(time, 1e-12)) for time in (quick, slow))
    if at_input is None:
        return often * least + max(0.0, 1 - needs.rate_hz * quick) * idle_low, math.inf
    adds = often * max(0.0, least - quick * idle_high), seldom * max(0.0, most - slow * idle_low)
    return at_input[1] + adds[0], at_input[2] + adds[1]


def shortfalls_of(trial: Trial, board: Board, needs: Needs) -> tuple[Shortfall, ...]:
    """Every need that a design does not meet."""
    short = list(trial.shortfalls)
    if trial.time_s is not None and trial.time_s > needs.period_s:
        short.append(Shortfall(need="rate", name="time of a plan", demand=trial.time_s, limit=needs.period_s, unit="s"))
    if needs.power_w is not None:
        power, parts = input_power(trial, board, needs), mean_power(trial, board, needs) or board.idle_w
        lowest = parts if power is None else power
        name, demand = "mean power", lowest if lowest > needs.power_w else power
        if demand is None:
            name = "power at its input (board.power)"
        if demand is None or demand > needs.power_w:
            short.append(Shortfall(need="power", name=name, demand=demand, limit=needs.power_w, unit="W"))
    if needs.price_usd is not None and (board.price_usd is None or board.price_usd > needs.price_usd):
        price = board.price_usd
        short.append(Shortfall(need="price", name="price", demand=price, limit=needs.price_usd, unit="USD"))
    return tuple(short)


def may_suffice(trial: Trial, board: Board, needs: Needs) -> str:
    """The reason why a design that falls short may suffice inside the intervals; "" if it falls short everywhere."""
    whys = [_may(short, trial, board, needs) for short in shortfalls_of(trial, board, needs)]
    return "; ".join(dict.fromkeys(whys)) if all(whys) else ""


def _may(short: Shortfall, trial: Trial, board: Board, needs: Needs) -> str:
    """The reason for which a need may be met inside the intervals; "" if it is not."""
    if short.need == "fit":
        return f"whether it fits depends on {trial.may_fit}" if trial.may_fit else ""
    if short.need in {"arrive", "refused"}:
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


class Certainty(ResultModel):
    """The certainty that a design meets the needs, or that it does not."""

    time_low_s: float | None = Field(description="least time of a plan inside all intervals, s")
    time_high_s: float | None = Field(description="greatest, s")
    power_low_w: float | None = Field(
        description="a lower bound of the mean power at the input of the board inside all intervals, W"
    )
    power_high_w: float | None = Field(description="an upper bound of it, W; None without a power of the whole board")
    rate: Verdict = Field(description="the time of a plan against the period that is asked for")
    fit: Fit = Field(description="the design against its part")
    text: str = Field(description="the same in words")


def certainty_of(result: Result, board: Board, needs: Needs) -> Certainty:
    """The certainty that the design of a result meets the needs on a board. Mean power: see ``power_interval``."""
    trial = trial_of(result)
    power = power_interval(trial, board, needs)
    rate, fit = need_verdict(result, WORST_TIME, needs.period_s), fit_verdict(result)
    texts = [_rate_text(rate), _power_text(power, needs), _price_text(board, needs), _fit_text(fit)]
    open_texts = [text for text in texts if text]
    return Certainty(
        time_low_s=trial.time_low_s,
        time_high_s=trial.time_high_s,
        power_low_w=None if power is None else power[0],
        power_high_w=None if power is None or math.isinf(power[1]) else power[1],
        rate=rate,
        fit=fit,
        text="; ".join(open_texts) or f"proved at every value inside the declared intervals{_late_text(result)}",
    )


def _late_text(result: Result) -> str:
    """The words for a declared load or jitter: its bound is no proof. "" where none is declared."""
    paces = () if result.terms is None else (name for name in result.terms.inputs if name.endswith(".pace"))
    return "".join(f", with {name} at its least (jitter counts to its 99th percentile)" for name in paces)


def _rate_text(rate: Verdict) -> str:
    if rate.state == "proved":
        return ""
    if rate.state == "refuted":
        return "too slow at every value inside the declared intervals"
    if rate.decides is None:
        return f"whether it is fast enough is not assessed: {rate.reason}"
    name = f"{rate.decides.platform}'s {rate.decides.name}" if rate.decides.platform else rate.decides.name
    flips = rate.decides.flips_at
    if flips is None:
        return f"whether it is fast enough is not sure: {rate.reason}; {name} moves it most"
    unit = rate.decides.figure.unit
    value = format_time(round(flips * 1e12)) if unit == "s" else f"{flips:.4g} {unit}".removesuffix(" 1")
    return f"whether it is fast enough depends on {name}, and changes at {value}"


def _power_text(power: tuple[float, float] | None, needs: Needs) -> str:
    if needs.power_w is None or (power is not None and power[1] <= needs.power_w):
        return ""
    if power is None or math.isinf(power[1]):
        return "its mean power at its input has no bound"
    low, high = (format_power(float(f"{watts:.3g}")) for watts in power)
    return f"its mean power may be {low} to {high}"


def _price_text(board: Board, needs: Needs) -> str:
    price = board.price_interval_usd
    if needs.price_usd is None or price is None or price[1] <= needs.price_usd:
        return ""
    return f"its price may be {price[0]:,.4g} USD to {price[1]:,.4g} USD"


def _fit_text(fit: Fit) -> str:
    if fit.fits == "yes":
        return ""
    if fit.decides == "clock" and fit.demand is not None and fit.limit is not None:
        low, high = (format_frequency(hertz) for hertz in fit.limit)
        clock = format_frequency(fit.demand[0])
        return f"whether it runs at {clock} is not sure, as the limit of its clock is {low} to {high}"
    if fit.fits == "no":
        return f"it does not fit at any value: {ends_text(fit)}"
    return f"whether it fits depends on {ends_text(fit)}"
