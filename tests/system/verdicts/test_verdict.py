"""Verdicts against the simulation: a flip changes the winner, and no draw contradicts what is proved."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from shipped_plans import Design, design, on_host, result_of, with_values, written

import codesign
from codesign.ground.figures import FIGURES, Figure, Status
from codesign.inputs.constraint import constraint_of
from codesign.inputs.derived import derived
from codesign.system.results.result import Result
from codesign.system.results.terms import Term, Terms, is_edges
from codesign.system.scenarios import simulate
from codesign.system.verdicts import Verdict, constraint_verdict, need_verdict, sensitivity, together, winner_verdict
from codesign.system.verdicts.sums import Inputs, Margin

SEARCHES: tuple[Design, ...] = (
    design("zynq", "breadth-first"),
    on_host("zynq", "arm"),
    design("virtex4-pci", "breadth-first"),
    on_host("virtex4-pci", "host"),
    design("virtex2pro", "breadth-first"),
    on_host("virtex2pro", "powerpc"),
    design("arty-a7", "breadth-first"),
    on_host("pc-3400mhz", "pc"),
    on_host("pc-epyc", "pc"),
)
FPGA, ARM = SEARCHES[:2]
PAIRS = tuple(itertools.combinations(SEARCHES, 2))
PRICED = ("first_plan_s", "energy_j")


def verdict_of(pair: tuple[Design, Design], figure: str) -> Verdict:
    return winner_verdict([result_of(one) for one in pair], figure)


def winner_with(pair: tuple[Design, Design], verdict: Verdict, value: float) -> int:
    """The winner by simulation, with another value of the figure that decides."""
    decides = verdict.decides
    assert decides is not None
    results = [
        with_values(one, {decides.name: written(value, decides.figure.unit)})
        if result_of(one).platform == decides.platform
        else result_of(one)
        for one in pair
    ]
    values = [result.figure(FIGURES[verdict.figure]) for result in results]
    return int(np.argmin(np.array(values, float)))


def test_one_percent_to_either_side_of_a_flip_changes_the_winner() -> None:
    flips = 0
    for pair, figure in itertools.product(PAIRS, PRICED):
        verdict = verdict_of(pair, figure)
        decides = verdict.decides
        if decides is None or decides.flips_at is None or not decides.platform:
            continue
        before, after = (winner_with(pair, verdict, decides.flips_at * share) for share in (0.99, 1.01))
        assert {before, after} == {0, 1}, (pair, verdict)
        toward = before if decides.flips_at > decides.figure.value else after
        assert toward == verdict.winner
        flips += 1
    assert flips >= 12


def test_a_flip_of_a_figure_of_a_part(tmp_path: Any) -> None:
    """No axis moves it: the part's file is edited."""
    pair = design("zynq", "breadth-first"), design("virtex2pro", "breadth-first")
    verdict = verdict_of(pair, "energy_j")
    decides = verdict.decides
    assert decides is not None
    assert decides.flips_at is not None
    assert (decides.name, decides.platform) == ("part XC2VP30.power.static", "")
    shipped = codesign.load_platform("virtex2pro").document.folder
    (tmp_path / "parts").mkdir()
    board = (shipped / "virtex2pro.yaml").read_text(encoding="utf-8")
    winners = []
    for share in (0.99, 1.01):
        text = (shipped / "parts" / "XC2VP30.yaml").read_text(encoding="utf-8")
        start = text.index("static:")
        moved = text[:start] + text[start:].replace("value: 0.25 W", f"value: {decides.flips_at * share!r} W", 1)
        (tmp_path / "parts" / "XC2VP31.yaml").write_text(moved.replace("XC2VP30", "XC2VP31"), encoding="utf-8")
        path = tmp_path / f"board-{share}.yaml"
        path.write_text(board.replace("XC2VP30", "XC2VP31"), encoding="utf-8")
        other = simulate(codesign.load_platform(path), codesign.load_workload("breadth-first"))
        values = [result.figure(FIGURES["energy_j"]) for result in (result_of(pair[0]), other)]
        winners.append(int(np.argmin(np.array(values, float))))
        (tmp_path / "parts" / "XC2VP31.yaml").unlink()
    assert set(winners) == {0, 1}


def margin_of(pair: list[Result], verdict: Verdict) -> Margin:
    inputs = Inputs()
    assert verdict.winner is not None
    assert verdict.rival is not None
    sides = [inputs.sums(pair[number], verdict.figure) for number in (verdict.winner, verdict.rival)]
    return Margin(sides[0], sides[1], inputs.by_id)


