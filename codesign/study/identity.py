"""The digest of all that a result depends on besides the axis values.

A finished point is taken from a store only where computing it again would give the same result: the same
platform and parts, the same workload and map, the same code and the same measured rows. So every file that
ships is part of it by its content. A version number may be raised too late.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache, lru_cache
from importlib.machinery import BYTECODE_SUFFIXES
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codesign.inputs.files import data_folder
from codesign.planners.registered import registered
from codesign.study.space import canonical

if TYPE_CHECKING:
    from codesign.inputs import Platform, Workload
    from codesign.maps import OccupancyGrid
    from codesign.study.explored import Explored

_NO_PART_IN_RESULTS = frozenset({"calibrate", "certificates", "cli", "paper", "report", "reproduce", "trace"})
_PACKAGE = Path(__file__).resolve().parent.parent
_DATA = ("platforms", "workloads")
_DATA_IN_RESULTS = tuple(f"platforms/{name}/" for name in ("parts", "hosts"))
"""The other data are what a user may name: platforms, workloads and maps count by themselves."""

_OF_RESULTS = frozenset(
    f"{name}.py"
    for name in (
        *("__init__", "evaluation", "explored", "identity", "order", "partition", "simulator", "space", "store"),
        *("blocks", "definition", "shared"),
        *("aggregation", "bounds", "conditions", "constraints", "front"),
        *("search", "search_bound"),
    )
)
"""Of the modules of explorations, those that a result, a block or a box in a store comes from.

