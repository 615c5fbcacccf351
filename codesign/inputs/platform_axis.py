"""The axis ``platform`` of an exploration: names of shipped platforms, and files beside the workload."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from codesign.ground.errors import Fault, InputError, SpecError, show
from codesign.inputs.document import Document, KeyPath
from codesign.inputs.edit import PLATFORM_AXIS
from codesign.inputs.files import find_spec, is_path
from codesign.inputs.platform import Platform, load_platform
from codesign.inputs.workload import Workload

_PLACE: KeyPath = ("explore", "axes", PLATFORM_AXIS)


def platform_axis_faults(document: Document, values: Sequence[Any]) -> list[Fault]:
    """Values of the axis that name no shipped platform and no file. The files themselves are not read."""
    faults = []
    for index, value in enumerate(values):
        refusal = _refusal(value, document.folder)
        if refusal is not None:
            faults.append(document.fault((*_PLACE, index), *refusal))
    return faults


def _refusal(value: Any, folder: Path) -> tuple[str, str | None] | None:
    try:
        path, _ = find_spec(value, "platforms")
    except InputError as wrong:
        return wrong.what, wrong.hint
    if (folder / path).is_file():
        return None
    return f"there is no file {show(value)}", "the path is relative to this workload file"


def platforms_of(workload: Workload) -> dict[str, Platform]:
    """The platforms that the workload's exploration chooses from, by value of the axis; empty without that axis.

    Raises:
        SpecError: every fault of the files, at its place; or a value that names no platform.
    """
    values = workload.explore.axes.get(PLATFORM_AXIS, ()) if workload.explore else ()
    faults = platform_axis_faults(workload.document, values)
    if faults:
        raise SpecError(faults)
    folder = workload.document.folder
    sources = [folder / value if is_path(value) else value for value in values]
    return dict(zip(values, load_platforms(sources), strict=True))


def load_platforms(sources: Iterable[Any]) -> list[Platform]:
    """Several platforms, by name or file.

    Raises:
        InputError: a value that names no platform. SpecError: every fault of every file.
    """
    platforms, faults = [], list[Fault]()
    for source in sources:
        find_spec(source, "platforms")
        try:
            platforms.append(load_platform(source))
        except SpecError as wrong:
            faults += wrong.faults
    if faults:
        raise SpecError(faults)
    return platforms
