"""A platform and a workload that are right, for tests that put a mistake in."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar

from pydantic import ConfigDict, Field, model_validator

from codesign.ground.errors import SpecError
from codesign.ground.models import RefusalError, SpecModel, TaskParameters
from codesign.inputs import Platform, Workload, cross_check, design_point, list_parts, load_platform, load_workload

PLATFORM = """\
kind: platform
name: mine
components:
  fpga: {type: fpga, part: XC4VLX160-12, clock: 150 MHz}
  host:
    type: processor
    clock: 2 GHz
    costs:
      harmonic_node_update: {value: 40 ns, status: measured, source: own run, low: 35 ns, high: 50 ns}
    power: {busy: 75 W, idle: 25 W}
links:
  pci: {type: bus, between: [host, fpga], width: 32, clock: 33 MHz, setup_cycles: 8, burst_words: 16}
"""

WORKLOAD = """\
kind: workload
name: mine
planner: harmonic
problem:
  map: {generate: rooms, rows: 40, columns: 60, room: [8, 8]}
  goals: [[4, 10]]
mapping:
  relax:
    component: fpga
    block: [20, 30]
    iterations: 6
    schedule: {first: 7, step: 8, last: 63}
explore:
  axes:
    relax.block: [[20, 30], [10, 15]]
    relax.schedule.last: [63, 127]
    fpga.clock: [100 MHz, 150 MHz]
"""


ON_A_MAP = """\
kind: workload
name: w
planner: harmonic
problem:
  map: {{file: {file}}}
  goals: [[0, 0]]
mapping:
  relax: {{component: fpga, block: [1, 2], iterations: 4, schedule: [7]}}
"""


class Range(SpecModel):
    first: Annotated[int, Field(ge=1)]
    step: Annotated[int, Field(ge=1)]
    last: Annotated[int, Field(ge=1, le=1023)]

    @model_validator(mode="after")
    def _rises(self) -> Range:
        if self.last < self.first:
            raise RefusalError(f"last {self.last} is below first {self.first}", "raise last", ("last",))
        return self


class Relax(TaskParameters):
    alternatives: ClassVar[dict[str, tuple[str, ...]]] = {"block": ("blocks",), "blocks": ("block",)}

    block: tuple[int, int] | None = None
    blocks: tuple[int, int] | None = None
    iterations: Annotated[int, Field(ge=1)]
    schedule: Range | tuple[int, ...]
    exact: bool = True
    share: float = 1.0

    @model_validator(mode="after")
    def _one_partition(self) -> Relax:
        if (self.block is None) == (self.blocks is None):
            raise ValueError("give block or blocks")
        return self


class Decide(TaskParameters):
    """A plain pydantic model, as a user's own planner may bring it."""

    model_config = ConfigDict(extra="forbid", frozen=True)


TASKS = {"harmonic": {"relax": Relax, "decide": Decide}}

PARTS = sorted({name.rpartition("-")[0] for name in list_parts()})


def faults(text: str, *changes: tuple[str, str]) -> str:
    """What loading says of one of the texts above with some of it replaced; writes into the current folder."""
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file = Path("w.yaml" if text.startswith("kind: workload") else "p.yaml")
    file.write_text(text, encoding="utf-8")
    try:
        load_workload(file, TASKS) if file.stem == "w" else load_platform(file)
    except SpecError as error:
        return str(error)
    return ""


def assert_axes_are_sound(platform: Platform, workload: Workload) -> None:
    """The two go together, and each value of an axis makes a design point of its own."""
    cross_check(platform, workload)
    for axis, values in workload.explore.axes.items():
        made = [design_point(platform, workload, {axis: value}) for value in values]
        assert len({tuple(spec.digest() for spec in point) for point in made}) == len(values), axis
