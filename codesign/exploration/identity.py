"""What a result depends on besides the axis values, as one digest.

A finished point is taken from a store only where computing it again would give the same result: the same
platform and parts, the same workload and map, the same code. So the code is part of it, by its sources
rather than by a version number, which may be raised too late.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterable
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES, SOURCE_SUFFIXES
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from codesign.exploration.space import canonical

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

    from codesign.inputs import Platform, Workload
    from codesign.maps import OccupancyGrid

_IMPORTED = (*SOURCE_SUFFIXES, *EXTENSION_SUFFIXES)
_NO_PART_IN_RESULTS = frozenset(
    {"calibrate", "cli", "exploration", "paper", "report", "reproduce", "trace", "__pycache__"}
)


def fingerprint(platform: Platform, workload: Workload, grid: OccupancyGrid | None = None) -> str:
    """SHA-256 over platform, parts, workload without its variants and its ``explore`` section, map, files, and code.

    ``grid``: the map, where it was read already; by default it is read. A problem without a map stands in the workload.

    Raises:
        MapError: the map cannot be read or made.
    """
    from codesign.inputs import list_parts, load_part
    from codesign.system.problem_map import grid_of

    folders = (platform.document.folder / "parts",)
    parts = [load_part(name, folders).model_dump(mode="json") for name in list_parts(folders)]
    grid = grid_of(workload) if grid is None else grid
    cells = "" if grid is None else hashlib.sha256(grid.free.tobytes()).hexdigest()
    identity = [
        platform.digest(),
        workload.digest(),
        parts,
        None if grid is None else grid.free.shape,
        cells,
        None if grid is None else (grid.resolution, grid.origin),
        files_digest(problem_files(platform, workload)),
        code_digest(),
    ]
    return hashlib.sha256(canonical(identity).encode()).hexdigest()


def problem_files(platform: Platform, workload: Workload) -> tuple[Path, ...]:
    """The files that points of an exploration read while it runs, by name.

    These are the maps that the values of an axis name, with the images of their YAML, and all ``.scen`` files. Where an
    axis moves the problem, the workload's own map is one of them: with other steps it is read again.
    """
    from codesign.inputs.edit import PROBLEM, design_point, moves
    from codesign.maps import map_files

    axes = workload.explore.axes if workload.explore else {}
    values = [(axis, value) for axis, listed in axes.items() if moves(axis, PROBLEM) for value in listed]
    points = [design_point(platform, workload, {axis: value})[1] for axis, value in values]
    named = {file for point in (workload, *points) for file in point.files}
    if not points:
        named.discard(workload.map_file or Path())
    return tuple(sorted({file for name in named for file in map_files(name)}))


def files_digest(files: Iterable[Path]) -> str:
    """SHA-256 over the content of files as they are on disk now."""
    digest = hashlib.sha256()
    for file in files:
        try:
            content = file.read_bytes()
        except OSError:
            content = b""
        digest.update(f"{file.name} {len(content)}\n".encode() + content)
    return digest.hexdigest()


def variant_digests(workload: Workload) -> dict[str, str]:
    """The digest of each variant that the workload's exploration chooses from, but of ``base``: the workload itself."""
    from codesign.inputs.edit import VARIANT_AXIS, choose_variant
    from codesign.inputs.workload import BASE

    names = workload.explore.axes.get(VARIANT_AXIS, ()) if workload.explore else ()
    return {
        name: choose_variant(workload, name, "").digest()
        for name in names
        if isinstance(name, str) and name != BASE and name in workload.variants
    }


def parts_digest(platform: Platform) -> str:
    """SHA-256 over the part files beside the platform, as they are on disk now: those of a package do not change."""
    return files_digest(sorted((platform.document.folder / "parts").glob("*.yaml")))


@cache
def code_digest() -> str:
    """SHA-256 over the sources of this package that a result depends on, and over the installed plug-ins.

    A plug-in counts by its name, value and version, and by the sources of its package: one that is worked on, as after
    ``pip install -e``, changes without a new version.
    """
    from codesign.system import catalog

    digest = hashlib.sha256()
    for name, text in _sources(files("codesign"), ""):
        digest.update(f"{name} {len(text)}\n".encode() + text)
    hashed = {"codesign"}
    for point in catalog.registered():
        release = f"{point.dist.name} {point.dist.version}" if point.dist is not None else ""
        digest.update(f"{point.name} {point.value} {release}\n".encode())
        package, places = _package_of(point.module)
        if package in hashed:
            continue
        hashed.add(package)
        for path in places:
            for name, content in _plug_in_sources(path):
                digest.update(f"{package} {name} {len(content)}\n".encode() + content)
    return digest.hexdigest()


def _package_of(module: str) -> tuple[str, tuple[Path, ...]]:
    """The outermost regular package (or module) around a plug-in's module, and where it lies; nothing is run for it.

    No places where it cannot be found: the catalog reports a plug-in that cannot be loaded.
    """
    parts = module.split(".")
    for count in range(1, len(parts) + 1):
        name = ".".join(parts[:count])
        try:
            module_spec = find_spec(name)
        except (ImportError, ValueError):
            break
        if module_spec is None:
            break
        if module_spec.origin is not None:
            folders = module_spec.submodule_search_locations
            return name, tuple(map(Path, folders if folders else [module_spec.origin]))
        # A namespace package: others may have put their packages into it.
    return module, ()


def _plug_in_sources(path: Path) -> list[tuple[str, bytes]]:
    """The name and content of each file that Python could import from a package's folder, or of one module."""
    files = sorted(path.rglob("*")) if path.is_dir() else [path]
    sources = []
    for file in files:
        if file.name.endswith(_IMPORTED):
            # A file removed meanwhile, or not to be read, cannot be imported either.
            with contextlib.suppress(OSError):
                sources.append((file.relative_to(path).as_posix(), file.read_bytes()))
    return sources


def _sources(folder: Traversable, prefix: str) -> list[tuple[str, bytes]]:
    sources = []
    for item in sorted(folder.iterdir(), key=lambda item: item.name):
        if item.name in _NO_PART_IN_RESULTS:
            continue
        if item.is_dir():
            sources.extend(_sources(item, f"{prefix}{item.name}/"))
        elif Path(item.name).suffix == ".py":
            sources.append((f"{prefix}{item.name}", item.read_bytes()))
    return sources
