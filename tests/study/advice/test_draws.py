"""Draws of all figures inside their intervals: none contradicts what an answer says of a need."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import reduce
from itertools import chain, islice, product
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.errors import CodesignError
from codesign.ground.figures import Figure, Status
from codesign.study import advice
from codesign.study.advice.candidates import LOGIC, Board, arrangements_of
from codesign.study.advice.certainty import Certainty, Judged, certainty_of
from codesign.study.advice.needs import Needs, Question
from codesign.study.advice.trials import MEAN_TIME, WORST_TIME, Laboratory, as_asked
from codesign.system.results.result import Result
from codesign.system.results.terms import is_edges

Floats = NDArray[np.float64]

BOARDS = "kv260", "ultra96-v2", "arty-a7-spi", "icesugar", "virtex2-pci", "raspberry-pi-4", "nucleo-h743zi", "pico-2"
"""Boards with and without an FPGA, a plug power and a price, with short memory, over buses and SPI."""

DRAWS = 100
"""Draws of each question about a result."""

ROUNDING = 1e-9
"""Relative: a sum in another order may be off by so much, and a time is in whole picoseconds."""


class Asked(NamedTuple):
    """A design that was run, on its board."""

    board: Board
    result: Result


@pytest.fixture(scope="module")
def question(tmp_path_factory: pytest.TempPathFactory) -> Question:
    """Of a map with starts near to the goal and far from it: so the mean time is far below the worst one."""
    free = maps.random_obstacles(24, 24, density=0.2, seed=1).free
    path = tmp_path_factory.mktemp("draws") / "map.txt"
    path.write_text("".join("".join(".#"[1 - int(cell)] for cell in row) + "\n" for row in free), encoding="utf-8")
    cells = np.argwhere(maps.reachable(free, [maps.nearest_free(free, (0, 0))]))
    (goal, *starts) = (f"{row},{column}" for row, column in cells[[0, 1, 2, 3, 4, -1]])
    needs = advice.parse_needs("10 Hz")
    return advice.ask(needs, advice.problem_section(path, [goal], starts, needs), path)


@pytest.fixture(scope="module")
def designs(question: Question) -> list[Asked]:
    """The first designs of every arrangement of the boards."""
    laboratory, found = Laboratory(question), []
    for board in advice.boards_of(BOARDS):
        for arrangement in arrangements_of(board, question.problem, question.needs):
            for family in islice(arrangement.families(), 1):
                for design in family.chain[:1]:
                    with suppress(CodesignError):
                        result = laboratory.result(arrangement.candidate(design))
                        if result.interval(WORST_TIME) is not None:
                            found.append(Asked(board, result))
    return found + list(chain.from_iterable(smaller(each) for each in found[::5]))


def smaller(asked: Asked) -> Iterator[Asked]:
    """A design on parts whose logic it takes at some values inside the intervals, or exceeds at all."""
    for use in asked.result.resources:
        low, high = (sum(item.figure.interval[end] for item in use.items) for end in (0, 1))
        if use.resource in LOGIC and use.budget > high > low > 2:
            for budget in ((low + high) / 2, low - 1):
                yield Asked(asked.board, as_asked(asked.result, budget / use.budget))


class Drawn(NamedTuple):
    """What a design comes to in each draw. ``power``: at the input of its board; None where that is not known."""

    time: Floats
    fits: NDArray[np.bool_]
    power: Floats | None
    price: Floats | None


def drawn(figures: Mapping[str, Figure], whole: set[str], generator: np.random.Generator) -> dict[str, Floats]:
    """Values inside the intervals, every second one at an end of each."""
    values = {}
    for name, figure in figures.items():
        low, high = map(float, figure.interval)
        inside = generator.uniform(low, high, DRAWS)
        ends = np.where(generator.random(DRAWS) < 0.5, low, high)
        column = np.where(np.arange(DRAWS) % 2, inside, ends)
        values[name] = np.clip(np.round(column), low, high) if name in whole else column
    return values


def greatest(plans: Sequence[Sequence[Any]], values: Mapping[str, Any]) -> Any:
    return reduce(np.maximum, [sum(term.at(values) for term in plan) for plan in plans])


def draw(asked: Asked, needs: Needs, generator: np.random.Generator) -> Drawn:
    """What the design comes to where all figures are drawn."""
    board, result = asked
    assert result.terms is not None
    inputs, column = result.terms.inputs, lambda figure: drawn({"": figure}, set(), generator)[""]
    plans = [result.terms.plans(name) for name in (WORST_TIME.name, MEAN_TIME.name, "energy_j")]
    whole = {name for of in plans for plan in of for term in plan for name in term.by}
    values = drawn(inputs, whole, generator)
    time, mean, energy = (greatest(of, values) if of else None for of in plans)
    fits = np.ones(DRAWS, np.bool_)
    for use in result.resources:
        fits &= sum(column(item.figure) for item in use.items) <= use.budget
    for bound in result.bounds:
        fits &= column(bound.figure) <= column(bound.limit)
    power, plug = None, board.input_idle_w
    if plug is not None and energy is not None:
        still = {name: figure for name, figure in inputs.items() if name.endswith((".power.idle", ".power.static"))}
        names = [next((name for name, each in still.items() if each == figure), None) for figure in board._idle]
        own = zip(names, board._idle, strict=True)
        idle = sum(column(figure) if name is None else values[name] for name, figure in own)
        busy = needs.rate_hz * mean
        parts = np.where(busy >= 1, energy / mean, needs.rate_hz * energy + (1 - busy) * idle)
        waiting = Figure(plug[0], "W", Status.MEASURED, "", plug[1], plug[2])
        power = column(waiting) + np.maximum(0.0, parts - idle)
    price = None if board.prices is None else sum(map(column, board.prices.values()))
    return Drawn(time, fits, power, price)


@pytest.fixture(scope="module")
def answers(designs: list[Asked], question: Question) -> list[tuple[Asked, Needs, Certainty]]:
    """What is said of each design, for needs that it meets at all values, at some and at none."""
    return [(asked, *each) for asked in designs for each in questions(asked, question.needs)]


def questions(asked: Asked, needs: Needs) -> Iterator[tuple[Needs, Certainty]]:
    """Needs below, inside and above what the design may come to, with what is said of them."""
    board, result = asked
    low, high = result.interval(WORST_TIME) or (1e-3, 1e-3)
    value = result.figure(WORST_TIME) or low
    wattages: tuple[float | None, ...] = (None,)
    if board.input_idle_w is not None:
        full = certainty_of(result, board, needs.model_copy(update={"rate_hz": 1 / low, "power_w": 1.0}))
        ends = [full.power_low_w, full.power_high_w]
        wattages = tuple(end * share for end in ends if end is not None for share in (1 - 1e-6, 1 + 1e-6))
    usd = board.price_interval_usd
    prices = (None,) if usd is None else (usd[0] * 0.9, sum(usd) / 2, usd[1])
    periods = low * 0.999, (low + value) / 2, (value + high) / 2, high * 0.999, high * 1.001
    for number, (period, power_w) in enumerate(product(periods, wattages)):
        limits = {"rate_hz": 1 / period, "power_w": power_w, "price_usd": prices[number % len(prices)]}
        own = needs.model_copy(update=limits)
        yield own, certainty_of(result, board, own)


def met(need: str, drawn: Drawn, needs: Needs) -> NDArray[np.bool_] | None:
    """Whether a need is met in each draw; None where no figure stands for it."""
    slack = 1 + ROUNDING
    if need == "rate":
        return drawn.time <= needs.period_s * slack + 1e-10
    if need == "fit":
        return drawn.fits
    column, limit = {"power": (drawn.power, needs.power_w), "price": (drawn.price, needs.price_usd)}[need]
    return None if column is None or limit is None else column <= limit * slack


def test_no_draw_contradicts_what_holds_or_fails(answers: list[tuple[Asked, Needs, Certainty]]) -> None:
    generator, states, draws = np.random.default_rng(7), set(), 0
    for asked, needs, certainty in answers:
        values = draw(asked, needs, generator)
        draws += DRAWS
        for each in certainty.needs:
            if each.need not in ("rate", "fit", "power", "price") or each.state == "depends":
                continue
            held = met(each.need, values, needs)
            what = f"{asked.board.name}, {asked.result}: {each} of {needs}"
            assert held is not None, what
            states.add((each.need, each.state))
            assert held.all() if each.state == "holds" else not held.any(), what
    assert states == set(product(("rate", "fit", "power", "price"), ("holds", "fails")))
    assert draws >= 10_000


def alone(asked: Asked, each: Judged, value: float, needs: Needs) -> bool:
    """Whether a need is met where the figure that it depends on has this value, and all others their own."""
    result = asked.result
    if each.need == "price":
        return needs.price_usd is None or value <= needs.price_usd
    if each.need == "rate":
        assert result.terms is not None
        values = {name: float(figure.value) for name, figure in result.terms.inputs.items()}
        (name,) = (name for name, figure in result.terms.inputs.items() if not is_edges(name) and name in each.text)
        return bool(greatest(result.terms.plans(WORST_TIME.name), values | {name: value}) <= needs.period_s)
    ((items, limit),) = [
        ([item.figure for item in use.items], float(use.budget))
        for use in result.resources
        if use.resource == each.name
    ] or [([bound.figure], float(bound.limit.value)) for bound in result.bounds if bound.name == each.name]
    own = (each.value, each.low, each.high)
    widest = next((one for one in items if (one.value, *one.interval) == own), None)
    others = sum(float(one.value) for one in items if one is not widest)
    # The figure is one of the demand, or the limit.
    return others <= value if widest is None else others + value <= limit


def test_a_figure_alone_changes_what_depends_on_it_where_it_is_said(
    answers: list[tuple[Asked, Needs, Certainty]],
) -> None:
    changed: dict[str, int] = {}
    for asked, needs, certainty in answers:
        for each in certainty.needs:
            if each.state != "depends" or each.changes_at is None or each.need == "power":
                continue
            whole = each.unit == "1" or each.need == "fit"
            at, step = each.changes_at, 1.0 if whole else 1e-6 * each.changes_at
            assert each.low is not None
            assert each.high is not None
            assert each.low * (1 - ROUNDING) <= at <= each.high * (1 + ROUNDING), each
            sides = {alone(asked, each, value, needs) for value in (at - step, at, at + step)}
            assert sides == {False, True}, f"{asked.board.name}, {asked.result}: {each} of {needs}"
            changed[each.need] = changed.get(each.need, 0) + 1
    assert {"rate", "fit", "price"} <= set(changed), changed