def test_ten_thousand_draws_never_contradict_what_is_proved() -> None:
    random, proved = np.random.default_rng(10), 0
    for pair, figure in itertools.product(PAIRS, (*PRICED, "power")):
        verdict = verdict_of(pair, figure)
        if verdict.state == "not assessed" or not (verdict.least is not None and verdict.most is not None):
            continue
        results = [result_of(one) for one in pair]
        margin = margin_of(results, verdict)
        draws = {}
        for name, each in margin.inputs.items():
            whole = each.value == int(each.value) and each.name.endswith(("words", "width", "cycles"))
            draws[name] = (
                random.integers(int(each.low), int(each.high) + 1, 10_000).astype(float)
                if whole
                else random.uniform(each.low, each.high, 10_000)
            )
        drawn = np.broadcast_to(margin.at(draws), (10_000,))
        room = 1e-9 * (abs(verdict.least) + abs(verdict.most))
        assert verdict.least - room <= drawn.min()
        assert drawn.max() <= verdict.most + room
        if verdict.state == "proved":
            proved += 1
            assert (drawn > 0).all()
    assert proved >= 20


def test_simulated_draws_never_contradict_what_is_proved() -> None:
    random = np.random.default_rng(4)
    proved = [pair for pair in PAIRS if verdict_of(pair, "first_plan_s").state == "proved"]
    for pair in proved[:6]:
        winner = verdict_of(pair, "first_plan_s").winner
        for _ in range(5):
            times = []
            for one in pair:
                terms = result_of(one).terms
                assert terms is not None
                values = {
                    name: written(random.uniform(*figure.interval), figure.unit)
                    for name, figure in terms.inputs.items()
                    if " " not in name and figure.interval[0] < figure.interval[1]
                }
                times.append(with_values(one, values).figure(FIGURES["first_plan_s"]))
            assert int(np.argmin(np.array(times, float))) == winner


def test_a_shared_cost_is_one_input() -> None:
    """The same software, on one platform, to two goals: proved, though the intervals overlap."""
    results = [result_of(ARM), with_values(ARM, {"workload.problem.goals": [[88, 96]]})]
    intervals = [result.interval(FIGURES["first_plan_s"]) or (0.0, 0.0) for result in results]
    verdict = winner_verdict(results, "first_plan_s")
    assert verdict.state == "proved"
    assert intervals[verdict.winner or 0][1] > intervals[verdict.rival or 0][0]


def test_a_need_is_proved_refuted_or_depends_on_a_figure() -> None:
    result = result_of(FPGA)
    interval = result.interval(FIGURES["first_plan_s"])
    assert interval is not None
    assert need_verdict(result, "first_plan_s", interval[1] * 1.001).state == "proved"
    assert need_verdict(result, "first_plan_s", interval[0] * 0.999).state == "refuted"
    software = result_of(ARM)
    verdict = need_verdict(software, "first_plan_s", 1e-3)
    assert (verdict.state, verdict.holds) == ("depends", True)
    assert verdict.decides is not None
    assert verdict.decides.name == "arm.costs.breadth_first_wall_cell"
    assert verdict.decides.flips_at is not None
    at_flip = with_values(ARM, {verdict.decides.name: written(verdict.decides.flips_at, "s")})
    assert at_flip.time is not None
    assert at_flip.time.first_plan_s == pytest.approx(1e-3, rel=1e-4)
    reverse = need_verdict(software, "first_plan_s", 1e-3, at_least=True)
    assert (reverse.state, reverse.holds, reverse.margin) == ("depends", False, -(verdict.margin or 0))


def test_a_figure_that_rests_on_no_interval_is_proved_as_it_is() -> None:
    result = result_of(FPGA)
    assert need_verdict(result, "share_reaching_goal", 0.5, at_least=True).state == "proved"
    assert need_verdict(result, "slices", 10).state == "refuted"


def test_three_designs_are_judged_by_the_rival_that_flips_first() -> None:
    results = [result_of(one) for one in (ARM, FPGA, design("arty-a7", "breadth-first"))]
    verdict = winner_verdict(results, "first_plan_s")
    assert (verdict.winner, verdict.rival, verdict.state) == (1, 0, "depends")


