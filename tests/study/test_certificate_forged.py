"""Forged certificates, every digest made anew: what is accepted follows from its figures, or is named as trusted."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
import pytest
from certificate_sample import sample
from drawn_studies import studies
from examples import examples
from hypothesis import event, given, settings
from hypothesis import strategies as st

from codesign.ground.errors import CertificateError
from codesign.study.certificates.check import Verdict, check
from codesign.study.certificates.file import packed, unpacked
from codesign.study.certificates.form import WORDS, Certificate, Claim
from codesign.study.certify import certificate_of

Columns = dict[str, Any]
Forge = Callable[[Certificate, Columns, Random], None]
OFF = (Claim.UNFIT, Claim.UNREACHED, Claim.FAILED, Claim.MISSING)


# ---- forgeries: each changes columns in place ----


def claims_another(certificate: Certificate, columns: Columns, rng: Random) -> None:
    """An entry makes any claim, and names anything."""
    entry = rng.randrange(len(columns["claim"]))
    columns["claim"][entry] = rng.choice([*Claim])
    columns["by"][entry] = rng.randrange(-1, len(columns["claim"]) + 1)


def claims_unfit(certificate: Certificate, columns: Columns, rng: Random) -> None:
    """A row is unfit for a reason that another one has."""
    if certificate.head.reasons:
        row = rng.randrange(certificate.head.rows)
        columns["claim"][row], columns["by"][row] = Claim.UNFIT, rng.randrange(certificate.head.reasons)


def claims_failed(certificate: Certificate, columns: Columns, rng: Random) -> None:
    """A row failed, or was not computed, and has no figures."""
    row = rng.randrange(certificate.head.rows)
    columns["claim"][row], columns["by"][row] = rng.choice([Claim.FAILED, Claim.MISSING, Claim.UNREACHED]), 0
    columns["figures"][:, row] = math.nan


def claims_same(certificate: Certificate, columns: Columns, rng: Random) -> None:
    """A row is the same as an earlier one, and has its figures; task and budgets are its too, or one is not."""
    first, row = sorted(rng.choices(range(certificate.head.rows), k=2))
    columns["claim"][row], columns["by"][row] = Claim.SAME, first
    for name in ("figures", "budgets", "task"):
        columns[name][..., row] = columns[name][..., first]
    name = rng.choice(["figures", "budgets", "task"])
    columns[name][..., row] += rng.choice([0, 1])


def has_another_task(certificate: Certificate, columns: Columns, rng: Random) -> None:
    columns["task"][rng.randrange(len(columns["task"]))] = rng.choice([0, 1])


def has_other_figures(certificate: Certificate, columns: Columns, rng: Random) -> None:
    """A figure or a budget is that of another entry, or none, or any."""
    name = rng.choice(["figures", "budgets"])
    if columns[name].size:
        of = columns[name][rng.randrange(len(columns[name]))]
        of[rng.randrange(len(of))] = rng.choice([rng.choice(of.tolist()), math.nan, 0.0, 7.0])


def has_another_reason(certificate: Certificate, columns: Columns, rng: Random) -> None:
    name = rng.choice(["name", "demand", "limit"])
    if certificate.head.reasons:
        changed = columns[name]
        changed[rng.randrange(len(changed))] = rng.choice([*changed.tolist(), 0, 1])


FORGERIES: list[Forge] = [
    claims_another, claims_unfit, claims_failed, claims_same, has_another_task, has_other_figures, has_another_reason,
]  # fmt: skip


def forged(certificate: Certificate, forgeries: list[Forge], rng: Random) -> Certificate:
    """A certificate after forgeries, at one with itself. It has a task more than it needs."""
    head = certificate.head.model_copy(update={"tasks": [*certificate.head.tasks, "another"]})
    columns = {name: np.array(column) for name, column in certificate.columns.items()}
    for forge in forgeries:
        forge(certificate, columns, rng)
    return unpacked(packed(Certificate.of(certificate.definition, head, columns)))


# ---- what an accepted certificate may say, one by one, from its figures ----


def eligible(certificate: Certificate, entry: int) -> bool:
    """Whether the figures of an entry have every objective and keep every constraint."""
    definition, columns = certificate.definition, certificate.columns
    for each in definition.objectives:
        if math.isnan(columns["figures"][each.figure, entry]):
            return False
    for bound in definition.constraints:
        value = float(columns["figures"][bound.figure, entry])
        budget = 1.0 if bound.budget is None else float(columns["budgets"][bound.budget, entry])
        share = value / (1.0 if math.isnan(budget) or budget == 0 else budget)
        kept = {
            "at_least": share >= bound.limit,
            "at_most": share <= bound.limit,
            "above": share > bound.limit,
            "below": share < bound.limit,
        }
        if not kept[bound.bound]:
            return False
    return True


def better(certificate: Certificate, one: int, other: int) -> bool:
    """Whether a row dominates another one."""
    if certificate.columns["task"][one] != certificate.columns["task"][other]:
        return False
    pairs = []
    for each in certificate.definition.objectives:
        sign = 1 if each.direction == "minimise" else -1
        values = certificate.columns["figures"][each.figure]
        pairs.append((sign * values[one], sign * values[other]))
    return all(a <= b for a, b in pairs) and any(a < b for a, b in pairs)


def front_of_figures(certificate: Certificate) -> set[int]:
    """The rows that no other one dominates, but for those that a claim on trust takes out."""
    claim, by = certificate.columns["claim"].tolist(), certificate.columns["by"].tolist()
    own = [claim[by[row]] if claim[row] == Claim.SAME else claim[row] for row in range(certificate.head.rows)]
    held = [row for row, each in enumerate(own) if each not in OFF and eligible(certificate, row)]
    return {row for row in held if not any(better(certificate, other, row) for other in held)}


def assert_holds(certificate: Certificate, verdict: Verdict) -> None:
    """The front is that of the figures; designs that are the same as one of it count there."""
    columns, rows = certificate.columns, certificate.head.rows
    claim, by, design = (columns[name].tolist() for name in ("claim", "by", "design"))
    front = front_of_figures(certificate)
    same = {row for row in range(rows) if claim[row] == Claim.SAME}
    assert {design[row] for row in front - same} == {*verdict.front}
    assert front & same == {row for row in same if by[row] in front}
    for row in same:
        assert claim[by[row]] not in (Claim.SAME, Claim.FAILED, Claim.MISSING)
        for name in ("task", "budgets", "figures"):
            own, its = (columns[name][..., each] for each in (row, by[row]))
            assert np.array_equal(own, its, equal_nan=name != "task")
    shown = {row for row in range(rows) if claim[row] == Claim.UNFIT and follows(certificate, row)}
    sizes = [1] * rows + [math.prod(box) for box in (columns["high"] - columns["low"]).tolist()]
    for kind in (Claim.UNFIT, Claim.UNREACHED, Claim.FAILED, Claim.SAME):
        entries = [entry for entry, own in enumerate(claim) if own == kind and entry not in shown]
        open_ = [entry for entry in entries if entry >= rows or kind == Claim.FAILED or eligible(certificate, entry)]
        named = [each for each in verdict.trusted if each.what.split(":")[0] == WORDS[kind]]
        assert sum(each.designs for each in named) == sum(sizes[entry] for entry in entries)
        assert sum(each.eligible or 0 for each in named) == sum(sizes[entry] for entry in open_)
    bounds = sum(sizes[entry] for entry in range(rows, len(claim)) if claim[entry] in (1, 2))
    assert [each.designs for each in verdict.trusted if each.what == "bounds of boxes"] == [bounds] * bool(bounds)
    assert verdict.missing == sum(size for size, own in zip(sizes, claim, strict=True) if own == Claim.MISSING)


def follows(certificate: Certificate, row: int) -> bool:
    """Whether a row is unfit by its own figures: demand and limit are stated of it, and are not others."""
    definition, columns = certificate.definition, certificate.columns
    reason = columns["by"][row]
    name = certificate.head.names[columns["name"][reason]]
    if name.kind != "resource" or definition.conditions:
        return False
    stated = {each.name: columns["figures"][place, row] for place, each in enumerate(definition.figures)}
    budgets = {each: columns["budgets"][place, row] for place, each in enumerate(definition.budgets)}
    assert stated.get(name.name, columns["demand"][reason]) == columns["demand"][reason]
    assert budgets.get(name.name, columns["limit"][reason]) == columns["limit"][reason]
    return name.name in stated and name.name in budgets


def accepted(certificate: Certificate) -> Verdict | None:
    try:
        return check(certificate)
    except CertificateError:
        return None


@st.composite
def certificates(draw: st.DrawFn) -> Certificate:
    """Of a study of any kind, or of one with boxes."""
    if draw(st.integers(0, 3)) == 0:
        return certificate_of(*sample(draw(st.integers(0, 20))))
    return certificate_of(draw(studies())[0])


@settings(max_examples=examples(400))
@given(certificates(), st.lists(st.sampled_from(FORGERIES), max_size=3), st.randoms(use_true_random=False))
def test_what_is_accepted_follows_from_its_figures_or_is_named(
    original: Certificate, forgeries: list[Forge], rng: Random
) -> None:
    certificate = forged(original, forgeries, rng)
    verdict = accepted(certificate)
    event("accepted" if verdict else "refused")
    if verdict is not None:
        assert_holds(certificate, verdict)


@pytest.mark.parametrize("forge", FORGERIES, ids=lambda forge: forge.__name__)
def test_each_forgery_is_tried_where_it_is_accepted_and_refused(forge: Forge) -> None:
    fates = set()
    for seed in range(80):
        certificate = forged(certificate_of(*sample(seed % 5)), [forge], Random(seed))
        verdict = accepted(certificate)
        fates.add(verdict is not None)
        if verdict is not None:
            assert_holds(certificate, verdict)
    assert fates == {True, False}
