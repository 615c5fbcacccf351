"""The trial of a design: what it comes to on its board, kept by content.

The functional work of a design depends on planner, parameters and map, not on the board: it is computed once
(``Memo``), and each board prices it in a few milliseconds.

A circuit runs at the fastest clock that it reaches by its law. So that clock is an input of the time, with the interval
of the law: a time is least where the circuit reaches the upper end.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, Literal

from pydantic import Field

from codesign.ground.errors import CodesignError, RunError, SpecError
from codesign.ground.figures import FIGURES, label
from codesign.ground.memo import Memo
from codesign.ground.records import Listener
from codesign.inputs import Platform, Workload, design_point
from codesign.laws.numbers import Ends
from codesign.maps.reach import distance_steps
from codesign.planners.interface import MAP, Quality
from codesign.study.advice.candidates import LOGIC, Arrangement, Board, Candidate, at_clock, of_share, reached
from codesign.study.advice.needs import Question, workload_tree
from codesign.study.identity import code_digest, platform_digest
from codesign.study.space import canonical
from codesign.system import catalog
from codesign.system.bind import planner_code
from codesign.system.results.model import ResultModel
from codesign.system.results.result import ResourceUse, Result
from codesign.system.scenarios import simulate
from codesign.system.verdicts import Fit, fit_verdict
from codesign.system.verdicts.fits import ends_text

WORST_TIME = FIGURES["plan_time_worst_s"]
"""The time that a rate is held against."""

MEAN_TIME = FIGURES["plan_time_mean_s"]
"""The time that the energy of a plan belongs to."""

ENERGY = FIGURES["energy_j"]


Need = Literal["rate", "power", "price", "arrive", "detour", "figure", "fit", "refused"]

_NEED_OF: dict[str, Need] = {"quality": "arrive"}
"""The needs of reasons that are no matter of the size of the design."""


class Shortfall(ResultModel):
    """The fault that keeps a design from sufficing: ``demand`` passes ``limit``."""

    need: Need = Field(
        description="the need that excludes it: the rate, the power, the price; starts that do not arrive; a resource,"
        " a bound or a clock of the part; or a combination that is refused"
    )
    name: str = Field(description="which of that kind, or why it is refused")
    demand: float | None = Field(default=None, description="what it comes to, in unit; None: not known")
    limit: float = Field(default=0.0, description="what it may be, in unit")
    lower: bool = Field(default=False, description="whether it has to be at least that; else it may be at most that")
    unit: str = Field(default="", description="unit of the two; empty for counts")

    @property
    def is_unknown(self) -> bool:
        """True if nobody knows what it comes to, which is no matter of a refusal."""
        return self.demand is None and self.need != "refused"

    @property
    def ratio(self) -> float:
        """The demand over the limit; infinite if there is no limit to speak of."""
        if self.demand is None:
            return math.inf
        large, small = (self.limit, self.demand) if self.lower else (self.demand, self.limit)
        return large / small if small else math.inf


class Use(ResultModel):
    """The resource of the part that a design uses most of."""

    resource: str = Field(description="the kind, such as slices")
    demand: int = Field(description="how many it takes")
    budget: int = Field(description="how many the part has")

    @property
    def share(self) -> float:
        """The share of the budget."""
        return self.demand / self.budget if self.budget else math.inf


class Trial(ResultModel):
    """The figures of a design, whatever is asked of it. Figures that only a run gives are None if it was not run."""

    clock_hz: int | None = Field(default=None, description="the clock of the fabric, which its law lets it reach, Hz")
    time_s: float | None = Field(default=None, description="time of a plan, the worst over the starts, s")
    time_low_s: float | None = Field(
        default=None, description="the same, the least value inside the intervals of all figures, s"
    )
    time_high_s: float | None = Field(
        default=None, description="the same, the greatest value inside the intervals of all figures, s"
    )
    surely_fits: bool = Field(default=False, description="whether it fits at every value inside the intervals")
    may_fit: str = Field(
        default="", description="of a design that does not fit: the limit that it keeps at some values inside intervals"
    )
    mean_time_s: float | None = Field(default=None, description="the same, the mean over the starts, s")
    mean_low_s: float | None = Field(default=None, description="the mean, the least value inside the intervals, s")
    mean_high_s: float | None = Field(default=None, description="the mean, the greatest value, s")
    energy_j: float | None = Field(default=None, description="energy of a plan, J")
    energy_low_j: float | None = Field(default=None, description="the same, the least value, J")
    energy_high_j: float | None = Field(default=None, description="the same, the greatest value, J")
    messages_s: tuple[float, float] | None = Field(
        default=None, description="of that time, the message with the map: at the figures' own values, and the least, s"
    )
    starts: int = Field(default=0, description="starts tried")
    arrived: int = Field(default=0, description="starts that arrived")
    detour: float | None = Field(
        default=None, description="its longest path over the shortest, the worst over the starts"
    )
    figures: dict[str, float] = Field(default={}, description="every declared figure that it has, by name")
    fullest: Use | None = Field(default=None, description="the resource of the part that is used most")
    shortfalls: tuple[Shortfall, ...] = Field(default=(), description="why it cannot serve")


class Laboratory:
    """Tries the designs of a question. What they have in common is computed once.

    ``failures``: what went wrong in the code of planners, and ``failed``: the boards with designs that it kept from
    being tried. Such a design counts as refused, and is not kept.
    """

    def __init__(self, question: Question) -> None:
        self.question = question
        self.memo = Memo()
        self.failures: list[str] = []
        self.failed: set[str] = set()
        self._platforms: dict[str, str] = {}

    @cached_property
    def farthest(self) -> Laboratory:
        """The laboratory of the same question from its farthest start alone.

        A plan takes no longer from there than from the worst start, so what is too slow here is too slow.
        """
        problem = self.question.problem
        if len(problem.starts) == 1:
            return self
        steps = distance_steps(problem.free, problem.goals)
        start = max(problem.starts, key=lambda cell: int(steps[cell]))
        section = {**self.question.section, "starts": [list(problem.named(start))]}
        other = Laboratory(replace(self.question, section=section, problem=replace(problem, starts=(start,))))
        other.memo, other.failures, other.failed = self.memo, self.failures, self.failed
        return other

    @cached_property
    def _asked(self) -> list[Any]:
        section = {key: value for key, value in self.question.section.items() if key != "map"}
        grid = self.question.grid
        share = self.question.needs.share
        return [self.question.problem.digest, grid.digest, grid.resolution, section, share, code_digest()]

    def key(self, candidate: Candidate) -> str:
        """The digest of all that the trial depends on: board, design, map, goals, starts, share, and the code."""
        return self._key(candidate.board, [candidate.planner.name, candidate.mapping, candidate.settings])

    def key_of(self, each: Arrangement) -> str:
        """The digest of all that the families of an arrangement depend on, and what excludes them at some rate."""
        placed = [each.component, each.placed.apart, each.placed.memory]
        return self._key(each.board, ["families", each.planner.name, each.style.style, placed])

    def _key(self, board: Board, what: Sequence[Any]) -> str:
        if board.name not in self._platforms:
            self._platforms[board.name] = platform_digest(board.platform)
        identity = [*self._asked, self._platforms[board.name], *what]
        return hashlib.sha256(canonical(identity).encode()).hexdigest()

    def fail(self, board: str, failed: RunError) -> None:
        """Note that the code of a planner failed on a board."""
        self.failures.append(f"{board}: {failed.what}")
        self.failed.add(board)

    def point(self, candidate: Candidate) -> tuple[Platform, Workload]:
        """Platform and workload of a design.

        Raises:
            SpecError: they do not belong together.
        """
        tree = workload_tree(candidate.planner.name, self.question.section, candidate.mapping)
        workload = catalog.load_workload(tree)
        if not candidate.settings:
            return candidate.board.platform, workload
        return design_point(candidate.board.platform, workload, candidate.settings)

    def result(self, candidate: Candidate, listeners: Sequence[Listener] = ()) -> Result:
        """The result of a design, simulated; its part and its clock as advice takes them (``as_asked``).

        ``listeners`` take the records of the run.

        Raises:
            CodesignError: the design is refused.
        """
        point = self.point(candidate)
        with planner_code(candidate.planner):
            result = simulate(*point, listeners=listeners, memo=self.memo, grid=self.question.grid)
        return as_asked(result, self.question.needs.share)

    def trial(self, candidate: Candidate) -> tuple[Candidate, Trial]:
        """The trial of a design, at a lower clock where it is too slow for its own and for nothing else."""
        try:
            result = self.result(candidate)
            if not result.feasible and all(reason.kind == "clock" for reason in result.reasons):
                assert result.clock is not None, "only a design with a clock is too slow for it"
                candidate = at_clock(candidate, reached(result.clock.limit))
                result = self.result(candidate)
        except SpecError as refused:
            return candidate, _refused(refused.faults[0].what)
        except RunError as failed:
            self.fail(candidate.board.name, failed)
            return candidate, _refused(failed.what)
        except CodesignError as refused:
            return candidate, _refused(refused.what)
        return candidate, trial_of(result)


def as_asked(result: Result, share: float) -> Result:
    """A result with the share of the part's logic as the budget, and its clock as an input of time and energy."""
    uses = tuple(_of_share(use, share) if use.resource in LOGIC else use for use in result.resources)
    name, clock, terms = f"{result.component}.clock", result.clock, result.terms
    if clock is not None and terms is not None and name in terms.inputs:
        low, high = clock.limit.interval
        figure = replace(clock.limit, value=clock.hz, low=min(low, clock.hz), high=max(high, clock.hz))
        terms = terms.model_copy(update={"inputs": {**terms.inputs, name: figure}})
    return result.model_copy(update={"resources": uses, "terms": terms})