They say what a point is and which are priced together; how a block is written; and which boxes a bound excludes. They
are all that ``evaluation``, ``blocks`` and ``search_bound`` import. All others judge, order or show what was kept.
"""


def identity_of(platform: Platform | None, workload: Workload, grid: OccupancyGrid | None) -> dict[str, str]:
    """Digests of platform, parts, workload without its variants and its ``explore`` section, map, files, and code.

    ``platform``: None where an axis chooses it. ``grid``: the map; None of a problem without one, which stands in the
    workload.
    """
    cells: list[Any] = []
    if grid is not None:
        digest = hashlib.sha256(grid.free.tobytes()).hexdigest()
        cells = [grid.free.shape, digest, grid.resolution, grid.origin]
    return {
        "platform": "" if platform is None else platform_digest(platform),
        "workload": workload.digest(),
        "map": canonical_digest(cells),
        "files": _digest_of_files(file for file in workload.files if file != workload.map_file),
        "code": code_digest(),
    }


def fingerprint(platform: Platform | None, workload: Workload, grid: OccupancyGrid | None = None) -> str:
    """SHA-256 over ``identity_of``; the map is read where ``grid`` is not given.

    Raises:
        MapError: the map cannot be read or made.
    """
    from codesign.system.problem_map import grid_of

    return canonical_digest(identity_of(platform, workload, grid_of(workload) if grid is None else grid))


def canonical_digest(value: Any) -> str:
    """SHA-256, hex, over the canonical JSON of a value."""
    return hashlib.sha256(canonical(value).encode()).hexdigest()


def platform_digest(platform: Platform) -> str:
    """SHA-256 over a platform, and over all parts, hosts and calibrations that it may have."""
    from codesign.inputs.library import HOSTS, PARTS, all_digests

    folder = platform.document.folder
    paths = [*PARTS.names((folder / "parts",)).values(), *HOSTS.names((folder / "hosts",)).values()]
    calibrations = all_digests(folder)
    library = _library_digest(folder, tuple(map(_status, paths)))
    return canonical_digest([platform.digest(), library, *([calibrations] if calibrations else [])])


@lru_cache(maxsize=64)
def _library_digest(folder: Path, _statuses: tuple[_Status, ...]) -> str:
    from codesign.inputs import list_parts, load_part
    from codesign.inputs.library import HOSTS

    folders, hosts = (folder / "parts",), HOSTS.names((folder / "hosts",))
    parts = [load_part(name, folders).model_dump(mode="json") for name in list_parts(folders)]
    return canonical_digest([parts, {name: HOSTS.load(path).digest() for name, path in hosts.items()}])


def contents_of(explored: Explored) -> dict[str, dict[str, str]]:
    """The meaning of the values of axes: platforms, variants but ``base``, which is the workload, and maps in files."""
    from codesign.inputs.edit import PLATFORM_AXIS, VARIANT_AXIS, choose_variant
    from codesign.inputs.workload import BASE

    workload, axes = explored.workload, explored.section.axes
    contents = {
        axis: {canonical(value): _digest_of_files(files) for value, files in values}
        for axis, values in _map_files(explored).items()
    }
    contents[PLATFORM_AXIS] = {
        canonical(value): platform_digest(platform) for value, platform in explored.platforms.items() if value
    }
    contents[VARIANT_AXIS] = {
        canonical(name): choose_variant(workload, name, "").digest()
        for name in axes.get(VARIANT_AXIS, ())
        if isinstance(name, str) and name != BASE and name in workload.variants
    }
    return {axis: digests for axis, digests in contents.items() if digests}


def files_read(explored: Explored) -> dict[Path, str]:
    """The files that points are made of beside the specs, by what they hold now.

    They are parts, hosts, calibrations, and maps of axes. Shipped platforms do not change (``code_digest``).
    """
    from codesign.inputs.library import FOLDERS, calibration_folders

    shipped = data_folder("platforms")
    places = dict.fromkeys(platform.document.folder for platform in explored.platforms.values())
    folders = dict.fromkeys(place / name for place in places for name in FOLDERS)
    folders |= dict.fromkeys(folder for place in places for folder in calibration_folders(place))
    files = [path for folder in folders if shipped not in folder.parents for path in _listed(folder)]
    for values in _map_files(explored).values():
        files += [file for _, read in values for file in read]
    return digests_of(files)


def digests_of(files: Iterable[Path]) -> dict[Path, str]:
    """SHA-256 over what each file holds; one that cannot be read counts as empty."""
    statuses = {file: _status(file) for file in files}
    # Asked after each work, and hardly ever anything has changed.
    if statuses != _last.statuses:
        digests = {file: _digest_at(file, status) for file, status in statuses.items()}
        _last.statuses, _last.digests = statuses, digests
    return _last.digests


def _listed(folder: Path) -> tuple[Path, ...]:
    """The YAML files of a folder by name; none where it cannot be read. Asked after each work, so at little cost."""
    try:
        names = os.listdir(folder)
    except OSError:
        return ()
    return _paths(folder, tuple(sorted(name for name in names if name.endswith(".yaml"))))


@lru_cache(maxsize=64)
def _paths(folder: Path, names: tuple[str, ...]) -> tuple[Path, ...]:
    return tuple(folder / name for name in names)


_Status = tuple[int, int, int, int, int] | None
"""The facts that tell that a file was changed; None of one that cannot be read."""


@dataclass
class _Last:
    """The files that digests were asked of last: their statuses, and the digests."""

    statuses: dict[Path, _Status] = field(default_factory=dict)
    digests: dict[Path, str] = field(default_factory=dict)


_last = _Last()


def _status(file: Path) -> _Status:
    try:
        status = os.stat(file)
    except OSError:
        return None
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns


@lru_cache(maxsize=4096)
def _digest_at(file: Path, _status: _Status) -> str:
    return _digest_of_files((file,))


def _map_files(explored: Explored) -> dict[str, list[tuple[Any, tuple[Path, ...]]]]:
    """The files that each value of an axis brings, by axis: those that it names, and the images of their YAML."""
    from codesign.maps import map_files

    return {
        axis: [(value, tuple(file for path in named for file in map_files(path))) for value, named in values]
        for axis, values in explored.named_files.items()
    }


def _digest_of_files(files: Iterable[Path]) -> str:
    """SHA-256 over the contents of files; one that cannot be read counts as empty."""
    digest = hashlib.sha256()
    for path in files:
        try:
            content = path.read_bytes()
        except OSError:
            content = b""
        digest.update(f"{path.name} {len(content)}\n".encode() + content)
    return digest.hexdigest()


@cache
def code_digest() -> str:
    """SHA-256 over the shipped files that a result depends on, and over the installed plug-ins.

    The files are sources, measured rows that laws are fitted to, circuits, parts and hosts. A plug-in counts by its
    name, value and version, and by the files of its package: one that is worked on, as after ``pip install -e``,
    changes without a new version.
    """
    digest = hashlib.sha256()
    for name, path in _shipped():
        if not _has_no_part(name):
            digest.update(f"{name} {_digest_at(path, _status(path))}\n".encode())
    hashed = {"codesign"}
    for point in registered():
        release = f"{point.dist.name} {point.dist.version}" if point.dist is not None else ""
        digest.update(f"{point.name} {point.value} {release}\n".encode())
        package, places = _package_of(point.module)
        if package in hashed:
            continue
        hashed.add(package)
        for place in places:
            for name, path in _files_of(place):
                digest.update(f"{package} {name} {_digest_at(path, _status(path))}\n".encode())
    return digest.hexdigest()


@cache
def package_digest() -> str:
    """SHA-256 over all shipped files, those with no part in results too, and over the installed plug-ins.

    Two processes with the same digest understand each other's works and outcomes.
    """
    digest = hashlib.sha256(code_digest().encode())
    for name, path in _shipped():
        digest.update(f"{name} {_digest_at(path, _status(path))}\n".encode())
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


def _has_no_part(name: str) -> bool:
    """True if no result depends on a shipped file, by its name as of ``_shipped``."""
    *folders, file = name.split("/")
    if folders and folders[0] in _DATA:
        return not name.startswith(_DATA_IN_RESULTS)
    return not _NO_PART_IN_RESULTS.isdisjoint((*folders, file)) or (folders == ["study"] and file not in _OF_RESULTS)


def _shipped() -> Iterator[tuple[str, Path]]:
    """The name and the path of each file that ships: the package, then the data, which may lie inside it."""
    for name, path in _files_of(_PACKAGE):
        if name.partition("/")[0] not in _DATA:
            yield name, path
    for folder in _DATA:
        yield from ((f"{folder}/{name}", path) for name, path in _files_of(data_folder(folder)))


def _files_of(place: Path) -> list[tuple[str, Path]]:
    """The files of a package's folder by name, or a module; without hidden ones, and without what Python compiles."""
    if not place.is_dir():
        return [(place.name, place)]
    found = []
    for folder, inner, names in os.walk(place):
        inner[:] = [name for name in inner if name != "__pycache__" and not name.startswith(".")]
        for name in names:
            if not name.startswith(".") and not name.endswith(tuple(BYTECODE_SUFFIXES)):
                path = Path(folder, name)
                found.append((path.relative_to(place).as_posix(), path))
    return sorted(found)
