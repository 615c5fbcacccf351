"""The records of an explanation: figures, which tables and JSON show."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from codesign.ground.figures import Figure
from codesign.ground.units import counted
from codesign.system.results.model import ResultModel
from codesign.system.results.result import Reason, Result
from codesign.system.verdicts import Swing, Verdict


class Amount(ResultModel):
    """A part of a time or of an energy."""

    where: str = Field(description="the component or link")
    what: str = Field(description="the phase, the message, or when power is drawn")
    amount: float = Field(description="s or J")
    share: float = Field(description="share of the whole")
    figures: dict[str, Figure] = Field(default={}, description="the figures that it rests on, by name")


class Why(ResultModel):
    """The parts of a figure, the largest first. They add up to ``value``."""

    figure: str = Field(description="name of the declared figure")
    value: float = Field(description="of the figure, in its unit")
    parts: tuple[Amount, ...] = Field(description="its parts")
    note: str = Field(default="", description="why the parts are those of another time, or have no figures")


class Moved(ResultModel):
    """The design with one thing moved: by a lever, by a step, or as it stands elsewhere in the study."""

    what: str = Field(description="what is moved, in words, or the axis")
    before: Any = Field(default=None, description="the value of the axis in the design")
    after: Any = Field(default=None, description="the value of the axis there")
    index: int | None = Field(default=None, description="of the design in the study; None of a run")
    feasible: bool | None = Field(
        default=None, description="whether the whole design is feasible then; None: it was not tried"
    )
    goes: bool | None = Field(
        default=None, description="of a lever: whether the reason goes that it is a lever for; None: it was not tried"
    )
    out: tuple[str, ...] = Field(default=(), description="what then keeps the design out, in words")
    figures: dict[str, float | None] = Field(default={}, description="the objectives, by name")
    better: tuple[str, ...] = Field(default=(), description="objectives that gain")
    worse: tuple[str, ...] = Field(default=(), description="objectives that lose")
    note: str = Field(default="", description="why it was not tried, or cannot be compared")

    @property
    def dominates(self) -> bool:
        """True if it is feasible, better in an objective and worse in none."""
        return bool(self.feasible and self.better and not self.worse)


class WhyOut(ResultModel):
    """A reason against a design, and each of its levers by itself."""

    reason: Reason = Field(description="demand, limit and gap")
    condition: str = Field(default="", description="the condition that it holds in; empty: all together")
    levers: tuple[Moved, ...] = Field(default=(), description="each lever by itself, those that help first")


class Sure(ResultModel):
    """The certainty of a figure of the design, and its place among the others."""

    figure: str = Field(description="name of the declared figure")
    value: float = Field(description="in the unit of the figure")
    least: float | None = Field(default=None, description="the least value inside all intervals")
    most: float | None = Field(default=None, description="the greatest value inside all intervals")
    moved: Swing | None = Field(default=None, description="the figure with an interval that moves it most")
    verdict: Verdict | None = Field(
        default=None, description="whether the best design by it is the best at every value"
    )
    best: int | None = Field(default=None, description="index of the best design by it")
    rival: int | None = Field(default=None, description="index of the design that decides against the best one")


class AxisEffect(ResultModel):
    """The share of the spread of a figure over the feasible designs that one axis moves; see ``axis_effects``."""

    axis: str = Field(description="name of the axis")
    figure: str = Field(description="name of the declared figure")
    main: float | None = Field(description="share of the variance that the axis moves by itself; None: no spread")
    total: float | None = Field(description="share of the variance that is left where all other axes are known")
    complete: bool = Field(description="whether every combination of the axes is feasible and has the figure")
    paired: float = Field(description="share of the designs with a feasible partner that differs in this axis alone")


class Words(ResultModel):
    """The words of a figure in tables."""

    label: str = Field(description="its name in words")
    unit: str = Field(description="its unit; 1 for a number of things or a share")


class Explanation(ResultModel):
    """The explanation of a design."""

    platform: str = Field(description="name of the platform")
    workload: str = Field(description="name of the workload")
    index: int | None = Field(default=None, description="of the design in its study; None of a run")
    axes: dict[str, Any] = Field(default={}, description="its decisions, or what was set")
    condition: str = Field(
        default="", description="the condition in which time and energy are explained, of a study with conditions"
    )
    feasible: bool = Field(description="whether the design is feasible")
    on_front: bool | None = Field(
        default=None, description="whether no other design of the study dominates it; None of a run"
    )
    objectives: dict[str, float | None] = Field(description="the objectives, by name")
    derived: dict[str, Words] = Field(
        default={}, description="label and unit of objectives that the exploration derives, by name"
    )
    result: Result = Field(exclude=True, description="the result that is explained; no part of the JSON")
    time: Why | None = Field(default=None, description="what the time is made of")
    energy: Why | None = Field(default=None, description="what the energy is made of")
    out: tuple[WhyOut, ...] = Field(default=(), description="why the design is out")
    neighbours: tuple[Moved, ...] = Field(
        default=(), description="designs that differ in one axis; those that are better first"
    )
    sure: tuple[Sure, ...] = Field(default=(), description="how sure each objective is")
    effects: tuple[AxisEffect, ...] = Field(
        default=(), description="how much of the spread of each objective each axis of the study moves"
    )
    notes: tuple[str, ...] = Field(default=(), description="what was not explained, and why")

    def __repr__(self) -> str:
        number = "" if self.index is None else f" {self.index}"
        fate = "feasible" if self.feasible else f"out for {counted(len(self.out), 'reason')}"
        better = sum(each.dominates for each in self.neighbours)
        neighbours = counted(better, "better neighbour")
        return f"Explanation({self.workload} on {self.platform}{number}: {fate}, {neighbours})"


def explanation_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of what ``hwsw explain --json`` prints."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **Explanation.model_json_schema(mode="serialization"),
    }
