"""Files that platforms refer to by name, beside the platform file or shipped: parts, hosts and calibrations.

``hwsw calibrate fpga`` writes calibration files: how far the laws of a style are from the reports of a user's own tool.
The FPGA of a platform names one with the key ``calibration``; the laws of that style are then multiplied by its
factors.
"""

from __future__ import annotations

import contextlib
import functools
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Annotated, Generic, Literal, Self, TypeVar

from more_itertools import map_reduce
from pydantic import Field, ValidationInfo, model_validator

from codesign.ground.errors import Fault, InputError, SpecError, choose_hint, clip
from codesign.ground.figures import RESOURCES, Figure, Status, weakest
from codesign.ground.models import SPEED_GRADE_PATTERN, OtherRam, Part, RefusalError, SpecModel
from codesign.inputs.base import Spec
from codesign.inputs.document import Document
from codesign.inputs.faults import validate
from codesign.inputs.fields import (
    CountFigure,
    DataFigure,
    FactorFigure,
    FrequencyFigure,
    Name,
    PowerFigure,
    ShareFigure,
    SlicePowerFigure,
    TimeFigure,
)
from codesign.inputs.files import data_folder, shown
from codesign.inputs.yaml_tree import read_document

F = TypeVar("F", bound=Spec)

FOLDERS = ("parts", "hosts")
"""The folders beside a platform file, and in the folder of shipped platforms, that have such files."""


class Library(Generic[F]):
    """The files of one kind. Folders are searched in the order given, the shipped one last.

    Args:
        kind: what one of them is, such as ``part``; its folder is named ``parts``.
        model: that the files are validated against.
    """

    def __init__(self, kind: str, model: type[F]) -> None:
        self.kind = kind
        self.model = model
        self._read = functools.lru_cache(maxsize=256)(self._read_afresh)

    @property
    def shipped(self) -> Path:
        """The folder of the shipped files."""
        return data_folder("platforms") / f"{self.kind}s"

    def beside(self, info: ValidationInfo) -> tuple[Path, ...]:
        """The folder beside the file that is being validated."""
        document = (info.context or {}).get("document")
        return (document.folder / f"{self.kind}s",) if document else ()

    def names(self, folders: Sequence[Path] = ()) -> dict[str, Path]:
        """The path of each file, by its name without ``.yaml``."""
        paths: dict[str, Path] = {}
        for folder in (*folders, self.shipped):
            # No folder, no files.
            with contextlib.suppress(OSError):
                found = [name for name in os.listdir(folder) if name.endswith(".yaml")]
                paths |= {stem: folder / name for name in found if (stem := name.removesuffix(".yaml")) not in paths}
        return paths

    def find(self, name: str, folders: Sequence[Path] = ()) -> F:
        """The file of that name.

        Raises:
            InputError: no such file; with the nearest one and the list.
            SpecError: a faulty file.
        """
        paths = self.names(folders)
        if name not in paths:
            raise InputError(f"there is no {self.kind} {clip(name)!r}", hint=choose_hint(clip(name, 60), paths))
        return self.load(paths[name])

    def load(self, path: Path) -> F:
        """A file; read once a process as long as it does not change.

        Raises:
            SpecError: all the faults of the file.
        """
        try:
            state = path.stat()
        except OSError:
            return self._read(path, 0, 0)
        return self._read(path, state.st_mtime_ns, state.st_size)

    def state(self, names: Sequence[str], folders: Sequence[Path] = ()) -> tuple[tuple[int, int], ...]:
        """The times of change and the sizes of the files of these names: what is kept of them holds for this alone."""
        states = []
        for folder in (*folders, self.shipped):
            for name in names:
                with contextlib.suppress(OSError, ValueError):
                    state = os.stat(f"{folder}/{name}.yaml")
                    states.append((state.st_mtime_ns, state.st_size))
        return tuple(states)

    def _read_afresh(self, path: Path, _modified: int, _size: int) -> F:
        document = read_document(path, shown(path))
        return validate(self.model, document, also=self._name_fault).with_document(document)

    def _name_fault(self, document: Document) -> list[Fault]:
        """They are found by the names of their files, so the two have to agree."""
        name = document.tree.get("name") if isinstance(document.tree, dict) else None
        expected = Path(document.file).stem
        if not isinstance(name, str) or name == expected:
            return []
        hint = f"give file and {self.kind} the same name"
        return [document.fault(("name",), f"{clip(name)!r} in file {expected}.yaml", hint)]


# Part files: a chip in all its speed grades, found by name and read.


