"""Certificates of searches: of the whole space by branch and bound, of what they evaluated by others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_search import AXES, of, small_workload
from tampering import array, array_bytes, digested, members_of

import codesign
from codesign.ground.errors import CertificateError, StoreError
from codesign.inputs import Platform, Workload
from codesign.study import explore, load_study, run, search_run
from codesign.study.blocks import compressed
from codesign.study.budget import Budget
from codesign.study.certificates.check import check
from codesign.study.certificates.file import packed, unpacked, write_certificate
from codesign.study.certificates.form import Certificate, Claim
from codesign.study.certify import certificate_of, differences, holders, rest_of
from codesign.study.store import Batch, FileStore
from codesign.study.study import Study

pytestmark = pytest.mark.usefixtures("searched")

SEARCHED = ("random", "nsga2", "tpe")


@pytest.fixture(scope="module")
def platform() -> Platform:
    return codesign.load_platform("virtex4-pci")


@pytest.fixture(scope="module")
def workload(tmp_path_factory: pytest.TempPathFactory) -> Workload:
    return of(small_workload(tmp_path_factory.mktemp("search")), AXES, constraints=("power < 1.2 W",))


@pytest.fixture(scope="module")
def every(platform: Platform, workload: Workload) -> Study:
    return explore(platform, workload, workers=1)


@pytest.fixture(scope="module")
def store(searched: None, platform: Platform, workload: Workload, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of a front that branch and bound proved."""
    file = tmp_path_factory.mktemp("stores") / "proved.sqlite"
    explore(platform, workload, workers=1, store=file, search="bound")
    return file


@pytest.fixture
def held_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """No space is small enough to hold: a study has the designs that were evaluated."""
    monkeypatch.setattr(run, "MAX_STUDY_POINTS", 1)
    monkeypatch.setattr(search_run, "MAX_STUDY_POINTS", 1)


def test_branch_and_bound_proves_the_front_of_the_whole_space(every: Study, store: Path) -> None:
    study = load_study(store)
    certificate = unpacked(packed(certificate_of(study)))
    verdict = check(certificate)
    assert verdict.front == every.front
    assert verdict.missing == 0
    assert certificate.head.rows < len(every.designs) / 2
    assert {*certificate.columns["claim"][certificate.head.rows :]} == {Claim.DOMINATED, Claim.CONSTRAINT}
    assert differences(certificate, study) == []


def test_a_study_that_was_read_has_the_certificate_of_the_computed_one(
    platform: Platform, workload: Workload, store: Path
) -> None:
    computed = explore(platform, workload, workers=1, search="bound")
    assert packed(certificate_of(computed)) == packed(certificate_of(load_study(store)))


def test_boxes_of_what_was_evaluated_since_are_rows(
    platform: Platform, workload: Workload, every: Study, tmp_path: Path
) -> None:
    file = tmp_path / "points.sqlite"
    explore(platform, workload, workers=1, store=file, search="bound")
    study = explore(platform, workload, workers=1, store=file)
    assert study.excluded
    assert packed(certificate_of(study)) == packed(certificate_of(every))


@pytest.mark.usefixtures("held_apart")
@pytest.mark.parametrize("points", [5, None])
def test_designs_of_a_large_space_have_their_numbers_in_it(
    platform: Platform, workload: Workload, every: Study, points: int | None, tmp_path: Path
) -> None:
    file = tmp_path / "points.sqlite"
    study = explore(platform, workload, workers=1, store=file, search="bound", budget=Budget(points=points))
    assert study.chosen is not None
    certificate = certificate_of(study)
    verdict = check(certificate)
    assert sum(verdict.designs.values()) == len(every.designs)
    assert (verdict.missing == 0) == (points is None)
    assert sorted(verdict.front) == sorted(study.chosen[index] for index in study.front)
    if points is None:
        assert verdict.front == every.front
    assert differences(certificate, load_study(file)) == []


@pytest.mark.usefixtures("held_apart")
@pytest.mark.parametrize("name", SEARCHED)
def test_other_searches_certify_what_they_evaluated(platform: Platform, workload: Workload, name: str) -> None:
    if name != "random":
        pytest.importorskip("optuna")
    study = explore(platform, workload, workers=1, search=name, seed=1, budget=Budget(points=30))
    verdict = check(certificate_of(study))
    assert verdict.missing == len(study.decisions.whole) - len(study.designs)  # type: ignore[attr-defined]


def test_the_command_refuses_what_is_not_complete_and_what_is_of_another_study(
    hwsw: Callable[..., Any], platform: Platform, workload: Workload, store: Path, tmp_path: Path
) -> None:
    other = tmp_path / "random.sqlite"
    study = explore(platform, workload, workers=1, store=other, search="random", budget=Budget(points=30))
    study.certify(tmp_path / "random.front")
    load_study(store).certify(tmp_path / "proved.front")
    proved = hwsw("verify-front", tmp_path / "proved.front", "--complete", "--store", store)
    assert proved.exit_code == 0
    assert "are the front." in proved.stdout
    refused = hwsw("verify-front", tmp_path / "random.front", "--complete")
    assert refused.exit_code == 3
    assert "258 designs not computed" in refused.stderr
    assert hwsw("verify-front", tmp_path / "random.front", "--store", other).exit_code == 0
    for file, its in (("proved", other), ("random", store)):
        assert hwsw("verify-front", tmp_path / f"{file}.front", "--store", its).exit_code == 3


def _wider(columns: dict[str, Any], box: int, rows: int) -> None:
    axis = int(np.flatnonzero(columns["low"][box] > 0)[0])
    columns["low"][box, axis] -= 1


def _lower(columns: dict[str, Any], box: int, rows: int) -> None:
    columns["figures"][:, rows + box] /= 1e3


