"""The certificate of a study says of each design what the study says of it, and its checker agrees."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn_studies import studies
from examples import examples
from explore_fakes import result
from hypothesis import given, settings
from plain_study import Plain

from codesign.ground.errors import CertificateError
from codesign.ground.figures import FIGURES
from codesign.inputs.constraint import constraint_of
from codesign.study.certificates.check import check
from codesign.study.certificates.file import packed, read_certificate, unpacked, write_certificate
from codesign.study.certificates.form import MAX_TEXTS, Claim
from codesign.study.certify import Listed, Reasons, certificate_of, differences
from codesign.study.front import dominators, non_dominated
from codesign.study.outcomes import Outcomes
from codesign.study.space import Box
from codesign.study.study import Study
from codesign.system.results.result import Reason

TWO = (FIGURES["first_plan_s"], FIGURES["slices"])


def states_of(study: Study) -> list[Claim | None]:
    """What the study says of each design; None where it leaves open what."""
    states: list[Claim | None] = []
    again = {index for others in study.same.values() for index in others}
    for design in study.designs:
        if design.state != "done":
            states.append(Claim.FAILED if design.state == "failed" else Claim.MISSING)
        elif design.index in again:
            states.append(Claim.SAME)
        elif not design.feasible:
            own = any(out.reason.kind != "constraint" for out in design.out)
            states.append(Claim.UNFIT if own else Claim.CONSTRAINT)
        elif design.unreached is not None:
            states.append(Claim.UNREACHED)
        elif study.lacking(design):
            states.append(Claim.LACKING)
        else:
            states.append(Claim.FRONT if design.index in study.front else Claim.DOMINATED)
    return states


@settings(max_examples=examples(400))
@given(studies())
def test_claims_are_those_of_the_study(drawn: tuple[Study, list[Plain]]) -> None:
    study, _ = drawn
    certificate = certificate_of(study)
    verdict = check(certificate)
    assert verdict.front == study.front
    states = states_of(study)
    assert [Claim(claim) for claim in certificate.columns["claim"].tolist()] == states
    assert verdict.designs == {claim: states.count(claim) for claim in Claim}
    again = unpacked(packed(certificate))
    assert packed(again) == packed(certificate)
    assert differences(again, study) == []


@settings(max_examples=examples(50))
@given(studies())
def test_figures_are_those_of_the_designs(drawn: tuple[Study, list[Plain]]) -> None:
    study, _ = drawn
    certificate = certificate_of(study)
    for number, figure in enumerate(certificate.definition.figures):
        column = certificate.columns["figures"][number].tolist()
        own = [design.figure(FIGURES[figure.name]) if design.state == "done" else None for design in study.designs]
        assert [None if math.isnan(value) else value for value in column] == own


def test_dominators_dominate() -> None:
    values = np.random.default_rng(2).integers(0, 9, (800, 3)).astype(float)
    values[::50, 1] = math.nan
    maximise = [False, True, False]
    front = values[non_dominated(values, maximise)]
    places = dominators(values, maximise, front)
    signs = np.array([1, -1, 1])
    for row, place in zip(values * signs, places.tolist(), strict=True):
        better = [(own <= row).all() and (own < row).any() for own in front * signs]
        assert better[place] if place >= 0 else not any(better)


def box_of(low: int, high: int, *, by: int | None = None, why: str = "", **bound: float) -> Box:
    return Box(0, (low,), (high,), bound or None, by, why)


def half(*, missing: bool = False) -> Study:
    """A study of which the last four of eight designs were not computed."""
    done = [result(seconds=1, slices=50), result(seconds=2, slices=20), result(seconds=2, slices=50)]
    outcomes = [
        *done,
        result(slices=110, fits=False),
        None,
        None,
        None,
        None if missing else result(seconds=9, slices=60),
    ]
    return Study("bench", "maze", {"a.b": tuple(range(8))}, TWO, (), Outcomes.of(outcomes))


def test_boxes_stand_for_designs_that_were_not_computed() -> None:
    study = replace(half(missing=True), constraints=(constraint_of("slices <= 70"),))
    excluded = [
        box_of(4, 6, by=1, why="dominated", first_plan_s=2, slices=30),
        box_of(6, 7, why="constraint slices", slices=71),
        box_of(7, 8, why="no clock reaches it"),
    ]
    certificate = unpacked(packed(certificate_of(study, excluded)))
    verdict = check(certificate)
    assert verdict.front == (0, 1)
    assert verdict.missing == 0
    assert (verdict.designs[Claim.DOMINATED], verdict.designs[Claim.CONSTRAINT]) == (3, 1)
    assert verdict.designs[Claim.UNFIT] == 2
    assert differences(certificate, study, excluded) == []
    assert differences(certificate, study)


def test_a_box_may_say_that_its_designs_are_missing() -> None:
    study = half(missing=True)
    assert check(certificate_of(study, [box_of(4, 8)])).missing == 4
    assert check(certificate_of(study)).missing == 4


def test_a_bound_that_is_equal_to_a_figure_of_the_front_excludes_nothing() -> None:
    study = half(missing=True)
    with pytest.raises(CertificateError, match="no design of the front dominates box 0"):
        certificate_of(study, [box_of(4, 8, by=1, why="dominated", first_plan_s=2, slices=20)])


def test_boxes_in_a_space_with_axes_that_do_not_always_exist() -> None:
    axes = {"a.b": (0, 1), "c.d": (0, 1, 2)}
    outcomes = Outcomes.of([result(seconds=1, slices=10), *[None] * 3])
    study = Study("bench", "maze", axes, TWO, (), outcomes, when={"c.d": {"a.b": (1,)}})
    excluded = [
        Box(1, (0, 0), (1, 2), {"first_plan_s": 2, "slices": 10}, 0, "dominated"),
        Box(1, (0, 2), (1, 3), {"first_plan_s": 1, "slices": 11}, 0, "dominated"),
    ]
    verdict = check(unpacked(packed(certificate_of(study, excluded))))
    assert (verdict.front, verdict.missing, verdict.designs[Claim.DOMINATED]) == ((0,), 0, 3)
    with pytest.raises(CertificateError, match="box 1 holds a design that another entry holds"):
        check(certificate_of(study, [excluded[0], replace(excluded[1], low=(0, 1))]))
    with pytest.raises(CertificateError, match="box 0 is outside the space"):
        check(certificate_of(study, [replace(excluded[0], high=(1, 4)), excluded[1]]))


def test_a_study_without_objectives_has_no_certificate(tmp_path: Path) -> None:
    study = replace(half(), objectives=())
    with pytest.raises(CertificateError, match="has no objectives"):
        study.certify(tmp_path / "file")
    assert list(tmp_path.iterdir()) == []


def test_equal_studies_have_equal_files(tmp_path: Path) -> None:
    assert half().certify(tmp_path / "a").front == (0, 1)
    write_certificate(read_certificate(tmp_path / "a"), tmp_path / "b")
    half().certify(tmp_path / "c")
    contents = {path.read_bytes() for path in tmp_path.iterdir()}
    assert len(contents) == 1


def test_another_study_is_named_by_what_differs() -> None:
    study = half()
    certificate = certificate_of(study)
    needing = replace(study, constraints=(constraint_of("slices < 60"),))
    assert differences(certificate, needing) == ["constraints"]
    assert differences(certificate, half(missing=True))[0].startswith("column")


def test_reasons_and_texts_are_bounded() -> None:
    texts, reasons = Listed(), Reasons()
    for number in range(MAX_TEXTS + 50):
        texts.number(f"failed {number}\nmore")
        reasons.number(Reason(kind="mapping", name=f"{number}", demand=number % 2, limit=1, gap=1, unit=""))
    assert len(texts.texts) == MAX_TEXTS
    assert texts.texts[:2] == ["failed 0", "failed 1"]
    assert len(reasons.names) <= MAX_TEXTS


def test_the_checker_imports_no_exploration(tmp_path: Path) -> None:
    half().certify(tmp_path / "file")
    script = (
        "import sys\n"
        "from pathlib import Path\n"
        "from codesign.study.certificates.check import check\n"
        "from codesign.study.certificates.file import read_certificate\n"
        f"check(read_certificate(Path({str(tmp_path / 'file')!r})))\n"
        "names = ('exploration', 'scenarios', 'system', 'planners', 'inputs', 'figures', 'results')\n"
        "print([name for name in names if f'codesign.{name}' in sys.modules])\n"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert ran.stdout == "[]\n"
