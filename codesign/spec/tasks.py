"""Tasks of a workload beside those of its planner: those that its scenario brings, and those the user adds."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from codesign.spec.fields import Name
from codesign.spec.model import SpecModel

MAX_TASKS = 256
MAX_BITS = 10**12


class PlacedTask(SpecModel):
    """A task with nothing to choose but its place."""


SCENARIO_TASKS: dict[str, tuple[str, ...]] = {
    "plan_once": ("load", "command"),
    "drive": ("sense", "load", "command", "move", "display"),
    "fleet": ("load", "command", "display"),
}
"""The tasks that each scenario brings, in the order in which data flow through them.

- ``sense``: the robot looks around. ``load``: keeps the map and brings it to the planner.
- ``command``: asked for the plan, and tells the robot where to go. ``move``: the robot goes there.
- ``display``: draws what it is sent.
"""

Bits = Annotated[int, Field(ge=1, le=MAX_BITS)]


class ExtraTask(SpecModel):
    """A task that follows others and gives nothing back: logging, drawing, supervision.

    It runs each time a task that it comes after has ended, ``units`` of ``kernel`` on its processor.
    """

    name: Name = Field(description="Its name, which the mapping places.")
    after: Annotated[dict[Name, Bits], Field(min_length=1, max_length=MAX_TASKS)] = Field(
        description="The tasks that it follows, each with the bits that it is sent."
    )
    kernel: Name = Field(description="The kernel that it runs; its processor gives the cost.")
    units: Annotated[int, Field(ge=0, le=10**12)] = Field(default=1, description="Units of the kernel.")