def _other(columns: dict[str, Any], box: int, rows: int) -> None:
    figures = columns["figures"]
    front = np.flatnonzero(columns["claim"][:rows] == Claim.FRONT)
    wrong = [row for row in front if (figures[:3, row] > figures[:3, rows + box]).any()]
    columns["by"][rows + box] = wrong[0]


@pytest.mark.parametrize(
    ("tamper", "why"),
    [
        (_wider, "holds a design that another entry holds"),
        (_lower, "is not dominated by the design that it names"),
        (_other, "is not dominated by the design that it names"),
    ],
)
def test_a_box_that_was_tampered_with_is_refused(store: Path, tamper: Any, why: str) -> None:
    forged = tampered(certificate_of(load_study(store)), tamper)
    with pytest.raises(CertificateError, match=why):
        check(forged)


def test_a_bound_that_was_improved_is_refused_by_the_store(store: Path) -> None:
    """A front may dominate it all the more: the checker alone cannot see it."""
    study = load_study(store)

    def improve(columns: dict[str, Any], box: int, rows: int) -> None:
        columns["figures"][:, rows + box] *= 1.5

    forged = tampered(certificate_of(study), improve)
    assert check(forged).front == check(certificate_of(study)).front
    assert differences(forged, study) == ["column figures"]


def tampered(certificate: Certificate, tamper: Callable[[dict[str, Any], int, int], None]) -> Certificate:
    """A certificate of which one dominated box was changed, with all digests made anew."""
    rows = certificate.head.rows
    claims = certificate.columns["claim"][rows:]
    dominated = (claims == Claim.DOMINATED) & (certificate.columns["low"] > 0).any(axis=1)
    members = members_of(packed(certificate))
    columns = {name: array(members[f"{name}.npy"]) for name in certificate.columns}
    tamper(columns, int(np.flatnonzero(dominated)[0]), rows)
    return unpacked(digested(members | {f"{name}.npy": array_bytes(values) for name, values in columns.items()}))


def test_a_box_that_an_evaluated_design_betters_is_refused(every: Study, store: Path) -> None:
    boxes = load_study(store).excluded
    number = next(number for number, box in enumerate(boxes) if box.by is not None and box.designs > 1)
    better = replace(boxes[number], bound={name: value * 1e3 for name, value in boxes[number].bound.items()})  # type: ignore[union-attr]
    state = every.outcomes.state.copy()
    state[: len(state)] = 1
    wrong = [*boxes[:number], better, *boxes[number + 1 :]]
    space = every.decisions.parts[better.part]
    shape = [*map(len, space.axes.values())]
    inside = np.ravel_multi_index(better.low, shape)
    # One design of the box is missing, so that the box is needed; the others are known.
    state[space.begin + int(inside)] = 0
    study = replace(every, outcomes=replace(every.outcomes, state=state))
    with pytest.raises(CertificateError, match="was evaluated, and is better than its box allows"):
        certificate_of(study, wrong)


def test_conditions_and_needs_drop_the_boxes(store: Path) -> None:
    study = load_study(store)
    assert study.needing(()).excluded == study.excluded
    assert study.needing(("slices < 20 %",)).excluded == ()


@pytest.mark.parametrize(
    "text", ["{}", "[1]", '[[0,[0],[1],null,null,"fit"]]', '[[9,[],[],null,null,"fit"]]', '[["a",[],[],{},0,""]]']
)
def test_boxes_that_are_none_are_refused(store: Path, tmp_path: Path, text: str) -> None:
    import hashlib

    file = tmp_path / "points.sqlite"
    file.write_bytes(store.read_bytes())
    with FileStore(file) as opened:
        latest = opened.latest()
        assert latest is not None
        key = "excluded " + hashlib.sha256(latest[0].encode()).hexdigest()
        assert [name for name, _ in opened.blocks([key])] == [key]
        opened.put(Batch(blocks={key: compressed(text.encode())}))
    if text == "{}":
        assert load_study(file).excluded == ()
        return
    with pytest.raises(StoreError, match="boxes of a search"):
        load_study(file)


def test_what_is_left_of_a_grid_fills_it() -> None:
    random = np.random.default_rng(4)
    for shape in ((7,), (5, 6), (4, 3, 5), (1, 4), (60, 50)):
        for count in (0, 1, 3, 10, 200):
            taken = np.zeros(shape, np.int64)
            boxes = []
            for _ in range(count):
                low = np.array([random.integers(size) for size in shape])
                high = np.array(
                    [random.integers(begin, min(begin + 3, size)) + 1 for begin, size in zip(low, shape, strict=True)]
                )
                inside = tuple(map(slice, low, high))
                if not taken[inside].any():
                    boxes.append((low, high))
                    taken[inside] = len(boxes)
            first, last = (np.array([box[end] for box in boxes], np.int64).reshape(-1, len(shape)) for end in (0, 1))
            grid = np.argwhere(np.ones(shape))
            assert (holders(first, last, grid) == taken.reshape(-1) - 1).all()
            for begin, end in rest_of(first, last, shape):
                assert not taken[tuple(map(slice, begin, end))].any()
                taken[tuple(map(slice, begin, end))] = -1
            assert taken.all()


def test_boxes_that_meet_leave_nothing_to_certify() -> None:
    low, high = np.array([[0, 0], [0, 0]]), np.array([[1, 2], [1, 2]])
    with pytest.raises(CertificateError, match="hold the same design"):
        rest_of(low, high, (5, 5))


def test_the_certificate_is_written(store: Path, tmp_path: Path) -> None:
    study = load_study(store)
    study.certify(tmp_path / "one")
    write_certificate(certificate_of(study), tmp_path / "two")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()
