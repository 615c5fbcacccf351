"""The visits of the planner as steps of a clock, for all styles of harmonic control."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.ground.memo import Memo
from codesign.ground.progress import Track, plan_track
from codesign.ground.records import StageRecord, VisitsRecord
from codesign.maps.reach import reachable
from codesign.planners.harmonic.plan.arguments import Stage, StageEnd, VisitBatch, Visits, check_arguments
from codesign.planners.harmonic.plan.fixed_point import Field, LowerBound
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop, Termination
from codesign.planners.harmonic.plan.planner import run_arguments, sent_map
from codesign.planners.harmonic.plan.relax import HarmonicPlan, work
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Exchange, Step, beyond_map, one_step

if TYPE_CHECKING:
    from codesign.planners.harmonic.plan.engine import Engine

# The stages of a relaxation without their single visits, shared between designs.

MOST_SWEEPS = 1 << 16
"""The most sweeps of a stage that starts from old values. Assumed: a watchdog of 16 bits."""


@dataclass(frozen=True, eq=False)
class StageSums:
    """A stage without its single visits: the sums of each block.

    ``quiet``: no visit of its last sweep changed a bit.
    """

    stage: Stage
    field: Field
    visits: Visits
    fault: str
    quiet: bool

    @property
    def approximate_bytes(self) -> int:
        """What it takes in a ``Memo``: its arrays."""
        visits = self.visits
        return sum(
            each.nbytes for each in (self.field.limbs, visits.block, visits.iterations, visits.count, visits.early)
        )


@dataclass(eq=False)
class _Standing:
    """The engine that ran the last stage on a map, and where it stands: ``field``, in the blocks of ``partition``.

    ``published``: that termination was asked about on this map, so the stages of both are computed at once.
    """

    engine: Engine | None = None
    partition: tuple[Any, ...] = ()
    field: Field | None = None
    published: bool = False


@dataclass(frozen=True, eq=False)
class StageRuns:
    """The stages of one relaxation. ``below``: the values begin nowhere above the converged field."""

    problem: Problem
    parameters: RelaxParameters
    below: bool
    memo: Memo | None

    def sums(self, precision: int, start: Field | None) -> StageSums:
        """One stage from the field of an earlier one, or from the start; it is not computed again if it was before."""
        if self.memo is None:
            # Without a memo nothing would use them again, and the fields of all stages would only take memory.
            return self._run(self._engine(precision, start), precision)
        standing = self.memo.get(("harmonic standing", self.problem.map_digest), _Standing)
        if self.parameters.termination is Termination.PUBLISHED:
            standing.published = True
        return self.memo.get(
            self._key(precision, start, self.parameters.termination), lambda: self._shared(precision, start, standing)
        )

    @cached_property
    def _partition(self) -> tuple[Any, ...]:
        height, width = self.parameters.block_shape(*self.problem.shape)
        # Blocks that hold the same cells have the same visits.
        block = min(height, self.problem.rows), min(width, self.problem.columns)
        return self.problem.map_digest, *block, self.parameters.iterations, self.parameters.pockets

    def _key(self, precision: int, start: Field | None, termination: Termination) -> tuple[Any, ...]:
        digest = None if start is None else start.digest()
        promoted = self.parameters.promote_after.get(precision)
        return "harmonic stage", *self._partition, termination, digest, self.below, precision, promoted

    def _shared(self, precision: int, start: Field | None, standing: _Standing) -> StageSums:
        """A stage that the memo does not hold. It may put the stage of the other termination there."""
        promoted = self.parameters.promote_after.get(precision) is not None
        both = standing.published and self.below and not promoted
        sound = self.parameters.termination is Termination.SOUND
        partition = self._partition
        stands = standing.engine if start is not None and standing.field is start else None
        engine = stands if stands is not None and standing.partition == partition else None
        # Not two at once: the planes of one are most of the memory of a run.
        standing.engine = None
        del stands
        if engine is None:
            engine = self._engine(precision, start)
        engine.published = both or not sound
        sums = self._run(engine, precision)
        if both:
            sums = self._both(engine, precision, start, sums)
        if not sums.fault:
            standing.engine, standing.partition, standing.field = engine, partition, sums.field
        return sums

    def _both(self, engine: Engine, precision: int, start: Field | None, published: StageSums) -> StageSums:
        """The stage of the termination that is asked about; the other one's is put into the memo.

        ``published``: the published stage, at the end of which the engine stands.
        """
        assert self.memo is not None, "stages are shared under a memo"
        asked = self.parameters.termination
        if published.fault:
            return published if asked is Termination.PUBLISHED else self._run(self._engine(precision, start), precision)
        if published.quiet:
            sound = published
        elif engine.settled:
            sound = _with_a_quiet_sweep(published, self.parameters.iterations)
        elif asked is Termination.PUBLISHED:
            return published
        else:
            engine.published = False
            sound = _joined(published, self._run(engine, precision))
        ends = {Termination.PUBLISHED: published, Termination.SOUND: sound}
        (other,) = ends.keys() - {asked}
        self.memo.get(self._key(precision, start, other), lambda: ends[other])
        return ends[asked]

    def _engine(self, precision: int, start: Field | None) -> Engine:
        from codesign.planners.harmonic.plan.engine import Engine

        problem, parameters = self.problem, self.parameters
        arguments = check_arguments(
            sent_map(problem, parameters),
            problem.goals,
            block=parameters.block_shape(*problem.shape),
            iterations=parameters.iterations,
            schedule=(precision,),
            termination=parameters.termination,
            start=start,
        )
        return Engine(arguments)

    def _run(self, engine: Engine, precision: int) -> StageSums:
        blocks = self.parameters.block_count(*self.problem.shape)
        visits = Visits.none(blocks)
        last: NDArray[np.int32] = np.zeros(0, np.int32)
        most = None if self.below else MOST_SWEEPS
        key = "harmonic converged", self.problem.map_digest, self.parameters.pockets, precision
        memo = self.memo if self.below else None
        converged = None if memo is None else memo.held(key)
        promoted = self.parameters.promote_after.get(precision)
        for item in engine.run(0, precision, most, promoted, converged):
            if isinstance(item, StageEnd):
                if memo is not None and converged is None and engine.settled:
                    memo.keep(key, item)
                # A visit of more than one iteration changed a bit.
                return StageSums(item.stage, item.field, visits, item.fault, bool((last == 1).all()))
            visits.add(item, self.parameters.iterations)
            last = np.concatenate([last, item.iterations])[-blocks:]
        raise AssertionError("a stage has an end")


def _with_a_quiet_sweep(sums: StageSums, most_iterations: int) -> StageSums:
    """The stage with one more sweep of visits of one iteration each."""
    blocks, visits = len(sums.visits.block), sums.visits
    longer = Visits(visits.block, visits.iterations + 1, visits.count + 1, visits.early + (most_iterations > 1))
    stage = replace(
        sums.stage,
        sweeps=sums.stage.sweeps + 1,
        visits=sums.stage.visits + blocks,
        iterations=sums.stage.iterations + blocks,
    )
    return replace(sums, stage=stage, visits=longer, quiet=True)


def _joined(first: StageSums, rest: StageSums) -> StageSums:
    """A stage in two parts as one."""
    one, two = first.visits, rest.visits
    stage = replace(
        rest.stage,
        sweeps=first.stage.sweeps + rest.stage.sweeps,
        visits=first.stage.visits + rest.stage.visits,
        iterations=first.stage.iterations + rest.stage.iterations,
    )
    visits = Visits(one.block, one.iterations + two.iterations, one.count + two.count, one.early + two.early)
    return replace(rest, stage=stage, visits=visits)


LOAD, RELAX, DECIDE, READ = "load", "relax", "decide", "read"
"""The phases of the cycles. The first three are named as the tasks; the last is the read-out of the field."""

STAGE_END = "stage_end"
"""The name of the work at the end of a stage in records; its cycles count in phase ``relax``."""

DETECT = "detect"
"""The task that detects whether a sweep changed a bit: a part of every visit, unless it is placed elsewhere."""


def notes(problem: Problem, parameters: RelaxParameters) -> tuple[str, ...]:
    """A note where a block is larger than the map."""
    map_shape = problem.shape
    return beyond_map("relax.block", "block", parameters.block_shape(*map_shape), map_shape)


class VisitCost(Protocol):
    """The cost of visits, in cycles or in units of the kernel of a processor."""

    def __call__(self, precision: int, visits: Visits) -> NDArray[np.int64]:
        """The cost of each entry, int64: linear in ``iterations``, ``count`` and ``early``, without a constant."""


@dataclass(frozen=True)
class Costs:
    """The costs of a style: of visits, and of the end of a stage at a precision.

    So a stage costs the same visit by visit and from its sums. ``ram_addresses``: addresses that each block RAM gets in
    every cycle (an iteration reads one word and writes another).
    """

    visits: VisitCost
    stage_end: Callable[[int], int] = lambda _precision: 0
    ram_addresses: int = 0


@dataclass(frozen=True, eq=False)
class _Run:
    """The relaxation of one job: the stages from ``start`` on."""

    problem: Problem
    parameters: RelaxParameters
    start: Field | None

    @property
    def below(self) -> bool:
        """True if the values begin nowhere above the converged field."""
        return self.start is None or isinstance(self.start, LowerBound)

    @property
    def precisions(self) -> tuple[int, ...]:
        """The precisions of the schedule that remain after the start."""
        return remaining_precisions(self.parameters.precisions, self.start)

    def track(self) -> Track:
        """The progress of the relaxation: a stage takes about as long as it has bits."""
        return plan_track("bits of all stages", sum(self.precisions))


@dataclass
class _StageClock:
    """The begin of the current stage: None until the record of its first visits."""

    begin: int | None = None


def relax_steps(job: Job[Problem, RelaxParameters], costs: Costs) -> Generator[Step, None, HarmonicPlan]:
    """The relaxation as steps of phase ``relax``; returns the same plan as ``relax``.

    With ``job.detail`` a unit of a step is a visit or the end of a stage; without, a unit is a whole stage, and stages
    that ``job.memo`` holds are not computed again. Where another component detects convergence, every sweep is a step
    of its own, with or without ``detail``, and an ``Exchange`` follows.

    From ``job.start`` the stages are those that ``remaining_precisions`` leaves.
    """
    run = _Run(job.problem, job.parameters, job.start)
    if not job.does(DETECT):
        steps = _each_visit(run, costs, detect=True)
    elif job.detail:
        steps = _each_visit(run, costs, detect=False)
    else:
        steps = _each_stage(run, costs, job.memo)
    stages, field, fault = yield from steps
    problem = job.problem
    reach = partial(reachable, problem.free, problem.goals)
    cells = reach() if job.memo is None else job.memo.get(("reachable", problem.map_digest), reach)
    return HarmonicPlan(tuple(stages), field, cells, None, run.below, fault)


def remaining_precisions(precisions: tuple[int, ...], start: Field | None) -> tuple[int, ...]:
    """The precisions of the stages to be run from a start: its own and those above.

    Raises:
        InputError: the start is finer than the last stage.
    """
    if start is None:
        return precisions
    remaining = tuple(precision for precision in precisions if precision >= start.precision)
    if not remaining:
        what = f"a start of {start.precision} bits for a schedule that ends at {precisions[-1]}"
        raise InputError(what, "start", "give one that is no finer than the last stage")
    return remaining


_StageSteps = Generator[Step, None, tuple[list[Stage], Field, str]]


def _each_visit(run: _Run, costs: Costs, detect: bool) -> _StageSteps:
    stages: list[Stage] = []
    clock = _StageClock()
    field, fault = run.start, ""
    track = run.track()
    for item in _work(run, run.precisions, run.start):
        if isinstance(item, VisitBatch) and detect:
            yield from _each_sweep(run, item, costs, clock)
        elif isinstance(item, VisitBatch):
            yield _visits_step(run, item, costs, clock)
        else:
            stages.append(item.stage)
            track.step(item.stage.precision)
            field, fault = item.field, item.fault
            if stage_end := costs.stage_end(item.stage.precision):
                yield replace(one_step(STAGE_END, stage_end, costs.ram_addresses), phase=RELAX)
            yield Step(RELAX, np.zeros(0, np.int64), _stage_record(item, clock), makes=StageRecord)
    assert field is not None, "a schedule has at least one stage"
    return stages, field, fault


def _each_sweep(run: _Run, batch: VisitBatch, costs: Costs, clock: _StageClock) -> Iterator[Step]:
    """The visits of a batch cut at the ends of sweeps, a round trip to the task ``detect`` after each sweep."""
    blocks = run.parameters.block_count(*run.problem.shape)
    # A sweep begins at block 0 and ends at the last block, so a batch shows the ends of its sweeps.
    ends = np.flatnonzero(batch.block == blocks - 1) + 1
    first = 0
    for last in [*ends.tolist(), *([len(batch.block)] if not len(ends) or ends[-1] < len(batch.block) else [])]:
        part = replace(batch, block=batch.block[first:last], iterations=batch.iterations[first:last])
        yield _visits_step(run, part, costs, clock)
        if part.block[-1] == blocks - 1:
            yield Exchange(to=DETECT)
        first = last


def _visits_step(run: _Run, batch: VisitBatch, costs: Costs, clock: _StageClock) -> Step:
    cycles = costs.visits(batch.precision, single_visits(run.parameters, batch))
    return Step(RELAX, cycles, _visits_record(batch, clock), costs.ram_addresses, makes=VisitsRecord)


def single_visits(parameters: RelaxParameters, batch: VisitBatch) -> Visits:
    """The visits of a batch one by one."""
    return Visits(
        batch.block,
        batch.iterations.astype(np.int64),
        np.ones(len(batch.block), np.int64),
        (batch.iterations < parameters.iterations).astype(np.int64),
    )


def _each_stage(run: _Run, costs: Costs, memo: Memo | None) -> _StageSteps:
    stages: list[Stage] = []
    field, fault = run.start, ""
    stage_runs = StageRuns(run.problem, run.parameters, run.below, memo)
    track = run.track()
    for precision in run.precisions:
        sums = stage_runs.sums(precision, field)
        track.step(precision)
        cycles = int(costs.visits(precision, sums.visits).sum()) + costs.stage_end(precision)
        yield Step(RELAX, np.array([cycles], np.int64), ram_addresses=costs.ram_addresses)
        stages.append(sums.stage)
        field, fault = sums.field, sums.fault
        first = run.parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA and sums.stage.ends_a_run
        if first or fault:
            break
    assert field is not None, "a schedule has at least one stage"
    return stages, field, fault


def _work(run: _Run, precisions: tuple[int, ...], start: Field | None) -> Iterator[VisitBatch | StageEnd]:
    asked = {"schedule": precisions, "start": start, "most_sweeps": None if run.below else MOST_SWEEPS}
    return work(**run_arguments(run.problem, run.parameters) | asked)


def _visits_record(batch: VisitBatch, clock: _StageClock) -> Callable[[int, int, str], VisitsRecord]:
    def record(begin: int, end: int, source: str) -> VisitsRecord:
        if clock.begin is None:
            clock.begin = begin
        return VisitsRecord(
            time=begin,
            source=source,
            end=end,
            stage=batch.stage_index,
            precision=batch.precision,
            block=batch.block,
            iterations=batch.iterations,
        )

    return record


def _stage_record(item: StageEnd, clock: _StageClock) -> Callable[[int, int, str], StageRecord]:
    def record(begin: int, end: int, source: str) -> StageRecord:
        stage_begin, clock.begin = clock.begin, None
        return StageRecord(
            time=end,
            source=source,
            begin=begin if stage_begin is None else stage_begin,
            stage=item.stage_index,
            precision=item.stage.precision,
            sweeps=item.stage.sweeps,
            visits=item.stage.visits,
            iterations=item.stage.iterations,
            cycles=item.stage.cycles,
            local_maxima=item.stage.local_maxima,
            potential=item.field.to_float(),
        )

    return record
