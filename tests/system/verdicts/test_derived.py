"""Verdicts about figures that an expression makes of others: bounds that hold, and the input that decides."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import codesign
from codesign.ground.figures import FIGURES
from codesign.inputs.constraint import constraint_of
from codesign.inputs.derived import DerivedFigure, derived
from codesign.study.run import explore
from codesign.system.results.result import Result
from codesign.system.verdicts import constraint_verdict, need_verdict, sensitivity, winner_verdict
from codesign.system.verdicts.sums import Inputs, Margin

EXPRESSIONS = (
    "energy_j * plan_time_worst_s",
    "energy_j / (plan_time_worst_s + 1 ms)",
    "sqrt(energy_j / power)",
    "max(plan_time_worst_s, 100 us) * slices",
    "plan_time_worst_s - plan_time_mean_s",
)


@pytest.fixture(scope="module")
def result() -> Result:
    return codesign.simulate("zynq", "wavefront-tiles")


@pytest.fixture(scope="module")
def other() -> Result:
    return codesign.simulate("virtex4-pci", "wavefront-tiles")


def at(result: Result, figure: DerivedFigure, shares: np.ndarray) -> float | None:
    """The figure where each input lies at a share of its interval; shares by the order of the inputs."""
    inputs = Inputs()
    values = {}
    sums = {name: inputs.sums(result, name) for name in figure.names}
    for share, (name, each) in zip(itertools.cycle(shares), inputs.by_id.items(), strict=False):
        values[name] = each.low + share * (each.high - each.low)
        if len(values) == len(inputs.by_id):
            break

    def value(name: str) -> float | None:
        plans = sums[name]
        return float(Margin(((),), plans, inputs.by_id).at(values)) if plans else result.figure(FIGURES[name])

    return figure.of(value)


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_the_interval_holds_every_value(result: Result, text: str) -> None:
    figure = derived("f", text)
    interval = result.interval(figure)
    assert interval is not None
    low, high = interval
    value = result.figure(figure)
    assert value is not None
    assert low <= value <= high
    generator = np.random.default_rng(1)
    for _ in range(50):
        drawn = at(result, figure, generator.choice([0.0, 0.3, 1.0], 40))
        assert drawn is None or low * (1 - 1e-9) <= drawn <= high * (1 + 1e-9)


def test_a_product_has_the_ends_of_its_factors(result: Result) -> None:
    (one, two), (three, four) = (
        result.interval(FIGURES[name]) or (math.nan, math.nan) for name in ("energy_j", "plan_time_worst_s")
    )
    assert result.interval(derived("f", "energy_j * plan_time_worst_s")) == (one * three, two * four)
    assert result.interval(derived("f", "slices * 2")) is None


def test_needs(result: Result) -> None:
    figure = derived("f", "energy_j * plan_time_worst_s")
    low, high = result.interval(figure) or (math.nan, math.nan)
    value = result.figure(figure)
    assert value is not None
    assert need_verdict(result, figure, high * 1.01).state == "proved"
    assert need_verdict(result, figure, low * 0.99).state == "refuted"
    above = need_verdict(result, figure, value * 1.01)
    assert (above.state, above.holds) == ("depends", True)
    assert above.decides is not None
    assert above.decides.flips_at is not None
    most = need_verdict(result, figure, low * 1.001, at_least=True)
    assert (most.state, most.holds) == ("depends", True)
    moved = sensitivity(result, figure)
    assert moved[0].least < value < moved[0].most
    assert low * (1 - 1e-9) <= moved[0].least < moved[0].most <= high * (1 + 1e-9)


def test_a_value_that_there_is_not_everywhere_is_not_assessed(result: Result) -> None:
    value = result.figure(FIGURES["energy_j"])
    figure = derived("f", f"1 / (energy_j - {value} J - 1 nJ)")
    assert result.interval(figure) is None
    verdict = need_verdict(result, figure, 1.0)
    assert verdict.state == "not assessed"
    assert "no value somewhere" in verdict.reason
    assert need_verdict(result, derived("f", "cycles / slices"), 1.0).state in {"refuted", "depends"}


@pytest.mark.parametrize("maximise", [False, True])
def test_winners(result: Result, other: Result, maximise: bool) -> None:
    text = "1 / energy_j" if maximise else "energy_j * 2"
    verdict = winner_verdict([result, other], derived("f", text, maximise=maximise))
    plain = winner_verdict([result, other], "energy_j")
    assert (verdict.winner, verdict.state) == (plain.winner, plain.state) == (0, "proved")
    (slow, fast), (worst, best) = (
        result.interval(FIGURES["plan_time_worst_s"]) or (0.0, 0.0),
        other.interval(FIGURES["plan_time_worst_s"]) or (0.0, 0.0),
    )
    assert max(slow, worst) < min(fast, best)
    text = "1 / plan_time_worst_s" if maximise else "plan_time_worst_s * 2"
    verdict = winner_verdict([result, other], derived("f", text, maximise=maximise))
    assert (verdict.winner, verdict.state, verdict.holds) == (1, "depends", True)
    assert verdict.decides is not None


def test_constraints_over_expressions_are_as_sure(result: Result) -> None:
    assert constraint_verdict(result, constraint_of("energy_j * plan_time_worst_s < 1 J s")).state == "proved"
    assert constraint_verdict(result, constraint_of("energy_j * plan_time_worst_s < 1 nJ s")).state != "proved"


def test_the_best_design_by_a_derived_objective(tmp_path: object) -> None:
    from codesign.views.report.sentences import winners_certainty_table

    workload = codesign.load_workload(
        {
            **codesign.load_workload("wavefront-tiles").document.tree,
            "explore": {
                "axes": {"fpga.clock": ["50 MHz", "100 MHz"]},
                "figures": {"product": "energy_j * plan_time_worst_s"},
                "objectives": ["product", "slices"],
            },
        }
    )
    study = explore(codesign.load_platform("virtex4-pci"), workload, workers=1)
    (row,) = winners_certainty_table(study).rows
    assert row[0].text.startswith("least product")
    assert "to" in row[2].text
    assert row[3].text
