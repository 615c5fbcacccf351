"""Components of a platform, as declared in YAML: FPGA, processor, external memory, display, robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, Union, get_args

from pydantic import ConfigDict, Field, PrivateAttr, ValidationInfo, field_validator, model_validator

from codesign.ground.errors import InputError, SpecError
from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part, RefusalError, SpecModel, choice, refused
from codesign.ground.units import format_frequency
from codesign.inputs.fields import (
    AccelerationFigure,
    CountFigure,
    DataFigure,
    FrequencyFigure,
    LengthFigure,
    Name,
    PositiveFigure,
    PowerFigure,
    ShareFigure,
    SpeedFigure,
    TimeFigure,
    TurnRateFigure,
)
from codesign.inputs.hardware import Hardware
from codesign.inputs.library import (
    HOSTS,
    PARTS,
    CalibrationFile,
    Cores,
    Jitter,
    ProcessorPower,
    load_calibration,
    load_part,
)
from codesign.laws import Law, Number
from codesign.laws.acts import FpgaLaw, IdealLaw, KernelLaw, pace_of

MAX_RAYS = 4096


class AnyComponent(Hardware):
    """A component of a platform.

    ``plans``: a task of a planner can be placed on it. ``of_scenario``: a scenario builds it, and no plan needs it.
    """

    law: ClassVar[type[Law]] = IdealLaw
    plans: ClassVar[bool] = False
    of_scenario: ClassVar[bool] = False
    if TYPE_CHECKING:
        type: str

    @property
    def chip(self) -> Part | None:
        """The part of an FPGA; None of anything else."""
        return None

    @property
    def kernels(self) -> Mapping[str, Figure] | None:
        """The cost of each kernel where work is counted in kernels; None where it takes cycles, or none is done."""
        return None

    @property
    def ram(self) -> Figure | None:
        """Bytes of RAM for the arrays of a plan; None where no plan needs any."""
        return None

    @property
    def neighbour(self) -> str | None:
        """The component that it is wired to without a link; None where it has none."""
        return None


class FpgaComponent(AnyComponent):
    """A programmable chip with one clock."""

    law = FpgaLaw
    plans = True
    traded = frozenset({"clock"})

    type: Literal["fpga"] = Field(description="An FPGA.")
    part: str = Field(
        description="Name and speed grade of the part, such as XC4VLX160-12. It is looked for in the folder parts"
        " beside the platform file, then among the shipped parts."
    )
    clock: FrequencyFigure = Field(
        description="Clock of the design, at most the part's block RAM limit (its high, where that is given)."
    )
    calibration: Name | None = Field(
        default=None,
        description="Name of a calibration, which hwsw calibrate fpga fits to reports of your tool. The laws of its"
        " style are multiplied by its factors. It is looked for in the folder calibrations beside the platform file,"
        " then in that of the current folder.",
    )
    _chip: Part = PrivateAttr()
    _calibrated: CalibrationFile | None = PrivateAttr(default=None)

    def prices(self) -> frozenset[str]:
        """Part, clock and calibration."""
        return super().prices() | {"part", "calibration"}

    @property
    def chip(self) -> Part:
        """The part, loaded."""
        return self._chip

    @property
    def calibrated(self) -> CalibrationFile | None:
        """The calibration, loaded."""
        return self._calibrated

    @field_validator("part", mode="after")
    @classmethod
    def _known_part(cls, value: str, info: ValidationInfo) -> str:
        try:
            load_part(value, PARTS.beside(info))
        except SpecError:
            raise
        except InputError as error:
            raise refused(error) from None
        return value

    @model_validator(mode="after")
    def _clock_within_part(self, info: ValidationInfo) -> Self:
        self._chip = load_part(self.part, PARTS.beside(info))
        limit = self._chip.block_ram_clock.interval[1]
        if self.clock.value > limit:
            what = f"{format_frequency(self.clock.value)} is above the {format_frequency(limit)} limit"
            hint = "lower the clock, or choose a faster part"
            raise RefusalError(f"{what} of part {self.part}", hint, ("clock",))
        if self.calibration is not None:
            self._calibrated = load_calibration(self.calibration, self._chip, info)
        return self


def _without_host(schema: dict[str, Any]) -> None:
    """Clock and power are required of a processor that names no host."""
    schema["required"] = ["type"]
    schema["anyOf"] = [{"required": ["host"]}, {"required": ["clock", "power"]}]


def _undeclared(value: Any) -> bool:
    """A platform that does not declare a key has the digest that it had before there was this key."""
    return value is None


class ProcessorComponent(AnyComponent):
    """A processor that runs named kernels.

    A host file may hold its clock, costs, cores and power; keys that are given here take the place of the host's
    keys, costs kernel by kernel, power busy and idle by itself.
    """

    model_config = ConfigDict(json_schema_extra=_without_host)
    law = KernelLaw
    plans = True

    type: Literal["processor"] = Field(
        description="A processor: the robot's host, a PC, or a processor in the FPGA's own chip."
    )
    host: str | None = Field(
        default=None,
        description="Name of a host, such as cortex-a72. It is looked for in the folder hosts beside the platform file,"
        " then among the shipped hosts.",
    )
    clock: FrequencyFigure = Field(description="Clock of the processor. A host brings one.")
    costs: dict[Name, TimeFigure] = Field(
        default={},
        description="Time for one unit of each named kernel, such as harmonic_node_update. hwsw calibrate host"
        " measures it.",
    )
    cores: Cores = Field(
        default=1, description="How many tasks it runs at once. On each core, control runs before planning."
    )
    load: ShareFigure | None = Field(
        default=None,
        exclude_if=_undeclared,
        description="Share of a core's time that other programs take, such as 0.2: a plan then takes 1 / (1 - 0.2)"
        " times as long. Without it, none. A host may bring it; hwsw calibrate host measures it.",
    )
    jitter: Jitter | None = Field(
        default=None,
        exclude_if=_undeclared,
        description="How many times as long a plan takes as on a core that nothing interrupts: the median plan, and the"
        " 99th percentile, which bounds the interval of a time. Without it, once. A host may bring it.",
    )
    memory: DataFigure | None = Field(
        default=None,
        description="RAM for the arrays of a plan. A design that needs more is infeasible. Without it, no map is too"
        " large. A host may bring it.",
    )
    power: ProcessorPower = Field(description="Power, busy and idle. A host brings it.")

    @property
    def kernels(self) -> Mapping[str, Figure]:
        """The cost of each kernel, ps a unit."""
        return self.costs

    @property
    def ram(self) -> Figure | None:
        """Bytes of RAM; None where it is not declared."""
        return None if self.memory is None else self.memory.per(8, "bytes")

    @property
    def pace(self) -> Figure | None:
        """The pace of its kernels, ppm; None where neither load nor jitter is declared."""
        return pace_of(self.load, *((None, None) if self.jitter is None else (self.jitter.median, self.jitter.p99)))

    @property
    def drawing(self) -> ProcessorPower:
        """Its power."""
        return self.power

    def prices(self) -> frozenset[str]:
        """The costs of kernels, their pace, the clock that counts them, and the power; a host moves them all."""
        return frozenset({"host", "clock", "costs", "load", "jitter", "power"})

    def directions(self) -> Mapping[str, int]:
        """None: a cost is of one kernel, and the pace is no key."""
        return {}

    def law_of(self, unit: str, number: Callable[[str], Number]) -> KernelLaw:
        """The law of a kernel."""
        cost = number(f"costs.{unit}")
        return KernelLaw(cost) if self.pace is None else KernelLaw(cost, number("pace"))

    def shape(self) -> Any:
        """All but its prices, the kernels that have a cost, and if they have a pace."""
        return super().shape() | {"costs": sorted(self.costs), "paced": self.pace is not None}

    @model_validator(mode="before")
    @classmethod
    def _filled_by_host(cls, value: Any, info: ValidationInfo) -> Any:
        name = value.get("host") if isinstance(value, dict) else None
        if not isinstance(name, str):
            return value
        folders = HOSTS.beside(info)
        try:
            host = HOSTS.find(name, folders)
            costs = host.all_costs(folders)
        except SpecError:
            raise
        except InputError as error:
            raise RefusalError(error.what, error.hint, ("host",)) from None
        filled = {key: getattr(host, key) for key in ("clock", "cores", "load", "jitter", "memory")} | value
        for key, of_host in (("costs", costs), ("power", dict(host.power))):
            own = value.get(key, {})
            filled[key] = {**of_host, **own} if isinstance(own, dict) else own
        return filled


class BusyPower(SpecModel):
    """Power of a memory or a link while it works and while it waits."""

    busy: PowerFigure = Field(description="While it works.")
    idle: PowerFigure = Field(description="While it waits.")


class MemoryComponent(AnyComponent):
    """External memory for what does not fit in block RAM; the key ``external_memory`` of a task names it.

    It is SRAM, or DRAM with rows that must be opened.
    """

    type: Literal["memory"] = Field(description="Memory outside of the FPGA.")
    technology: Literal["sram", "dram"] = Field(
        description="Kind of memory. A dram needs row_words and row_cycles; an sram has neither."
    )
    beside: Name = Field(description="The FPGA that it is connected to.")
    capacity: DataFigure = Field(description="How much it holds.")
    width: PositiveFigure = Field(description="Bits a word.")
    clock: FrequencyFigure = Field(
        description="Clock of its interface. The design on the FPGA runs no faster than this."
    )
    latency_cycles: CountFigure = Field(description="Cycles from an address to its word, in an open row.")
    row_words: PositiveFigure | None = Field(default=None, description="Words of a row; of a dram only.")
    row_cycles: CountFigure | None = Field(
        default=None, description="Additional cycles when another row is opened; of a dram only."
    )
    refresh_share: Annotated[float, Field(ge=0, lt=1)] = Field(
        default=0.0, description="Share of the time that refreshing takes; of a dram only."
    )
    power: BusyPower | None = Field(
        default=None, description="Power, busy and idle. Without it, the energy counts as 0 J and results say so."
    )

    @property
    def neighbour(self) -> str:
        """The FPGA."""
        return self.beside

    @property
    def drawing(self) -> BusyPower | None:
        """Its power; None where it is not declared."""
        return self.power

    @model_validator(mode="after")
    def _rows_of_dram(self) -> Self:
        for key in ("row_words", "row_cycles"):
            if (getattr(self, key) is None) == (self.technology == "dram"):
                what = f"{key} {'is missing' if self.technology == 'dram' else 'says nothing of an SRAM'}"
                hint = "a DRAM needs row_words and row_cycles, an SRAM has none"
                raise RefusalError(what, hint, () if self.technology == "dram" else (key,))
        return self


class DisplayComponent(AnyComponent):
    """A display that reads its picture from memory, pixel by pixel (VGA), and so competes with the search for reads.

    The result reports for each display (``displays``) the frames drawn, the words that came too late, and its share of
    the memory's cycles.
    """

    type: Literal["display"] = Field(description="A display that scans a memory.")
    beside: Name = Field(description="The FPGA or memory that it reads its picture from.")
    pixel_clock: FrequencyFigure = Field(description="Pixels a second while a line is drawn.")
    columns: PositiveFigure = Field(description="Visible pixels of a line.")
    rows: PositiveFigure = Field(description="Visible lines.")
    total_columns: PositiveFigure = Field(description="Pixel clocks of a line, blanking included.")
    total_rows: PositiveFigure = Field(description="Lines of a frame, blanking included.")
    pixels_a_word: PositiveFigure = Field(description="Pixels that one read brings.")

    @property
    def neighbour(self) -> str:
        """The FPGA or memory that it reads."""
        return self.beside

    @model_validator(mode="after")
    def _blanking(self) -> Self:
        for visible, total in (("columns", "total_columns"), ("rows", "total_rows")):
            if getattr(self, total).value < getattr(self, visible).value:
                what = f"{total} of {getattr(self, total).value} is below {visible}"
                raise RefusalError(what, f"{total} counts the visible {visible} and the blanking", (total,))
        return self


class PointKinematics(SpecModel):
    """A point that takes any velocity at once."""

    type: Literal["point"] = Field(description="A point: any velocity at once.")
    speed: SpeedFigure = Field(description="Greatest speed.")


class OmnidirectionalKinematics(SpecModel):
    """Any direction of motion, with an acceleration limit."""

    type: Literal["omnidirectional"] = Field(description="Any direction, with an acceleration limit.")
    speed: SpeedFigure = Field(description="Greatest speed.")
    acceleration: AccelerationFigure = Field(description="Greatest acceleration, braking included.")


class DifferentialKinematics(SpecModel):
    """Two driven wheels: drives straight, turns on the spot."""

    type: Literal["differential"] = Field(description="Two driven wheels.")
    speed: SpeedFigure = Field(description="Greatest speed.")
    acceleration: AccelerationFigure = Field(description="Greatest acceleration, braking included.")
    turn_rate: TurnRateFigure = Field(description="Rate of turning on the spot.")


KINEMATICS: dict[str, type[SpecModel]] = {
    "point": PointKinematics,
    "omnidirectional": OmnidirectionalKinematics,
    "differential": DifferentialKinematics,
}
Kinematics = Annotated[PointKinematics | OmnidirectionalKinematics | DifferentialKinematics, choice("type", KINEMATICS)]


class RaySensor(SpecModel):
    """Rays in all directions, each up to the first obstacle."""

    type: Literal["rays"] = Field(description="Rays, each up to the first obstacle.")
    range: LengthFigure = Field(description="How far it senses; at 0 m it senses nothing.")
    rays: Annotated[int, Field(ge=1, le=MAX_RAYS)] = Field(description="Rays of one turn.")

    @property
    def beams(self) -> int:
        """Rays of one turn."""
        return self.rays


class RadiusSensor(SpecModel):
    """Everything within a radius, behind walls too."""

    type: Literal["radius"] = Field(description="All within a radius, behind walls too.")
    range: LengthFigure = Field(description="How far it senses; at 0 m it senses nothing.")

    @property
    def beams(self) -> int:
        """No rays."""
        return 0


SENSORS: dict[str, type[SpecModel]] = {"rays": RaySensor, "radius": RadiusSensor}
Sensor = Annotated[RaySensor | RadiusSensor, choice("type", SENSORS)]


class RobotPower(SpecModel):
    """Power of the drives and all else that is no component of its own."""

    moving: PowerFigure = Field(description="While it moves.")
    standing: PowerFigure = Field(description="While it stands.")


class RobotComponent(AnyComponent):
    """The body of a robot, for missions: it moves and senses."""

    of_scenario: ClassVar[bool] = True
    type: Literal["robot"] = Field(description="The robot's body.")
    radius: LengthFigure = Field(
        default=Figure(0.0, "m", Status.ASSUMED, "a point robot"), description="Radius of its outline; 0 m is a point."
    )
    kinematics: Kinematics = Field(description="How it moves.")
    sensor: Sensor = Field(description="How it senses.")
    power: RobotPower = Field(description="Power of the drives and of everything that is no component of its own.")

    @model_validator(mode="after")
    def _moves(self) -> Self:
        for key in ("speed", "acceleration", "turn_rate"):
            figure = getattr(self.kinematics, key, None)
            if figure is not None and figure.value <= 0:
                raise RefusalError(f"a {key} of 0", "give one above 0", ("kinematics", key))
        return self


COMPONENTS: dict[str, type[AnyComponent]] = {
    get_args(kind.model_fields["type"].annotation)[0]: kind for kind in AnyComponent.__subclasses__()
}
"""The kinds of components by their type in YAML: every subclass of ``AnyComponent`` above is one."""

PLANNING_TYPES = tuple(name for name, kind in COMPONENTS.items() if kind.plans)
"""The types of components that a task of a planner can be placed on."""

if TYPE_CHECKING:
    Component = AnyComponent
else:
    Component = Annotated[Union[tuple(COMPONENTS.values())], choice("type", COMPONENTS)]  # noqa: UP007
