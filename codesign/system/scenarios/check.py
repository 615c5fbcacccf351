"""The check of files, each by itself and each platform with each workload."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from codesign import inputs as spec
from codesign.ground.errors import CodesignError, Fault, InputError, SpecError
from codesign.inputs import Platform, Workload
from codesign.inputs.edit import VARIANT_AXIS, choose_variant
from codesign.system.assemble import platform_faults
from codesign.system.bind import plannable
from codesign.system.inspect import load_any
from codesign.system.problem_map import map_notes
from codesign.system.ready import ready
from codesign.system.scenarios.run import bind, scenario_of


def check_files(
    sources: Sequence[str | Path],
    settings: Mapping[str, Any] | None = None,
    memory: int | None = None,
    tell: Callable[[str], None] | None = None,
) -> list[Fault]:
    """Every fault of the named files, and of each platform with each workload among them, in file order.

    A source is a shipped name or a path; its content gives its kind. A platform and a workload are bound and
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
            loaded = load_any(source)
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
    checks = [_faults_of_pair(platform, workload, settings or {}, memory, notes) for workload, platform in pairs]
    if not pairs:
        checks += [iter(platform_faults(platform)) for platform in platforms]
        checks += [_faults_of_workload(workload, notes) for workload in workloads]
    for fault in itertools.chain.from_iterable(checks):
        faults += [fault] if fault not in faults else []
    if tell is not None:
        for note in notes:
            tell(note)
    return faults


def _faults_of_pair(
    platform: Platform, workload: Workload, settings: Mapping[str, Any], memory: int | None, notes: dict[str, None]
) -> Iterator[Fault]:
    """Each fault that keeps the workload, or a variant of it, from being simulated on the platform.

    ``notes`` gets the notes of the points without a fault as keys.
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


def _faults_of_workload(workload: Workload, notes: dict[str, None]) -> Iterator[Fault]:
    """The faults of a workload and its variants that are known without a platform. ``notes``: as above, of its map."""
    try:
        spec.platforms_of(workload)
    except SpecError as wrong:
        yield from wrong.faults
    for each in (workload, *(choose_variant(workload, name, "") for name in workload.variants)):
        problem, faults = plannable(each, scenario_of(each))
        yield from faults
        if problem is not None:
            notes |= dict.fromkeys(map_notes(each, None))


def _points_checked(workload: Workload, settings: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The points of a workload to be checked: the settings, with each variant unless they choose one."""
    if VARIANT_AXIS in settings:
        return [dict(settings)]
    return [dict(settings), *({**settings, VARIANT_AXIS: name} for name in workload.variants)]
