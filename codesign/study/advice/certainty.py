"""The certainty of an answer: if a design meets the needs at every value inside the intervals of its figures."""

from __future__ import annotations

import math

from pydantic import Field

from codesign.ground.units import format_frequency, format_power, format_time
from codesign.study.advice.boards import Board
from codesign.study.advice.needs import Needs
from codesign.study.advice.shortfalls import power_interval
from codesign.study.advice.trials import WORST_TIME, trial_of
from codesign.system.results.model import ResultModel
from codesign.system.results.result import Result
from codesign.system.verdicts import Fit, Verdict, fit_verdict, need_verdict
from codesign.system.verdicts.fits import ends_text


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
        text="; ".join(open_texts) or "proved at every value inside the declared intervals",
    )


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
    value = format_time(round(flips * 1e12)) if unit == "s" else f"{flips:.4g} {unit}"
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
