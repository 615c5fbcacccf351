"""Fronts of designs that hardly dominate each other: sets of bits against rows compared block by block."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.study.front import non_dominated

_BLOCK = 512
_BOTH = 24_000
Floats = NDArray[np.float64]


def run() -> list[Any]:
    """The rows of the table."""
    rows = []
    for count, objectives in ((_BOTH, 3), (_BOTH, 5), (94_000, 5)):
        values = sphere(count, objectives)
        seconds, front = _least(lambda values=values: non_dominated(values, [False] * values.shape[1]))
        ratio = ""
        if count <= _BOTH:
            slow, other = _least(lambda values=values: by_blocks(values))
            assert (front == other).all(), "one front"
            ratio = f"{slow / seconds:.1f}"
        case = f"{count:,} designs, {objectives} objectives"
        rows.append({"case": case, "front": f"{front.sum():,}", "processor s": f"{seconds:.2f}", "times faster": ratio})
    return rows


def sphere(count: int, objectives: int) -> Floats:
    """Designs none of which dominates another: of one distance from the ideal one."""
    values = np.abs(np.random.default_rng(3).normal(size=(count, objectives)))
    return np.asarray(values / np.linalg.norm(values, axis=1, keepdims=True), np.float64)


def by_blocks(values: Floats) -> NDArray[np.bool_]:
    """The front by comparing rows with the front so far, a block at a time, sorted by the first objective."""
    order = np.lexsort(values.T[::-1])
    keep, front = np.zeros(len(values), np.bool_), values[:0]
    for begin in range(0, len(order), _BLOCK):
        block = values[order[begin : begin + _BLOCK]]
        alive = np.ones(len(block), np.bool_)
        for start in range(0, len(front), _BLOCK):
            alive &= ~_at_most(front[start : start + _BLOCK], block).any(axis=0)
        among = _at_most(block, block)
        np.fill_diagonal(among, False)
        alive &= ~among.any(axis=0)
        keep[order[begin : begin + _BLOCK]] = alive
        front = np.concatenate([front, block[alive]])
    return keep


def _at_most(left: Floats, right: Floats) -> NDArray[np.bool_]:
    result = np.ones((len(left), len(right)), np.bool_)
    for objective in range(left.shape[1]):
        result &= left[:, None, objective] <= right[None, :, objective]
    return result


def _least(compute: Callable[[], NDArray[np.bool_]]) -> tuple[float, NDArray[np.bool_]]:
    times = []
    for _ in range(3):
        begin = time.process_time()
        front = compute()
        times.append(time.process_time() - begin)
    return min(times), front
