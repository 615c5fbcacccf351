"""The design point that a report is of: named by the user, or recognised by the manifest of ``hwsw rtl``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from codesign.ground.errors import Fault, InputError, SpecError, UnsuitedError, clip
from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part
from codesign.hardware.calibrate.reports import Report
from codesign.hardware.rtl.design import PREFIX, top_name
from codesign.hardware.rtl.export import MANIFEST
from codesign.hardware.rtl.placed import job_of, on_fpgas
from codesign.inputs import Platform, Workload, load_platform
from codesign.inputs.components import FpgaComponent
from codesign.inputs.library import CLOCK, PARTS, STATIC
from codesign.planners.circuits import Circuit
from codesign.planners.job import Demand, Job
from codesign.planners.styles import Architecture, TaskStyle
from codesign.system import System, catalog, point_of
from codesign.system.fit import Laws
from codesign.system.scenarios import bind

FOLDERS_UP = 4
"""Tools write their reports into folders of their own, below the folder of the design."""

MOST_MANIFEST = 2**20


@dataclass(frozen=True)
class DesignPoint:
    """A design point on an FPGA, with what the laws of its style say.

    ``name``: as samples name it. ``task``: that is placed by itself on ``component``; "" for the planning task.
    """

    name: str
    system: System
    component: FpgaComponent
    task: str = ""

    @property
    def part(self) -> Part:
        """The chip."""
        return self.component.chip

    @property
    def style(self) -> Architecture | TaskStyle:
        """The style of the task."""
        return self.system.placement.styles[self.task] if self.task else self.system.architecture

    @cached_property
    def job(self) -> Job[Any, Any]:
        """The job that the laws of the task, and its circuit, are asked about."""
        return job_of(self.system, self.task, self.component)

    @cached_property
    def laws(self) -> Laws:
        """The laws, without a calibration."""
        return Laws(self.style, self.part)

    @cached_property
    def demand(self) -> Demand:
        """The demand by the laws."""
        return self.laws.demand(self.job)

    @cached_property
    def counted_a_slice(self) -> int:
        """Slices as laws count them in one slice of the part."""
        folders = (self.system.platform.document.folder / "parts",)
        return PARTS.find(self.part.name, folders).resources.counted_a_slice

    @cached_property
    def circuit(self) -> Circuit | None:
        """Its circuit; None where the style has none for these parameters."""
        style = catalog.circuits().get((self.system.planner.name, self.style.style, self.task))
        try:
            return None if style is None else style.circuit(self.job)
        except UnsuitedError:
            return None

    @property
    def top(self) -> str | None:
        """The name of the top module of its circuit; None where it has none."""
        return None if self.circuit is None else top_name(self.circuit)

    def predicted(self, term: str) -> Figure:
        """A resource, the clock limit (Hz) or the static power (W), by the law."""
        if term == CLOCK:
            return self.laws.clock_limit(self.job)
        if term == STATIC:
            return self._power(int(self.component.clock.value))[0]
        lines = [line.figure for line in self.demand.items if line.resource == term]
        low, high = (sum(figure.interval[end] for figure in lines) for end in (0, 1))
        value = self.demand.total(term)
        return Figure(value, "1", Status.CALIBRATED, "sum of its lines", min(low, value), max(high, value))

    def _power(self, clock: int) -> tuple[Figure, Figure]:
        return self.laws.power(self.laws.power_demand(self.job, self.demand), clock)

    def dynamic_power(self, clock: float) -> Figure:
        """The dynamic power at a clock in Hz, W, by the law."""
        return self._power(round(clock))[1]


def design_point(
    platform: Platform, workload: Workload, settings: Mapping[str, Any], name: str, task: str | None = None
) -> DesignPoint:
    """The design point of a platform and a workload with settings of axes.

    ``task``: that is placed by itself, "" for the planning task; by default the first one that is on an FPGA.

    Raises:
        SpecError: they do not belong together. InputError: no task, or not this one, is on an FPGA.
    """
    system = bind(*point_of(platform, workload, settings))
    for on_task, _, place in on_fpgas(system):
        component = system.platform.of(FpgaComponent).get(place)
        if task in (None, on_task) and component is not None:
            return DesignPoint(name, system, component, on_task)
    what = f"{system.planner.planning_task} runs on {system.component}, which is no FPGA"
    if task:
        what = f"task {task} is not placed by itself on an FPGA"
    raise InputError(what, None, "name a design on an FPGA")


def find_manifest(report: Path) -> Path | None:
    """The manifest of ``hwsw rtl`` in the folder of a report, or in one of the folders above it."""
    folder = report.absolute().parent
    for place in (folder, *list(folder.parents)[:FOLDERS_UP]):
        if (place / MANIFEST).is_file():
            return place / MANIFEST
    return None


def read_manifest(path: Path) -> dict[str, Any]:
    """A manifest of ``hwsw rtl``: what was exported.

    Raises:
        SpecError: it cannot be read, or lacks a key.
    """

    def fault(what: str, line: int = 0) -> SpecError:
        return SpecError([Fault(str(path), line, 1 if line else 0, "", what, "export the design again: hwsw rtl")])

    try:
        with path.open("rb") as stream:
            content = stream.read(MOST_MANIFEST + 1)
        tree = json.loads(content)
    except json.JSONDecodeError as error:
        raise fault("is no JSON", error.lineno) from None
    except (OSError, ValueError, RecursionError) as error:
        raise fault(f"cannot be read: {error}") from None
    if len(content) > MOST_MANIFEST or not isinstance(tree, dict):
        raise fault("is no manifest of a design")
    for key in ("top", "platform", "workload", "task"):
        if not isinstance(tree.get(key), str):
            raise fault(f"has no text {key}")
    if not isinstance(tree.get("settings"), dict):
        raise fault("has no settings")
    return tree


def exported_point(path: Path) -> DesignPoint:
    """The design point of a manifest.

    Raises:
        SpecError: the manifest, or its platform or workload, is faulty, or these have changed.
        InputError: it is of a study, or its specs are not there any more.
    """
    manifest = read_manifest(path)
    if manifest.get("study") is not None:
        what = f"the design is a point of study {clip(str(manifest['study']), 60)}"
        raise InputError(what, str(path), "name PLATFORM WORKLOAD and its settings before --report")
    platform, workload = load_platform(manifest["platform"]), catalog.load_workload(manifest["workload"])
    point = design_point(platform, workload, manifest["settings"], manifest["top"], manifest["task"])
    if point.top is not None and point.top != manifest["top"]:
        what = f"the design point now makes {point.top}, and the manifest has {clip(manifest['top'], 40)}"
        hint = "platform, workload or Verilog have changed since: export the design again with hwsw rtl"
        raise InputError(what, str(path), hint)
    return point


def check_design(report: Report, point: DesignPoint, expected: str | None) -> str | None:
    """A note where nothing proves that a report is of a design point; None where its name does.

    ``expected``: the top module of the design. A manifest names the point so, too.

    Raises:
        InputError: the report is of another design, or of another part.
    """
    if report.part and not names_part(report.part, point.part):
        what = f"is of part {clip(report.part, 40)}, and the design point is on {point.part.full_name}"
        raise InputError(what, report.file, "name the report of this part, or set the part with --set")
    if not point.part.family.startswith(report.family):
        what = f"is of family {report.family}, and {point.part.full_name} is a {point.part.family}"
        raise InputError(what, report.file, "name the report of this part, or set the part with --set")
    if expected is not None and report.top.startswith(PREFIX) and report.top != expected:
        what = f"is of design {clip(report.top, 40)}, and the design point makes {expected}"
        raise InputError(what, report.file, "name the report of this design, or its own PLATFORM WORKLOAD")
    by_manifest = expected == point.name and not report.top
    if by_manifest or (report.top and report.top == expected):
        return None
    named = f"its top {clip(report.top, 40)} has no digest" if report.top else f"{report.tool} names no top in it"
    return f"{report.file}: {named}; it is taken for {point.name}"


def names_part(written: str, part: Part) -> bool:
    """True if a part as a tool writes it, such as ``7a200tffv1156-2``, is a part in its speed grade.

    A report without a speed grade is of any. Gowin writes ``C8/I7`` for its grade.
    """
    plain = "".join(mark for mark in written.upper() if mark.isalnum() or mark == "-")
    for voltage in ("-LV", "-UV", "-EV"):
        plain = plain.replace(voltage, "-")
    name, grade = part.name.upper().replace("-", ""), part.speed_grade.upper()
    head, dash, last = plain.rpartition("-")
    is_grade = bool(dash) and head != "" and len(last) <= 3 and last[:1].isdigit()
    device = (head if is_grade else plain).replace("-", "")
    if not any((prefix + device).startswith(name) for prefix in ("", "XC")):
        return False
    return not is_grade or part.family.startswith("GW") or f"-{last.rstrip('LE')}" == grade.rstrip("LE")
