"""Calibration files: how far the laws of a style are from the reports of a user's own tool.

``hwsw calibrate fpga`` writes them. The FPGA of a platform names one with the key ``calibration``; the laws of that
style are then multiplied by its factors.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Annotated, Literal, Self

from more_itertools import map_reduce
from pydantic import Field, ValidationInfo, model_validator

from codesign.ground.errors import InputError, SpecError, clip
from codesign.ground.figures import RESOURCES
from codesign.ground.models import Part, RefusalError, SpecModel
from codesign.inputs.base import Spec
from codesign.inputs.fields import FactorFigure, Name
from codesign.inputs.library import Library

CLOCK, STATIC, DYNAMIC = "clock", "static_power", "dynamic_power"
TERMS = (*RESOURCES, CLOCK, STATIC, DYNAMIC)
"""The figures that both a report and a law give: the resources, the clock limit, and the power."""

UNITS: Mapping[str, str] = {CLOCK: "Hz", STATIC: "W", DYNAMIC: "W"}
"""The units of the terms that are no counts."""

LEAST_FACTOR, MOST_FACTOR = 1 / 20, 20.0
"""Beyond these a report is of another design, or of another part."""
LEAST_SURE, MOST_SURE = 1 / 2, 2.0
"""Beyond these a factor has to be explained: most of the time the report has more than the design."""

Amount = Annotated[float, Field(gt=0, le=1e12)]


class Sample(SpecModel):
    """One number of a report beside the law's number, both in Hz, W or counts."""

    design: Annotated[str, Field(min_length=1, max_length=256)] = Field(
        description="The design: its top module, or platform and workload."
    )
    predicted: Amount = Field(description="By the law, without a calibration: Hz, W or a count.")
    reported: Amount = Field(description="By the report, in the same unit.")
    report: Annotated[str, Field(min_length=1, max_length=512)] = Field(
        description="The tool, and file and line of the report."
    )


class FittedTerm(SpecModel):
    """One term: the factor and the offset of its law, and what they were fitted to."""

    factor: FactorFigure = Field(description="What the law is multiplied by, with its interval.")
    offset: Annotated[float, Field(ge=-1e12, le=1e12)] = Field(
        default=0.0, description="What is added then: a count, fitted to four designs or more of several sizes."
    )
    margin: Annotated[float, Field(ge=0, le=1e6)] = Field(
        default=0.0,
        description="With an offset: Student's quantile times the scatter of reported / predicted about the line.",
    )
    explained: Annotated[str, Field(max_length=512)] = Field(
        default="", description="Why reports differ from the law by more than a factor of 2."
    )
    held_out: Annotated[float, Field(ge=0)] | None = Field(
        default=None,
        description="Mean relative error on each design in turn, fitted to the others; left out for one design.",
    )
    samples: Annotated[tuple[Sample, ...], Field(min_length=1, max_length=10_000)] = Field(
        description="What the factor was fitted to."
    )

    def at(self, predicted: float) -> tuple[float, float, float]:
        """The factor on a law that says ``predicted``: the value, and its interval (low, high)."""
        factor = self.factor.value
        low, high = (bound / factor for bound in self.factor.interval)
        value = max(LEAST_FACTOR * factor, factor + self.offset / predicted)
        width = self.margin * math.sqrt(1 + leverage(list(inverse_sizes(self.samples).values()), 1 / predicted))
        return value, max(0.0, min(low * value, value - width)), max(high * value, value + width)

    @model_validator(mode="after")
    def _plausible(self) -> Self:
        ratios = [sample.reported / sample.predicted for sample in self.samples]
        factor, mean = self.factor.value, math.exp(math.fsum(map(math.log, ratios)) / len(ratios))
        if not LEAST_FACTOR <= mean <= MOST_FACTOR or not LEAST_FACTOR <= factor <= MOST_FACTOR:
            what = f"a factor of {factor:g} is of another design or part"
            raise RefusalError(what, f"from {LEAST_FACTOR:g} to {MOST_FACTOR:g}", ("factor",))
        if not LEAST_SURE <= mean <= MOST_SURE and not self.explained:
            what = f"reports that are {mean:.3g} times the law are not explained"
            raise RefusalError(what, "say why, or calibrate with reports of the design alone", ("explained",))
        outside = not self.offset and not min(ratios) * (1 - 1e-3) <= factor <= max(ratios) * (1 + 1e-3)
        for sample, ratio in zip(self.samples, ratios, strict=True):
            _, low, high = self.at(sample.predicted)
            outside = outside or not low * (1 - 1e-3) <= ratio <= high * (1 + 1e-3)
        if outside:
            what = f"a factor of {factor:g} is outside of its samples, {min(ratios):.3g} to {max(ratios):.3g}"
            raise RefusalError(what, "write the file again with hwsw calibrate fpga", ("factor",))
        return self


