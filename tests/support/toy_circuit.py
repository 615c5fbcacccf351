"""A small circuit of the tests, with all that the flow handles: a stream, an image, memories, phases and events."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from codesign.planners.circuits import Circuit, CircuitStyle, Events, Expected, Image
from codesign.planners.job import Job

TOY = Path(__file__).parent / "toy" / "toy_sum.v"
MEMORY = Path(str(files("codesign.planners") / "verilog" / "ram_1w1r.v"))


@dataclass(frozen=True, eq=False)
class ToyParameters:
    """``constant``: what the image adds to the sum. ``width``: bits of a word."""

    constant: int = 5
    width: int = 8


class ToyCircuit(CircuitStyle):
    """Loads words, then adds them up. ``problem`` of its job: the words."""

    planner = "toy"
    style = "summing"

    def circuit(self, job: Job[Any, Any], /) -> Circuit:
        words, width = job.problem, job.parameters.width
        return Circuit(
            top="toy_sum",
            sources=(TOY, MEMORY),
            parameters={
                "WIDTH": width,
                "COUNT": len(words),
                "ADDRESS_BITS": max(1, (len(words) - 1).bit_length()),
                "EVENT_BITS": width + 8,
                "IMAGE": "constant.hex",
            },
            stream=Image(width, [int(word) for word in words]),
            phases=("load", "sum"),
            kinds=("partial sum", "sum"),
            event_bits=width + 8,
            images={"constant.hex": Image(width, [job.parameters.constant])},
            notes=("The words are added up in the order of the stream.",),
        )

    def expected(self, job: Job[Any, Any], /) -> Expected:
        count = len(job.problem)
        sums = np.cumsum(np.asarray(job.problem, np.uint64))
        return Expected(
            Events(
                np.arange(count + 1, 2 * count + 2, dtype=np.int64),
                np.array([0] * count + [1], np.uint8),
                np.append(sums, sums[-1] + np.uint64(job.parameters.constant)),
            ),
            {"load": count, "sum": count + 2},
        )

    def sample(self, seed: int, /) -> Job[Any, Any]:
        random = np.random.default_rng(seed)
        width = int(random.integers(3, 40))
        words = random.integers(0, 2**width, random.integers(2, 60))
        return Job(words, ToyParameters(int(random.integers(0, 2**width)), width))
