"""The cycles of the relaxation as docs/laws.md gives them, line by line of its table, are those of the model."""

from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from places import ROOT

from codesign.ground.records import VisitsRecord
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.styles import timing
from codesign.planners.harmonic.styles.bit_serial import relax_costs
from codesign.planners.harmonic.styles.steps import relax_steps
from codesign.planners.interface import Problem
from codesign.planners.job import Job

PAGE = (ROOT / "docs" / "laws.md").read_text(encoding="utf-8")


def visits_of(job: Job) -> list[list[tuple[int, int, int]]]:
    """Block, iterations and precision of each visit, by stage."""
    records = [
        step.record(0, 0, "")
        for step in relax_steps(job, relax_costs(job))
        if step.makes is VisitsRecord and step.record is not None
    ]
    visits = [
        (record.stage, int(block), int(iterations), record.precision)
        for record in records
        for block, iterations in zip(record.block, record.iterations, strict=True)
    ]
    return [[each[1:] for each in stage] for _, stage in groupby(visits, key=lambda each: each[0])]


def by_the_page(job: Job) -> int:
    """The sum of the lines of the table: iterations, between visits, ends of sweeps and of stages."""
    parameters, shape = job.parameters, job.problem.shape
    block, blocks = parameters.block_shape(*shape), parameters.block_count(*shape)
    switch = timing.or_tree_stages(*block, parameters.pipeline) + (5 if parameters.pipeline else 2)
    published = parameters.termination == "published"
    cycles = 0
    for stage in visits_of(job):
        *_, (_, last, precision) = stage
        for place, iterations, _ in stage:
            early = iterations < parameters.iterations
            ends_sweep = published and place == blocks - 1
            cycles += iterations * (precision + 2) + (switch if blocks > 1 and (early or ends_sweep) else 0)
        if blocks == 1 or (not published and last == parameters.iterations):
            cycles += switch
        if blocks > 1 and published and parameters.stop == "first_without_local_maxima":
            cycles += blocks * (precision + 2) + switch
    return cycles


@given(
    st.integers(0, 99), st.sampled_from(["sound", "published"]), st.integers(1, 5),
    st.sampled_from([(6, 6), (6, 12), (12, 12), (12, 18)]), st.sampled_from([0, 1]),
    st.sampled_from(["first_without_local_maxima", "schedule_end"]),
)  # fmt: skip
def test_the_table_of_cycles_is_that_of_the_model(
    seed: int, termination: str, iterations: int, block: tuple[int, int], pipeline: int, stop: str
) -> None:
    free = np.random.default_rng(seed).random((12, 18)) > 0.2
    free[0, 0] = True
    parameters = RelaxParameters.model_validate(
        {
            "block": block,
            "iterations": iterations,
            "schedule": (9, 15),
            "termination": termination,
            "pipeline": pipeline,
            "stop": stop,
        }
    )
    job = Job(Problem(free, ((0, 0),), ((0, 0),)), parameters, detail=True)
    model = sum(int(step.cycles.sum()) for step in relax_steps(job, relax_costs(job)))
    assert by_the_page(job) == model


@pytest.mark.parametrize(
    "line", ["end of a sweep, `termination: published`", "end of a stage, `termination: published`"]
)
def test_the_page_has_each_line(line: str) -> None:
    assert f"| {line}" in PAGE