class Resources(SpecModel):
    """Budgets of a part; 0 for what it lacks.

    ``lut4``, two of them a slice, or ``lut6`` where a slice has four or eight LUT of six inputs and twice as many
    flip-flops (Virtex-5 and later). ``block_rams``: as one of ``BlockRam.shapes``; of 36 kbit counts as two.
    """

    slices: CountFigure = Field(
        description="Slices; of a part whose logic cells are not in slices of two LUT, half of the cells."
    )
    lut4: CountFigure | None = Field(default=None, description="LUTs of four inputs; this or lut6 is required.")
    lut6: CountFigure | None = Field(default=None, description="LUTs of six inputs, four or eight of them in a slice.")
    flip_flops: CountFigure = Field(description="Flip-flops.")
    block_rams: CountFigure = Field(
        description="Block RAMs, each of which can have the shapes of block_ram; one of 36 kbit counts as two of 18."
    )
    multipliers: CountFigure = Field(description="Multipliers of 18 × 18 bits, or the nearest that the part has.")

    @model_validator(mode="after")
    def _one_make_of_lut(self) -> Self:
        if (self.lut4 is None) == (self.lut6 is None):
            what = "neither lut4 nor lut6 is given" if self.lut4 is None else "both lut4 and lut6 are given"
            raise RefusalError(what, "give the one that the part's slices are made of")
        return self

    def counted(self) -> dict[str, Figure]:
        """The budgets by kind as laws count them: in LUT4, and in slices of two LUT4 and two flip-flops.

        A LUT6 does what any LUT4 does; it does the work of two where they need no more than five inputs between them.
        So the conversion is a floor, and the interval reaches to twice as much.
        """
        counted = {kind: getattr(self, kind) for kind in RESOURCES}
        if self.lut6 is not None:
            lut6 = "a LUT6 taken for each LUT4 of a law, though two may share one"
            shares = f"laws count slices of two LUT and two flip-flops, {self.counted_a_slice} for each of these"
            counted["lut4"] = _converted(self.lut6, 1, lut6)
            counted["slices"] = _converted(self.slices, self.counted_a_slice, shares)
        return counted

    @property
    def counted_a_slice(self) -> int:
        """Slices of two LUT and two flip-flops, as laws count them, that stand in one of the part."""
        if self.lut6 is None:
            return 1
        return max(1, int(self.lut6.value) // (2 * max(1, int(self.slices.value))))


def _converted(figure: Figure, factor: int, how: str) -> Figure:
    """``factor`` times a count of LUT6 or of their slices, and up to twice as much."""
    amount = factor * int(figure.value)
    return Figure(amount, figure.unit, Status.ASSUMED, f"{figure.source}; {how}", amount, 2 * amount)


class BlockRam(SpecModel):
    """The (depth, width) shapes that one block RAM may be configured as."""

    shapes: Annotated[
        tuple[tuple[Annotated[int, Field(ge=1, le=2**24)], Annotated[int, Field(ge=1, le=4096)]], ...],
        Field(min_length=1, max_length=64),
    ] = Field(description="Shapes that one block RAM can have: [depth, width], in words and bits.")


class OtherRamBlock(BlockRam):
    """RAM of a part besides its block RAM, of one kind."""

    count: CountFigure = Field(description="How many blocks of it.")
    ports: Literal[1, 2] = Field(description="Words that one block reads or writes in a cycle.")
    clock: FrequencyFigure = Field(description="Its fastest clock.")


class PartPower(SpecModel):
    """Power: ``static`` of the chip, ``dynamic`` of one occupied slice of it at 1 MHz and typical activity."""

    static: PowerFigure = Field(description="Of the chip, whatever it does.")
    dynamic: SlicePowerFigure = Field(description="Of one occupied slice at 1 MHz and typical activity.")


class SpeedGrade(SpecModel):
    """Limits of one speed grade."""

    block_ram_clock: FrequencyFigure = Field(description="Fastest clock of a block RAM.")


SpeedGradeName = Annotated[str, Field(pattern=SPEED_GRADE_PATTERN, max_length=8)]


class PartFile(Spec):
    """A part file: one chip in all its speed grades."""

    kind: Literal["part"] = Field(description="This file is a part.")
    name: Name = Field(description="Name of the part, which is that of its file.")
    family: str = Field(description="Family of the chip, such as Virtex-4.")
    description: str = Field(default="", description="What it is, for readers.")
    resources: Resources = Field(description="Budgets of the part.")
    block_ram: BlockRam = Field(description="What one block RAM can be.")
    other_rams: dict[Name, OtherRamBlock] = Field(
        default={}, description="RAM besides the block RAM, by the name of its kind, such as UltraRAM."
    )
    power: PartPower = Field(description="Power, static and dynamic.")
    speed_grades: Annotated[dict[SpeedGradeName, SpeedGrade], Field(min_length=1)] = Field(
        description='Limits by speed grade, such as "-12".'
    )

    def part(self, speed_grade: str) -> Part:
        """The chip in one of its speed grades."""
        return Part(
            name=self.name,
            family=self.family,
            speed_grade=speed_grade,
            resources=self.resources.counted(),
            block_ram_shapes=self.block_ram.shapes,
            block_ram_clock=self.speed_grades[speed_grade].block_ram_clock,
            static_power=self.power.static,
            dynamic_power=self._dynamic_power(),
            other_rams={
                name: OtherRam(ram.count, ram.shapes, ram.ports, ram.clock) for name, ram in self.other_rams.items()
            },
        )

    def _dynamic_power(self) -> Figure:
        """Of one slice as laws count them."""
        figure = self.power.dynamic
        share = self.resources.counted_a_slice
        if share == 1:
            return figure
        low, high = (bound / share for bound in figure.interval)
        text = f"{figure.source}; 1/{share} of it for each of the {share} slices that laws count in one of these"
        return Figure(figure.value / share, figure.unit, figure.status, text, low, high)


PARTS = Library("part", PartFile)
"""Part files."""


def load_part(full_name: str, folders: Sequence[Path] = ()) -> Part:
    """The part with a name and speed grade such as ``XC4VLX160-12``.

    Args:
        full_name: name and speed grade.
        folders: searched before the shipped parts, for files ``NAME.yaml``.

    Raises:
        InputError: no such part or speed grade; with the nearest one and the list.
        SpecError: a faulty part file.
    """
    name, grade = (full_name, "") if full_name in PARTS.names(folders) else name_and_grade(full_name)
    part_file = PARTS.find(name, folders)
    if grade not in part_file.speed_grades:
        grades = [f"{name}{accepted}" for accepted in part_file.speed_grades]
        lacks = f"no speed grade {clip(grade)!r}" if grade else "several speed grades; one has to be named"
        raise InputError(f"part {name} has {lacks}", hint=choose_hint(clip(full_name, 60), grades))
    return part_file.part(grade)


def name_and_grade(full_name: str) -> tuple[str, str]:
    """Name and speed grade of a full name; the name alone where there is no dash.

    >>> name_and_grade("LFE5U-85F-8"), name_and_grade("XC4VLX160")
    (('LFE5U-85F', '-8'), ('XC4VLX160', ''))
    """
    name, dash, grade = full_name.rpartition("-")
    return (name, dash + grade) if dash else (full_name, "")


def all_parts(folders: Sequence[Path] = ()) -> dict[str, Part]:
    """All parts, in every speed grade, by full name, sorted."""
    files = [PARTS.load(path) for path in PARTS.names(folders).values()]
    parts = [file.part(grade) for file in files for grade in file.speed_grades]
    return {part.full_name: part for part in sorted(parts, key=lambda part: part.full_name)}


def list_parts(folders: Sequence[Path] = ()) -> list[str]:
    """Full names of all parts, in every speed grade, sorted."""
    return list(all_parts(folders))


# Host files: a processor with the costs of its kernels, which platforms name.


class ProcessorPower(SpecModel):
    """Power of a processor while it computes and while it waits."""

    busy: PowerFigure = Field(description="While it computes.")
    idle: PowerFigure = Field(description="While it waits.")


Cores = Annotated[int, Field(ge=1, le=1024)]


class Jitter(SpecModel):
    """How much longer a plan takes than on a core that nothing interrupts, apart from the load."""

    median: FactorFigure = Field(description="Of the median plan, at least 1.")
    p99: FactorFigure = Field(description="Of the 99th percentile of plans. The greatest time of a plan is of it.")

    @model_validator(mode="after")
    def _rises(self) -> Self:
        for key, least, what in (("median", 1.0, "1"), ("p99", self.median.value, "the median")):
            if getattr(self, key).value < least:
                hint = "jitter is the time of a plan over its time on a core that nothing interrupts"
                raise RefusalError(f"{getattr(self, key).value:g} is below {what}", hint, (key,))
        return self


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
    load: ShareFigure | None = Field(
        default=None, description="Share of a core's time that other programs take. Without it, none."
    )
    jitter: Jitter | None = Field(
        default=None, description="How much longer a plan takes than on a core that nothing interrupts. Without it, no."
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


# Calibration files.

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
