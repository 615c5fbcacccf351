"""What is at hand, whether files are sound, and the schemas of what goes in and comes out."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from codesign import inputs as spec
from codesign.errors import CodesignError, Fault, InputError, SpecError, choose_hint
from codesign.figures import label
from codesign.inputs import Platform, Spec, Workload
from codesign.inputs.edit import VARIANT_AXIS, choose_variant
from codesign.inputs.files import is_path
from codesign.inputs.part_file import load_part_file
from codesign.inputs.yaml_tree import read_document
from codesign.part import Part
from codesign.results.result import Result
from codesign.system import catalog
from codesign.system.bind import bind, plannable
from codesign.system.ready import ready
from codesign.system.refusals import platform_faults


def check_files(
    sources: Sequence[str | Path],
    settings: Mapping[str, Any] | None = None,
    memory: int | None = None,
    tell: Callable[[str], None] | None = None,
) -> list[Fault]:
    """Every fault of the named files, and of each platform with each workload among them, in file order.

    A source is a shipped name or a path; its kind is told from what it is. A platform and a workload are bound and
    built as ``simulate`` does it, so that both refuse the same; ``memory`` as there. Each variant of a workload is
    checked too, unless ``settings``, raw values by axis that are put into both, choose one. Files of one kind are
    checked as far as that is possible without the other kind. ``tell`` takes each note (``Architecture.notes``) of
    designs without a fault.

    Raises:
        InputError: settings, and no platform and workload to put them into.
    """
    faults: list[Fault] = []
    platforms: list[Platform] = []
    workloads: list[Workload] = []
    for source in sources:
        try:
            loaded = _load(source)
        except SpecError as wrong:
            faults += wrong.faults
        except CodesignError as wrong:
            faults.append(Fault(str(source), 0, 0, "", wrong.what, wrong.hint))
        else:
            if isinstance(loaded, Platform):
                platforms.append(loaded)
            elif isinstance(loaded, Workload):
                workloads.append(loaded)
    if settings and not faults and not (platforms and workloads):
        raise InputError("settings go into a platform and a workload", "--set", "name one of each")
    pairs = list(itertools.product(workloads, platforms))
    notes: dict[str, None] = {}
    found = [
        _faults_of_pair(platform, workload, settings or {}, memory, notes) for workload, platform in pairs
    ]
    if not pairs:
        found += [iter(platform_faults(platform)) for platform in platforms]
        found += [_faults_of_workload(workload) for workload in workloads]
    for fault in itertools.chain.from_iterable(found):
        faults += [fault] if fault not in faults else []
    if tell is not None:
        for note in notes:
            tell(note)
    return faults


def _faults_of_pair(
    platform: Platform,
    workload: Workload,
    settings: Mapping[str, Any],
    memory: int | None,
    notes: dict[str, None],
) -> Iterator[Fault]:
    """Whatever keeps the workload, or a variant of it, from being simulated on the platform.

    ``notes`` gets as keys what there is to say of the points that nothing keeps from it.
    """
    for point in _points_checked(workload, settings):
        # The axes are those of the variants explored: they are held against the first point alone.
        put_in = spec.pin if point == settings else spec.design_point
        try:
            system = bind(*put_in(platform, workload, point, "--set ") if point else (platform, workload))
            ready(system, memory=memory)
        except SpecError as wrong:
            yield from wrong.faults
        else:
            notes |= dict.fromkeys(system.notes)


def _faults_of_workload(workload: Workload) -> Iterator[Fault]:
    """What can be told of a workload and its variants without a platform."""
    yield from plannable(workload)[1]
    for name in workload.variants:
        yield from plannable(choose_variant(workload, name, ""))[1]


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
    return spec.design_point(platform, workload, settings, "--set ") if settings else (platform, workload)


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
    planners = {name: planner.description for name, planner in catalog.planners().items()}
    styles = {
        f"{planner}.{style}": f"on {found.component_type}: {found.description}"
        for (planner, style), found in catalog.architectures().items()
    }
    found = {
        "platforms": platforms,
        "workloads": workloads,
        "parts": parts,
        "planners": planners,
        "styles": styles,
    }
    broken = {f"{plug_in.name} ({plug_in.value})": plug_in.why for plug_in in catalog.broken()}
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