def made(plan: tuple[Term, ...], **inputs: tuple[float, float, float]) -> Result:
    """A result whose first plan takes the sum of some terms; inputs as least, own and greatest value."""
    figures = {
        name: Figure(own, "1", Status.ASSUMED, "a guess", low, high) for name, (low, own, high) in inputs.items()
    }
    terms = Terms(inputs=figures, times={"first_plan_s": (plan,)}, draws=())
    seconds = sum(term.at({name: figure.value for name, figure in figures.items()}) for term in plan)
    result = result_of(FPGA)
    assert result.time is not None
    time = result.time.model_copy(update={"first_plan_s": float(seconds)})
    return result.model_copy(update={"terms": terms, "time": time})


def test_the_hardest_rival_is_the_one_that_the_smallest_share_of_its_figure_flips() -> None:
    """A half of 2 ns is less than a twentieth of 100 MHz in numbers, and more as a share."""
    winner = made((Term(1.0, {}),))
    units = made((Term(1e9, {"cost": 1}),), cost=(0.5e-9, 2e-9, 3e-9))
    cycles = made((Term(1.05e8, {"clock": -1}),), clock=(0.5e8, 1e8, 2e8))
    for results in ([winner, units, cycles], [winner, cycles, units]):
        verdict = winner_verdict(results, "first_plan_s")
        assert (verdict.winner, verdict.state) == (0, "depends")
        assert verdict.rival == results.index(cycles)


@pytest.mark.parametrize("factor", [1, 2])
def test_what_no_figure_decides_says_why(factor: int) -> None:
    """Waits for edges are measured by nobody; several figures may have to move; bounds may not be reached."""
    edges = made((Term(1.0, {"axi edges": 1}),), **{"axi edges": (0.0, 1.0, 2.0)})
    both = made((Term(1.0, {"a": 1}), Term(1.0, {"b": 1})), a=(1.0, 1.0, 2.0), b=(1.0, 1.0, 2.0))
    mixed = made((Term(1.0, {"a": 1}), Term(4.0, {"a": -1})), a=(1.0, 2.0, 4.0))
    left_open = "not proved: the bounds of the difference leave it open"
    why = ["it lies within the waits for clock edges", "no figure changes it by itself, several together do", left_open]
    figure = "first_plan_s" if factor == 1 else derived("twice", "first_plan_s * 2")
    for result, limit, reason in zip((edges, both, mixed), (1.5, 3.5, 6.0), why, strict=True):
        verdict = need_verdict(result, figure, factor * limit)
        assert (verdict.state, verdict.holds) == ("depends", True)
        assert verdict.reason == (reason if factor == 1 else left_open)
        assert (verdict.decides is None) == (result is edges)


@pytest.mark.parametrize(("limit", "at"), [(3.5, {"a": 1.75, "b": 1.75}), (1.2, {"a": 0.6, "b": 0.6}), (9.0, {})])
def test_several_figures_that_change_a_need_together_are_named_with_their_values(
    limit: float, at: dict[str, float]
) -> None:
    """Each the same share of the way to the worse end for what holds now; none where even the ends change nothing."""
    each = (0.5, 1.0, 2.0)
    both = made((Term(1.0, {"a": 1}), Term(1.0, {"b": 1}), Term(1e-9, {"c": -1})), a=each, b=each, c=(1.0, 1.0, 1.0))
    moved = {decider.name: decider.flips_at for decider in together(both, "first_plan_s", limit)}
    assert moved == pytest.approx(at, rel=1e-6)


def test_the_best_of_many_is_held_against_every_one_whose_interval_it_meets() -> None:
    """They share one input, so each is proved worse, near or far; what differs by an input of its own may flip."""
    shared = {"a": (0.5, 1.0, 2.0)}
    many = [made((Term(1.0 + place / 1000, {"a": 1}),), **shared) for place in range(130)]
    verdict = winner_verdict(many, "first_plan_s")
    assert (verdict.winner, verdict.state, verdict.holds) == (0, "proved", True)
    far = made((Term(1.15, {"b": 1}),), b=(0.5, 1.0, 2.0))
    verdict = winner_verdict([*many, far], "first_plan_s")
    assert (verdict.winner, verdict.rival, verdict.state) == (0, 130, "depends")
    near, wide = many[0], made((Term(5.0, {"a": 1}),), **shared)
    assert winner_verdict([near, wide], "first_plan_s").least == 2.0, "the results tell more than their intervals"
    apart = [*many[:40], made((Term(9.0, {"b": 1}),), b=(0.9, 1.0, 1.1))]
    assert winner_verdict(apart, "first_plan_s").state == "proved"


def test_infeasible_designs_take_no_part() -> None:
    out = result_of(FPGA).model_copy(update={"feasible": False})
    verdict = winner_verdict([out, result_of(ARM)], "first_plan_s")
    assert (verdict.winner, verdict.state, verdict.reason) == (1, "proved", "no other design")
    assert verdict.holds
    assert winner_verdict([out], "first_plan_s").state == "not assessed"


