"""The page on benchmarks covers each of them, and what the relaxation is timed against is the relaxation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from places import ROOT

from codesign.planners.harmonic.plan import Field, relax

REPOSITORY = ROOT


@pytest.mark.parametrize("path", sorted((REPOSITORY / "benchmarks").glob("bench_*.py")), ids=lambda path: path.stem)
def test_every_benchmark_has_its_section(path: Path) -> None:
    page = (REPOSITORY / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    assert f"\n`python -m benchmarks {path.stem.removeprefix('bench_')}` " in page


@pytest.mark.slow
def test_kernels_of_limbs_and_of_digits_are_exact(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(REPOSITORY)
    from benchmarks.other_kernels import compiled_visits, digits_of_32_bits, node_by_node, plane_by_plane, visits

    free = np.random.default_rng(4).random((13, 19)) > 0.2
    free[6, 7] = True
    settings = {"block": (5, 8), "iterations": 3}
    before = relax(free, [(6, 7)], schedule=[247], **settings).field
    after = relax(free, [(6, 7)], schedule=[255], start=before, **settings)
    movable = np.pad(free, 1)
    movable[7, 8] = False
    mask = np.where(movable, ~np.uint64(0), np.uint64(0))
    by_node = np.pad(before.shifted(255).limbs, ((1, 1), (1, 1), (0, 0)))
    by_plane = np.moveaxis(by_node, 2, 0).copy()
    digits = np.moveaxis(by_node.view(np.uint32), 2, 0).astype(np.int64)
    rest = (5, 8), 3, 10**6
    counts = (
        compiled_visits(node_by_node, by_node, mask, *rest, True),
        compiled_visits(plane_by_plane, by_plane, mask, *rest, False),
        visits(digits_of_32_bits, digits, movable, *rest, False),
    )
    assert counts == (after.total_iterations,) * 3
    ends = (
        by_node,
        np.moveaxis(by_plane, 0, 2),
        np.ascontiguousarray(np.moveaxis(digits, 0, 2).astype(np.uint32)).view(np.uint64),
    )
    for end in ends:
        assert Field(np.ascontiguousarray(end[1:-1, 1:-1]), 255) == after.field
