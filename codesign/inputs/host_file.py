"""Host files: a processor with the costs of its kernels, which platforms name."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from codesign.ground.errors import InputError
from codesign.ground.figures import Figure, weakest
from codesign.ground.models import SpecModel
from codesign.inputs.base import Spec
from codesign.inputs.fields import DataFigure, FactorFigure, FrequencyFigure, Name, PowerFigure, TimeFigure
from codesign.inputs.library import Library


class ProcessorPower(SpecModel):
    """Power of a processor while it computes and while it waits."""

    busy: PowerFigure = Field(description="While it computes.")
    idle: PowerFigure = Field(description="While it waits.")


Cores = Annotated[int, Field(ge=1, le=1024)]


class CostsOf(SpecModel):
    """The costs of another host, times a factor: of a host that was not measured."""

    host: str = Field(description="Name of the host; it has costs of its own.")
    factor: FactorFigure = Field(description="How many times as long one unit of any kernel takes.")


class HostFile(Spec):
    """A host file: a processor that platforms name with the key ``host`` of a component of type processor."""

    kind: Literal["host"] = Field(description="This file is a host.")
    name: Name = Field(description="Name of the host, which is that of its file.")
    description: str = Field(default="", description="What it is, for readers.")
    clock: FrequencyFigure = Field(description="Clock of the processor.")
    cores: Cores = Field(default=1, description="How many tasks it runs at once.")
    costs: dict[Name, TimeFigure] = Field(
        default={}, description="Time for one unit of each named kernel, measured on this host."
    )
    costs_of: CostsOf | None = Field(
        default=None,
        description="Another host. Its costs, times a factor, are those of every kernel that costs leaves out.",
    )
    memory: DataFigure | None = Field(
        default=None, description="RAM for the arrays of a plan. Without it, no map is too large for the host."
    )
    power: ProcessorPower = Field(description="Power, busy and idle.")

    def all_costs(self, folders: Sequence[Path] = ()) -> dict[str, Figure]:
        """The time of one unit of each kernel, ps: its own costs, and the costs of the other host times the factor.

        ``folders``: searched before the shipped hosts.

        Raises:
            InputError: there is no such other host, or it has no costs of its own.
            SpecError: its file is faulty.
        """
        if self.costs_of is None:
            return self.costs
        other, factor = HOSTS.find(self.costs_of.host, folders), self.costs_of.factor
        if not other.costs:
            what = f"host {self.name} has the costs of host {other.name}, which has none of its own"
            raise InputError(what, hint="name a host with costs in its file")
        return {kernel: _times(cost, factor, other.name) for kernel, cost in other.costs.items()} | self.costs

    def state(self, folders: Sequence[Path] = ()) -> tuple[object, ...]:
        """The states of the files behind this host: see ``Library.state``."""
        return HOSTS.state([self.name, *([self.costs_of.host] if self.costs_of else [])], folders)


def _times(cost: Figure, factor: Figure, host: str) -> Figure:
    """A cost (ps) times a factor: the low end of both, and the high end of both."""
    (low, high), (least, most) = cost.interval, factor.interval
    return Figure(
        value=max(1, round(cost.value * factor.value)),
        unit=cost.unit,
        status=weakest(cost.status, factor.status),
        source=f"{factor.value:g} times that of {host}, {cost.value:,} ps ({cost.source}); {factor.source}",
        low=max(1, round(low * least)),
        high=max(1, round(high * most)),
    )


HOSTS = Library("host", HostFile)
"""Host files."""


def host_state(name: str, folders: Sequence[Path] = ()) -> tuple[object, ...]:
    """The states of the files behind a host; () if there is no such host, or its file is faulty."""
    try:
        return HOSTS.find(name, folders).state(folders)
    except InputError:
        return ()
