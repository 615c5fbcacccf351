"""What is at hand, whether files are sound, and the schemas of what goes in and comes out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from codesign import spec
from codesign.errors import CodesignError, Fault, InputError, SpecError, choose_hint
from codesign.figures import label
from codesign.spec import Part, Platform, Spec, Workload
from codesign.spec.locate import is_path
from codesign.spec.marks import read_document
from codesign.spec.part import load_part_file
from codesign.spec.variants import VARIANT_AXIS
from codesign.system import catalog
from codesign.system.bind import System, bind
from codesign.system.memory import refusal
from codesign.system.result import Result


def check_files(
    sources: Sequence[str | Path], settings: Mapping[str, Any] | None = None, memory: int | None = None
) -> list[Fault]:
    """Every fault of the named files, and of each platform with each workload among them, in file order.

    A source is a shipped name or a path; its kind is told from what it is. Each variant of a workload is checked with
    the platform, unless ``settings``, raw values by axis that are put into both, choose one. A run that would take more
    than ``memory`` bytes, by default half of what the machine has free, is a fault too.

    Raises:
        InputError: settings, and no platform and workload to put them into.
    """
    faults: list[Fault] = []
    platforms: list[Platform] = []
    workloads: list[Workload] = []
    for source in sources:
        try:
            found = _load(source)
        except SpecError as wrong:
            faults += wrong.faults
        except CodesignError as wrong:
            faults.append(Fault(str(source), 0, 0, "", wrong.what, wrong.hint))
        else:
            if isinstance(found, Platform):
                platforms.append(found)
            elif isinstance(found, Workload):
                workloads.append(found)
    if settings and not faults and not (platforms and workloads):
        raise InputError("settings go into a platform and a workload", "--set", "name one of each")
    for workload in workloads:
        for platform in platforms:
            for point in _points_checked(workload, settings or {}):
                # The axes are those of the variants explored: they are held against the first point alone.
                put_in = spec.pin if point == (settings or {}) else spec.override
                try:
                    put = put_in(platform, workload, point, "--set ") if point else (platform, workload)
                    wrongs = _memory_faults(bind(*put), memory)
                except SpecError as wrong:
                    wrongs = wrong.faults
                faults += [fault for fault in wrongs if fault not in faults]
    return faults


def _memory_faults(system: System, memory: int | None) -> tuple[Fault, ...]:
    refused = refusal(system, memory)
    path = ("mapping", system.planner.planning_task)
    return () if refused is None else (spec.fault(system.workload, path, *refused),)


def _points_checked(workload: Workload, settings: Mapping[str, Any]) -> list[dict[str, Any]]:
    """What is put into a workload to be checked: the settings, with each variant unless they choose one."""
    if VARIANT_AXIS in settings:
        return [dict(settings)]
    return [dict(settings), *({**settings, VARIANT_AXIS: name} for name in workload.variants)]


def point_of(
    platform: Platform, workload: Workload, settings: Mapping[str, Any]
) -> tuple[Platform, Workload]:
    """Platform and workload with a raw value put in the place of each named axis.

    Raises:
        SpecError: an axis that is none, or a value that is not accepted.
    """
    return spec.override(platform, workload, settings, "--set ") if settings else (platform, workload)


def schema_of(kind: str) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a ``platform``, ``workload`` or ``part`` file, or of a ``result``.

    Raises:
        InputError: another kind.
    """
    if kind == "result":
        return {
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            **Result.model_json_schema(mode="serialization"),
        }
    if kind not in ("platform", "workload", "part"):
        raise InputError(
            f"there is no schema of {kind!r}",
            hint=choose_hint(kind, ["platform", "workload", "part", "result"]),
        )
    return spec.json_schema(kind, catalog.task_models(), catalog.problem_models())


def at_hand() -> dict[str, dict[str, str]]:
    """Names and one-line descriptions of what ships or is installed, by kind."""
    platforms = {name: spec.load_platform(name).description for name in spec.list_platforms()}
    workloads = {name: catalog.load_workload(name).description for name in spec.list_workloads()}
    parts = {name: _budgets(spec.load_part(name)) for name in spec.list_parts()}
    planners = {name: _described(planner) for name, planner in catalog.planners().items()}
    styles = {
        f"{planner}.{style}": f"on {found.component_type}: {_described(found)}"
        for (planner, style), found in catalog.architectures().items()
    }
    found = {
        "platforms": platforms,
        "workloads": workloads,
        "parts": parts,
        "planners": planners,
        "styles": styles,
    }
    broken = {
        f"{plug_in.name} ({plug_in.group})": f"{plug_in.value}: {plug_in.why}" for plug_in in catalog.broken()
    }
    return {**found, "broken plug-ins": broken} if broken else found


def _load(source: str | Path) -> Spec | Part:
    """The spec of a source, whose kind is not known yet."""
    if not is_path(source):
        known = [*spec.list_platforms(), *spec.list_workloads(), *spec.list_parts()]
        if source in spec.list_platforms():
            return spec.load_platform(source)
        if source in spec.list_workloads():
            return catalog.load_workload(source)
        if source in spec.list_parts():
            return spec.load_part(str(source))
        raise InputError(f"there is no shipped spec {source!r}", hint=choose_hint(str(source), known))
    tree = read_document(Path(source), str(source)).tree
    kind = tree.get("kind") if isinstance(tree, dict) else None
    if kind == "platform":
        return spec.load_platform(source)
    if kind == "part":
        return load_part_file(Path(source))
    return catalog.load_workload(source)


def _budgets(part: Part) -> str:
    budgets = (f"{int(figure.value):,} {label(name)}" for name, figure in part.resources.items())
    return f"{part.family}: {', '.join(budgets)}"


def _described(plug_in: object) -> str:
    """Its description; of a plug-in that was written before there was one, the first line of its docstring."""
    first_line = (type(plug_in).__doc__ or "").strip().split("\n")[0]
    return str(getattr(plug_in, "description", first_line))
