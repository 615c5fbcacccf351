"""The provenance of what is simulated or explored."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from codesign.inputs import Platform, Workload
from codesign.inputs.document import dotted, leaves
from codesign.inputs.edit import PROBLEM, moves
from codesign.system.problem_map import grid_of
from codesign.system.results.provenance import Provenance


def provenance_of(platforms: Iterable[Platform], workload: Workload) -> Provenance:
    """The digests of the specs and of the map, and the seeds of the workload that no axis moves.

    Raises:
        MapError: the map cannot be read or made.
    """
    platforms = tuple(platforms)
    axes = workload.explore.every_axis if workload.explore else {}
    grid = None if any(moves(axis, PROBLEM) for axis in axes) else grid_of(workload)
    return Provenance(
        platform_digests={platform.name: platform.digest() for platform in platforms},
        calibration_digests={
            f"{platform.name}.{component}": digest
            for platform in platforms
            for component, digest in platform.calibrations.items()
        },
        workload_digest=workload.digest(),
        map_digest=None if grid is None else grid.digest,
        seeds={
            path: seed
            for path, seed in _seeds(workload.model_dump(mode="json", exclude={"explore", "variants"}))
            if not any(moves(f"workload.{path}", axis) for axis in axes)
        },
    )


def _seeds(tree: dict[str, Any]) -> Iterator[tuple[str, int]]:
    for path, value in leaves(tree):
        if str(path[-1] if path else "").endswith("seed") and isinstance(value, int):
            yield dotted(path), value
