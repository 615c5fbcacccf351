"""The contents of a report of a synthesis or place-and-route tool, in the terms of the laws.

Resources are counted as the laws count them: LUT (``lut4``; a LUT of six inputs counts as one), flip-flops, block RAMs
of 18 kbit (one of 36 counts as two), multipliers of about 18 × 18 bits. ``slices``: as the tool counts. The part file
says how many of them the laws count in one (``PartFile.resources.counted_a_slice``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum


class Stage(IntEnum):
    """The state that the design had come to, earliest first. A later stage takes the place of an earlier one."""

    SYNTHESISED = 0
    PLACED = 1
    ROUTED = 2

    @property
    def word(self) -> str:
        """The stage in a word: ``routed``."""
        return self.name.lower()


@dataclass(frozen=True)
class Reading:
    """One number of a report, and its line."""

    value: float
    line: int


@dataclass(frozen=True)
class ClockReading:
    """The clock of one domain, Hz.

    - ``fmax``: the fastest clock by the tool's analysis. ``constraint``: what was asked for; None where nothing was.
    """

    name: str
    fmax: Reading
    constraint: float | None = None

    @property
    def met(self) -> bool:
        """True if the constraint was met. The tool then had no reason to go on, so ``fmax`` is a lower bound."""
        return self.constraint is not None and self.fmax.value >= self.constraint


@dataclass(frozen=True)
class Inside:
    """The resources of one place of the hierarchy by itself, without what is deeper inside.

    ``modules``: the path of modules to it, with its own, from the one below the top on; () is the top. Equal places are
    summed.
    """

    modules: tuple[str, ...]
    used: Mapping[str, Reading]


@dataclass(frozen=True)
class Report:
    """One report file.

    - ``tool``, ``version``, ``date``: as the report writes them; "" where it does not.
    - ``family``: how the name of the family of the part begins, where the report shows that alone.
    - ``top``: the top module. ``part``: the part with its speed grade, as the tool writes it. "" where not said.
    - ``used``: by resource. ``hierarchy``: the same by place, where the report has a hierarchy.
    - ``clocks``: by domain. ``static``, ``dynamic``: power, W. ``power_clock``: the clock of the power analysis, Hz.
    - ``notes``: what a reader must know of these numbers, sentences.
    """

    file: str
    digest: str
    tool: str
    version: str
    stage: Stage
    date: str = ""
    top: str = ""
    part: str = ""
    family: str = ""
    used: Mapping[str, Reading] = field(default_factory=dict)
    hierarchy: tuple[Inside, ...] = ()
    clocks: tuple[ClockReading, ...] = ()
    static: Reading | None = None
    dynamic: Reading | None = None
    power_clock: float | None = None
    notes: tuple[str, ...] = ()

    def cited(self, reading: Reading) -> str:
        """Tool, file and line of a number."""
        return f"{self.made_by}, {self.file}:{reading.line}"

    @property
    def made_by(self) -> str:
        """The tool and its version."""
        return f"{self.tool} {self.version}".rstrip()


def added(used: Mapping[str, Reading], more: Mapping[str, Reading], times: int = 1) -> dict[str, Reading]:
    """Two counts as one, the second ``times`` over. A line is the later of both."""
    total = dict(used)
    for resource, reading in more.items():
        before = total.get(resource, Reading(0.0, 0))
        total[resource] = Reading(before.value + times * reading.value, max(before.line, reading.line))
    return total
