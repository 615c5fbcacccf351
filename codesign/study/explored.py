"""The subject of an exploration: a workload, and the platform or platforms that its points are on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from codesign.ground.errors import Fault, InputError, SpecError, UnsuitedError
from codesign.inputs import Exploration, Platform, Workload, cross_check, design_point
from codesign.inputs.checks import platforms_of
from codesign.inputs.document import REMOVED, KeyPath, Origin, put
from codesign.inputs.edit import PLATFORM_AXIS, PROBLEM, Movable, moves
from codesign.inputs.roles import ROLES


@dataclass(frozen=True)
class Explored:
    """The specs that the points of an exploration are made of.

    - ``workload``: with the section ``explore``; its document has the same axes.
    - ``platforms``: by value of the axis ``platform``; without that axis the only one, under an empty name.
    """

    workload: Workload
    platforms: Mapping[str, Platform]

    @classmethod
    def of(cls, platform: Platform | Sequence[Platform] | None, workload: Workload) -> Explored:
        """The subject of an exploration.

        Args:
            platform: one platform, which settles the axis ``platform``; several, which become the values of the axis,
                by name; or None, if the workload has that axis.
            workload: with a section ``explore``, unless there are several platforms.

        Raises:
            InputError: there is nothing to explore, no platform, or two of one name. SpecError: faults of the axis.
        """
        section = workload.explore
        if isinstance(platform, Sequence):
            section = _over(platform, section)
            platforms = {each.name: each for each in platform}
        elif section is None:
            what = f"workload {workload.name} has nothing to explore"
            raise InputError(what, hint="give it a section explore: with axes:")
        elif platform is None:
            platforms = platforms_of(workload)
            if not platforms:
                hint = "name one, or give the workload an axis platform: under explore.axes"
                raise InputError(f"workload {workload.name} is explored on no platform", hint=hint)
        else:
            platforms = {"": platform}
            section = _on(platform, section)
        return cls(_with_section(workload, section), platforms)

    @property
    def section(self) -> Exploration:
        """The section ``explore`` of the workload."""
        assert self.workload.explore is not None, "set by Explored.of"
        return self.workload.explore

    @property
    def single(self) -> Platform | None:
        """The platform of all points; None where there is an axis over platforms."""
        return self.platforms.get("")

    def platform(self, axes: Mapping[str, Any]) -> Platform:
        """The platform of a point."""
        return self.platforms[axes.get(PLATFORM_AXIS, "")]

    def point(self, axes: Mapping[str, Any]) -> tuple[Platform, Workload]:
        """Platform and workload of a point.

        Over several platforms, an axis of a role that the point's platform does not fill moves nothing: a design that
        needs no fabric has no clock of a fabric.

        Raises:
            SpecError: see ``design_point``; over several platforms, ``UnsuitedError``.
        """
        platform = self.platform(axes)
        if self.single is not None:
            return design_point(platform, self.workload, axes)
        unmoved = {PLATFORM_AXIS, *self._unfilled(platform)}
        values = {axis: value for axis, value in axes.items() if axis not in unmoved}
        try:
            return design_point(platform, self.workload, values)
        except SpecError as wrong:
            raise UnsuitedError(wrong.faults) from wrong

    @cached_property
    def named_files(self) -> Mapping[str, Sequence[tuple[Any, tuple[Path, ...]]]]:
        """The map and ``.scen`` files that each value of an axis names, by axis; of values that name one."""
        axes = self.workload.explore.every_axis if self.workload.explore else {}
        named = {axis: self._files_named(axis, values) for axis, values in axes.items() if moves(axis, PROBLEM)}
        return {axis: files for axis, files in named.items() if files}

    def _files_named(self, axis: str, values: Iterable[Any]) -> list[tuple[Any, tuple[Path, ...]]]:
        document, path = self.workload.document, tuple(axis.split(".")[1:])
        problems = [(value, put(document, {path: value}, lambda _: Origin(())).tree["problem"]) for value in values]
        texts = [(value, _texts_of_files(problem)) for value, problem in problems]
        return [(value, tuple(document.folder / text for text in own)) for value, own in texts if own]

    def check_axes(self) -> None:
        """Check the axes; each fault is reported at its place in the file.

        Over several platforms, a key or value is at fault where none of those that fill the roles of the axes takes it.
        Where some take it, its points on the others are infeasible.

        Raises:
            SpecError: every fault.
        """
        filling = [platform for platform in self.platforms.values() if not self._unfilled(platform)]
        faults_by_platform = [self._faults(platform) for platform in filling or self.platforms.values()]
        everywhere = set.intersection(*(set(map(_place, faults)) for faults in faults_by_platform))
        faults = [fault for faults in faults_by_platform for fault in faults if _place(fault) in everywhere]
        if faults:
            raise SpecError(dict.fromkeys(faults))

    def _unfilled(self, platform: Platform) -> set[str]:
        """The axes of roles that a platform does not fill."""
        movable = Movable.of(platform, self.workload.document)
        heads = {axis: axis.partition(".")[0] for axis in self.section.every_axis}
        return {axis for axis, head in heads.items() if head in ROLES and movable.section(head) is None}

    def _faults(self, platform: Platform) -> list[Fault]:
        try:
            cross_check(platform, self.workload, explored=True)
        except SpecError as wrong:
            return list(wrong.faults)
        return []


def _texts_of_files(problem: Any) -> tuple[str, ...]:
    """The files that a raw problem names, as it names them."""
    sections = problem if isinstance(problem, dict) else {}
    named = [(sections.get(section), key) for section, key in _FILES_OF_A_PROBLEM]
    texts = [section.get(key) for section, key in named if isinstance(section, dict)]
    return tuple(text for text in texts if isinstance(text, str))


_FILES_OF_A_PROBLEM = (("map", "file"), ("goals", "scen"), ("starts", "scen"))


def _place(fault: Fault) -> tuple[str, int, int, str]:
    return fault.file, fault.line, fault.column, fault.key


def _over(platforms: Sequence[Platform], section: Exploration | None) -> Exploration:
    """The section with an axis over these platforms: in the place of the one that it has, or else the first."""
    names = tuple(platform.name for platform in platforms)
    twice = [name for index, name in enumerate(names) if name in names[:index]]
    if twice or not names:
        what = f"two platforms have the name {twice[0]}" if twice else "no platform to explore"
        raise InputError(what, "platform", "give each file a name: of its own" if twice else "name at least one")
    section = section or Exploration()
    return section.model_copy(update={"axes": {PLATFORM_AXIS: names} | section.axes | {PLATFORM_AXIS: names}})


def _on(platform: Platform, section: Exploration) -> Exploration:
    """The section with its axis ``platform`` settled: axes that exist for others only are left out."""
    values = section.axes.get(PLATFORM_AXIS, ())
    value = next((value for value in values if value == platform.name), platform.name)
    return section.settled({PLATFORM_AXIS: value})


def _with_section(workload: Workload, section: Exploration) -> Workload:
    """The workload with this exploration in its document too: if none is written, faults are faults of the file.

    Without its search: no point depends on it.
    """
    section = section.model_copy(update={"search": None})
    document = workload.document
    written = document.tree.get("explore") or {}
    for key, axes in (("axes", section.axes), ("conditions", section.conditions)):
        raw = {name: list(values) for name, values in axes.items()}
        if written.get(key, {}) != raw:
            document = put(document, {("explore", key): raw}, lambda path: Origin(path, workload.document))
    if (written.get("when") or {}) != section.when_as_written:
        edits: dict[KeyPath, Any] = {("explore", "when"): section.when_as_written}
        document = put(document, edits, lambda path: Origin(path, workload.document))
    if "search" in written:
        removal: dict[KeyPath, Any] = {("explore", "search"): REMOVED}
        document = put(document, removal, lambda path: Origin(path, workload.document))
    return workload.model_copy(update={"explore": section}).with_document(document, workload)