def test_equal_designs_are_no_rivals() -> None:
    waiting = result_of(design("virtex4-pci", "breadth-first"))
    assert winner_verdict([waiting, waiting.model_copy()], "first_plan_s").equals == (1,)
    verdict = winner_verdict([result_of(FPGA)] * 3, "energy_j")
    assert (verdict.state, verdict.winner, verdict.rival) == ("proved", 0, None)
    assert (verdict.equals, verdict.reason) == ((1, 2), "all others are equal")
    by_slices = winner_verdict([result_of(FPGA), result_of(ARM), result_of(FPGA)], "cycles")
    assert by_slices.state == "not assessed"


def test_the_figure_that_moves_a_time_most() -> None:
    first, *others = sensitivity(result_of(ARM), "energy_j")
    assert first.name == "arm.costs.breadth_first_wall_cell"
    moved = [
        with_values(ARM, {first.name: written(end, "s")}).figure(FIGURES["energy_j"]) for end in first.figure.interval
    ]
    assert moved == pytest.approx([first.least, first.most], rel=1e-9)
    assert all(first.most - first.least >= other.most - other.least for other in others)
    assert sensitivity(result_of(ARM), "share_reaching_goal") == ()


def test_what_has_no_closed_form_is_never_proved() -> None:
    display = result_of(design("virtex2pro-vga", "breadth-first"))
    verdict = winner_verdict([display, result_of(FPGA)], "first_plan_s")
    assert verdict.state == "not assessed"
    assert verdict.reason.startswith("a display takes cycles")
    assert need_verdict(display, "first_plan_s", 1.0).state == "not assessed"
    fleet = simulate(codesign.load_platform("nexys2-serial"), codesign.load_workload("robots-4-fleet"))
    for verdict in (need_verdict(fleet, "first_plan_s", 1e9), winner_verdict([fleet, fleet], "energy_j")):
        assert (verdict.state, verdict.reason.partition(" has")[0]) == ("not assessed", "a fleet")


def test_waits_for_edges_are_bounded_but_decide_nothing() -> None:
    result = result_of(design("virtex4-pci", "breadth-first"))
    assert result.terms is not None
    edges = [name for name in result.terms.inputs if is_edges(name)]
    assert edges
    interval = result.interval(FIGURES["first_plan_s"])
    assert interval is not None
    for limit in np.linspace(*interval, 30):
        decides = need_verdict(result, "first_plan_s", float(limit)).decides
        assert decides is None or decides.name not in edges


def test_a_constraint_is_held_against_the_intervals() -> None:
    result, software = result_of(FPGA), result_of(ARM)
    interval = result.interval(FIGURES["first_plan_s"])
    assert interval is not None

    def state(of: Result, text: str) -> tuple[str, bool | None]:
        verdict = constraint_verdict(of, constraint_of(text))
        return verdict.state, verdict.holds

    assert state(result, f"first_plan < {interval[1] * 1.001e9:.3f} ns") == ("proved", True)
    assert state(result, f"first_plan < {interval[0] * 0.999e9:.3f} ns") == ("refuted", False)
    assert state(software, "slices < 1 %") == ("proved", True)
    assert state(software, "slices >= 1 %") == ("refuted", False)
    slices = next(use for use in result.resources if use.resource == "slices")
    assert state(result, f"slices <= {slices.demand}")[1] is True
    assert state(result, f"slices < {slices.demand}")[1] is False
    assert state(result, f"slices < {100 * slices.demand / slices.budget + 1:.0f} %")[1] is True


def test_a_demand_with_an_interval_decides_what_it_is_held_against() -> None:
    result = result_of(FPGA)
    (use, *others) = result.resources
    figure = Figure(use.demand, "1", Status.ASSUMED, "a law", use.demand - 10, use.demand + 10)
    item = use.items[0].model_copy(update={"figure": figure})
    wide = result.model_copy(update={"resources": (use.model_copy(update={"items": (item,)}), *others)})
    assert need_verdict(wide, use.resource, use.demand + 11).state == "proved"
    assert need_verdict(wide, use.resource, use.demand - 11).state == "refuted"
    verdict = need_verdict(wide, use.resource, use.demand + 5)
    assert (verdict.state, verdict.holds, verdict.least, verdict.most) == ("depends", True, -5, 15)
    assert verdict.decides is not None
    assert (verdict.decides.name, verdict.decides.flips_at) == (item.name, use.demand + 5)
