"""The entries of a certificate are the space: each design once, in spaces of any size."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
import pytest
import tampering

from codesign.ground.errors import CertificateError
from codesign.study.certificates import check as checker
from codesign.study.certificates.check import check
from codesign.study.certificates.file import unpacked
from codesign.study.certificates.form import Certificate, Claim, Definition, Head, layout

Box = tuple[list[int], list[int]]
SIZES = (1000, 2, 100_000, 7, 1000)


def cut_up(rng: Random, sizes: tuple[int, ...], count: int) -> list[Box]:
    """A space cut into boxes, again and again, as branch and bound does."""
    boxes: list[Box] = [([0] * len(sizes), list(sizes))]
    while len(boxes) < count:
        low, high = boxes.pop(rng.randrange(len(boxes)))
        axes = [axis for axis in range(len(sizes)) if high[axis] - low[axis] > 1]
        if not axes:
            boxes.append((low, high))
            continue
        axis = rng.choice(axes)
        cut = rng.randrange(low[axis] + 1, high[axis])
        boxes.append((low, [cut if place == axis else end for place, end in enumerate(high)]))
        boxes.append(([cut if place == axis else end for place, end in enumerate(low)], high))
    return boxes


def certificate(boxes: list[Box], sizes: tuple[int, ...] = SIZES) -> Certificate:
    """A certificate with the first design in a row, on the front, and boxes that it dominates."""
    axes = {f"a.{place}": list(range(size)) for place, size in enumerate(sizes)}
    figure = {"name": "time", "unit": "s", "best": "least"}
    definition: dict[str, Any] = {
        "platform": "bench", "workload": "maze", "conditions": [], "aggregate": {}, "derived": {}, "budgets": [],
        "axes": [{"axis": name, "values": values, "when": {}} for name, values in axes.items()],
        "figures": [figure], "objectives": [{"figure": 0, "direction": "minimise"}], "constraints": [],
        "identity": {}, "contents": {},
    }  # fmt: skip
    head = Head(
        format="hwsw certificate", version=1, rows=1, boxes=len(boxes), reasons=0, tasks=[""], names=[], texts=[],
        parts=[axes],
    )  # fmt: skip
    entries = len(boxes) + 1
    columns: dict[str, Any] = {
        "design": [0],
        "claim": [Claim.FRONT] + [Claim.DOMINATED] * len(boxes),
        "by": [0] * entries,
        "task": [0] * entries,
        "figures": [1] + [2] * len(boxes),
        "low": [low for low, _ in boxes],
        "high": [high for _, high in boxes],
        "part": [0] * len(boxes),
    }
    whole = Definition.model_validate(definition)
    return Certificate.of(
        whole,
        head,
        {
            name: np.array(columns.get(name, []), kind).reshape(shape)
            for name, (kind, shape) in layout(whole, head).items()
        },
    )


def boxes_but_the_first_design(rng: Random, sizes: tuple[int, ...], count: int) -> list[Box]:
    """Boxes that are the space but for design 0, which stands by itself."""
    rest = []
    for low, high in cut_up(rng, sizes, count):
        if any(low):
            rest.append((low, high))
            continue
        # The box of design 0 without it: on each axis what is behind 0, with 0 on those before it.
        for axis, end in enumerate(high):
            if end > 1:
                first = [*[0] * axis, 1, *low[axis + 1 :]]
                rest.append((first, [*[1] * axis, end, *high[axis + 1 :]]))
    return rest


@pytest.mark.parametrize("count", [1, 60, 3000])
def test_boxes_are_a_space_that_is_too_large_to_mark(count: int) -> None:
    boxes = boxes_but_the_first_design(Random(count), SIZES, count)
    verdict = check(certificate(boxes))
    assert verdict.front == (0,)
    assert verdict.designs[Claim.DOMINATED] == math.prod(SIZES) - 1


@pytest.mark.parametrize("seed", range(12))
def test_boxes_that_miss_a_design_or_meet_are_refused(seed: int) -> None:
    rng = Random(seed)
    boxes = boxes_but_the_first_design(rng, SIZES, 500)
    place = rng.randrange(len(boxes))
    low, high = boxes[place]
    axis = rng.choice([axis for axis in range(len(SIZES)) if high[axis] - low[axis] > 1] or [0])
    gone = [*boxes[:place], *boxes[place + 1 :]]
    with pytest.raises(CertificateError, match="in no entry"):
        check(certificate(gone))
    with pytest.raises(CertificateError, match="hold the same design"):
        check(certificate([*boxes, boxes[place]]))
    moved = [end + (axis == number) for number, end in enumerate(low)]
    if moved[axis] < high[axis]:
        with pytest.raises(CertificateError, match="in no entry"):
            check(certificate([*gone, (moved, high)]))
    # As many designs as the space, but not each once.
    other, its = rng.choice(gone)
    with pytest.raises(CertificateError, match="hold the same design"):
        check(certificate([*gone, (other, its)]))


@pytest.mark.parametrize(
    "tamper",
    [tampering.row_gone, tampering.row_twice, tampering.row_outside, tampering.box_moved, tampering.space_changed],
    ids=lambda tamper: tamper.__name__,
)
def test_both_counts_refuse_the_same(tamper: Callable[[bytes, Random], bytes], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checker, "MAX_DENSE", 0)
    original = tampering.sample_file()
    assert check(unpacked(original)).missing == 3
    for seed in range(8):
        with pytest.raises(CertificateError):
            check(unpacked(tamper(original, Random(seed))))


@pytest.mark.parametrize("seed", range(60))
def test_both_counts_agree_on_boxes_at_random(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng, sizes = Random(seed), (5, 4, 6)
    monkeypatch.setattr(checker, "_FEW", 2)
    boxes = boxes_but_the_first_design(rng, sizes, rng.randint(1, 40))
    for _ in range(rng.randrange(2)):
        low, high = boxes[rng.randrange(len(boxes))]
        axis = rng.randrange(3)
        rng.choice([low, high])[axis] += rng.choice([-1, 1])
    accepted = []
    for dense in (0, 10**8):
        monkeypatch.setattr(checker, "MAX_DENSE", dense)
        try:
            check(certificate(boxes, sizes))
            accepted.append(True)
        except CertificateError:
            accepted.append(False)
    assert accepted in ([True, True], [False, False])


def test_a_study_without_axes_is_one_design() -> None:
    assert check(certificate([], ())).front == (0,)


def test_boxes_that_lie_across_each_other_end() -> None:
    """Long thin boxes on all axes: they meet, and that is seen in bounded work."""
    sizes = (400, 400, 400, 400)
    boxes: list[Box] = []
    for axis in range(4):
        for place in range(1, 300):
            low = [0 if each == axis else place for each in range(4)]
            high = [400 if each == axis else place + 1 for each in range(4)]
            boxes.append((low, high))
    with pytest.raises(CertificateError):
        check(certificate(boxes, sizes))