def inverse_sizes(samples: Iterable[Sample]) -> dict[str, float]:
    """The mean of 1 / predicted of each design, by its name."""
    return map_reduce(
        samples, attrgetter("design"), lambda sample: 1 / sample.predicted, lambda group: math.fsum(group) / len(group)
    )


def leverage(fitted: Sequence[float], at: float) -> float:
    """The variance of a fitted line at a place, over the variance of one point it was fitted to.

    >>> leverage([1.0, 2.0, 3.0], 2.0), leverage([1.0, 2.0, 3.0], 3.0)
    (0.3333333333333333, 0.8333333333333333)
    """
    mean = math.fsum(fitted) / len(fitted)
    squares = math.fsum((each - mean) ** 2 for each in fitted)
    return 1 / len(fitted) + ((at - mean) ** 2 / squares if squares else 0.0)


class CalibrationFile(Spec):
    """A calibration file: factors for the laws of one style on one family, fitted to reports."""

    kind: Literal["calibration"] = Field(description="This file is a calibration.")
    name: Name = Field(description="Name of the calibration, which is that of its file.")
    description: str = Field(default="", description="What it is, for readers.")
    planner: Name = Field(description="Planner whose laws it is for.")
    style: Name = Field(description="Style whose laws it is for.")
    task: str = Field(default="", description="Task that is placed by itself; empty for the planning task.")
    family: Annotated[str, Field(min_length=1)] = Field(description="Family of the chip, such as ECP5.")
    part: Annotated[str, Field(min_length=1)] = Field(description="Part of the reports, with its speed grade.")
    tools: Annotated[tuple[str, ...], Field(min_length=1)] = Field(description="Tools and their versions.")
    reports: dict[str, str] = Field(description="SHA-256 of each report file, by its name.")
    codesign: str = Field(description="Version of hwsw that wrote it.")
    date: str = Field(description="The day on which it was written, UTC.")
    terms: Annotated[dict[Literal[TERMS], FittedTerm], Field(min_length=1)] = Field(  # type: ignore[valid-type]
        description="The terms that it corrects: slices, lut4, flip_flops, block_rams, multipliers, clock,"
        " static_power, dynamic_power."
    )

    def contradiction(self, part: Part) -> str | None:
        """The reason for which its reports cannot be of a chip like ``part``; None if they can."""
        if self.family != part.family:
            return f"was fitted on {self.family}, and {part.name} is a {part.family}"
        if self.part.rpartition("-")[0] != part.name:
            return None
        limit = part.block_ram_clock.interval[1]
        for term, fitted in self.terms.items():
            most = part.resources[term].interval[1] if term in part.resources else None
            for sample in fitted.samples:
                if term == CLOCK and self.part == part.full_name and sample.reported > limit:
                    what = f"{sample.reported / 1e6:.1f} MHz ({sample.report}) is above the {limit / 1e6:g} MHz"
                    return f"{what} that a block RAM of {part.full_name} reaches"
                if most is not None and sample.reported > most:
                    return f"{sample.reported:,.0f} {term} ({sample.report}) are more than {part.name} has, {most:,}"
        return None


CALIBRATIONS = Library("calibration", CalibrationFile)
"""Calibration files. None ships."""


def calibration_folders(folder: Path) -> tuple[Path, ...]:
    """The folders of the calibrations of a platform file in ``folder``: beside it, then below the current folder."""
    return folder / "calibrations", Path("calibrations")


def load_calibration(name: str, part: Part, info: ValidationInfo) -> CalibrationFile:
    """The calibration that an FPGA of a platform names.

    Raises:
        RefusalError: there is none of that name, or it cannot be of the part.
        SpecError: a faulty file.
    """
    document = (info.context or {}).get("document")
    folders = calibration_folders(document.folder if document else Path())
    try:
        calibration = CALIBRATIONS.find(name, folders)
    except SpecError:
        raise
    except InputError as error:
        hint = error.hint if CALIBRATIONS.names(folders) else "hwsw calibrate fpga -o calibrations/NAME.yaml writes one"
        raise RefusalError(error.what, hint, ("calibration",)) from None
    contradiction = calibration.contradiction(part)
    if contradiction is not None:
        what, hint = (f"calibration {clip(name, 40)} {contradiction}", "name one of this part, or leave the key out")
        raise RefusalError(what, hint, ("calibration",))
    return calibration


def calibration_state(name: str, folder: Path) -> tuple[object, ...]:
    """The state of the file of a calibration, which moves when the file is changed; see ``Library.state``."""
    return CALIBRATIONS.state([name], calibration_folders(folder))


def all_digests(folder: Path) -> dict[str, str]:
    """The digest of each calibration that a platform file in ``folder`` may name, but those that are faulty."""
    return _digests(calibration_folders(folder))


def _digests(folders: Sequence[Path]) -> dict[str, str]:
    digests = {}
    for name, path in CALIBRATIONS.names(folders).items():
        try:
            digests[name] = CALIBRATIONS.load(path).digest()
        except SpecError:
            continue
    return digests
