"""What the tests of fidelity share: the comparison with simulations that the model alone stands for."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from codesign.hardware.fidelity import SAMPLES, Fidelity, asked, compared
from codesign.hardware.rtl.verify import Asked, Checked, StyleChecked, Verified


def model_alone(points: list[Asked]) -> tuple[StyleChecked, ...]:
    """What a simulation of these points yields where no circuit differs: the counts are those of the model."""
    groups: dict[tuple[str, str, str], list[Checked]] = {}
    for each in points:
        expected = each.style.expected(each.job())
        pins = expected.pins
        shown = 0 if pins is None else pins.end - int(pins.cycle[0])
        cycles = sum(expected.cycles.values())
        verified = Verified(len(expected.events.cycle), cycles, 0, None, shown=shown)
        names = each.style.planner, each.style.style, each.style.task
        groups.setdefault(names, []).append(Checked(*names, each.name, verified))
    return tuple(StyleChecked(*names, tuple(group)) for names, group in groups.items())


@pytest.fixture(scope="session")
def without_circuits() -> Callable[[list[Asked]], tuple[StyleChecked, ...]]:
    return model_alone


@pytest.fixture(scope="session")
def result() -> Fidelity:
    return compared(model_alone(asked(range(SAMPLES))))