def _of_share(use: ResourceUse, share: float) -> ResourceUse:
    budget = of_share(use.budget, share)
    return use.model_copy(update={"budget": budget, "gap": max(0, use.demand - budget)})


def fit_of(result: Result) -> Fit:
    """The fit of a design but for its clock, which moves its time."""
    reasons = tuple(reason for reason in result.reasons if reason.kind != "clock")
    return fit_verdict(result.model_copy(update={"clock": None, "reasons": reasons}))


def trial_of(result: Result) -> Trial:
    """The trial of a result: its figures, whatever is asked of it."""
    uses = [Use(resource=use.resource, demand=use.demand, budget=use.budget) for use in result.resources]
    quality = result.quality
    starts, arrived = (quality.starts, quality.starts_arrived) if isinstance(quality, Quality) else (0, 0)
    shortfalls = [
        Shortfall(
            lower=reason.kind in _NEED_OF,
            need=_NEED_OF.get(reason.kind, "fit"),
            name=label(reason.name),
            demand=float(reason.demand),
            limit=float(reason.limit),
            unit=reason.unit,
        )
        for reason in result.reasons
    ]
    known = {reason.name for reason in result.reasons}
    shortfalls += [
        Shortfall(need="fit", name=label(use.resource), demand=use.demand, limit=use.budget)
        for use in result.resources
        if use.gap and use.resource not in known
    ]
    if result.feasible and arrived < starts:
        shortfalls.append(Shortfall(need="arrive", name="starts", demand=arrived, limit=starts, lower=True))
    fit, nothing = fit_of(result), (None, None)
    time, mean, energy = (result.interval(figure) or nothing for figure in (WORST_TIME, MEAN_TIME, ENERGY))
    return Trial(
        clock_hz=None if result.clock is None else result.clock.hz,
        time_s=result.figure(WORST_TIME),
        time_low_s=time[0],
        time_high_s=time[1],
        surely_fits=fit.fits == "yes",
        may_fit=ends_text(fit) if fit.fits == "uncertain" and shortfalls else "",
        mean_time_s=result.figure(MEAN_TIME),
        mean_low_s=mean[0],
        mean_high_s=mean[1],
        energy_j=result.figure(ENERGY),
        energy_low_j=energy[0],
        energy_high_j=energy[1],
        messages_s=_messages(result),
        starts=starts,
        arrived=arrived,
        detour=quality.path_length_ratio_worst if isinstance(quality, Quality) else None,
        figures={name: value for name in FIGURES if (value := result.figure(name)) is not None},
        fullest=max(uses, key=lambda use: use.share, default=None),
        shortfalls=tuple(shortfalls),
    )


def _messages(result: Result) -> tuple[float, float] | None:
    """The time of the message with the map, waits left out, s: at the figures' own values, and the least.

    Every design of an arrangement gets the same map. What it answers may depend on the design.
    """
    if result.terms is None or not (plans := result.terms.times.get(WORST_TIME.name)):
        return None
    inputs = result.terms.inputs
    values, ends = {name: figure.value for name, figure in inputs.items()}, Ends(inputs)
    links = result.links or {}
    sent = [[term for term in plan if term.where in links and term.works and term.what == MAP] for plan in plans]
    return min(sum(term.at(values) for term in plan) for plan in sent), min(ends.of_sum(plan)[0] for plan in sent)


def _refused(why: str) -> Trial:
    return Trial(shortfalls=(Shortfall(need="refused", name=why),))
