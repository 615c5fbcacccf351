"""Circuits of the tests that stand in for those that are installed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from toy_circuit import ToyCircuit

from codesign.planners.circuits import Circuit, Expected, Image
from codesign.planners.job import Job
from codesign.system import catalog

Install = Callable[..., None]


class OnHarmonic(ToyCircuit):
    """A circuit of a style that workloads can name."""

    planner = "harmonic"
    style = "bit_serial"

    def circuit(self, job: Job[Any, Any], /) -> Circuit:
        return super().circuit(self.sample(0))

    def expected(self, job: Job[Any, Any], /) -> Expected:
        return super().expected(self.sample(0))


class Flipped(ToyCircuit):
    """One bit of a memory image is not what the model expects."""

    style = "flipped"

    def circuit(self, job: Job[Any, Any], /) -> Circuit:
        circuit = super().circuit(job)
        image = circuit.images["constant.hex"]
        return replace(circuit, images={"constant.hex": Image(image.width, [int(image.words[0]) ^ 1])})


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> Install:
    """Let these be the circuits that are installed."""

    def install(*styles: ToyCircuit) -> None:
        circuits = {(style.planner, style.style, style.task): style for style in styles}
        monkeypatch.setattr(catalog, "circuits", lambda: circuits)

    return install
