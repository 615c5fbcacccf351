"""A certificate that was tampered with is refused, however it was done."""

from __future__ import annotations

import tracemalloc
from random import Random

import numpy as np
import pytest
import tampering

from codesign.ground.errors import CertificateError
from codesign.study.certificates.check import check
from codesign.study.certificates.file import unpacked
from codesign.study.certificates.form import Claim
from codesign.study.certify import differences

ROUNDS = 4
MOST_BYTES = 64 * 2**20


def refusal(content: bytes) -> str | None:
    """Why a file is refused; None where it is accepted. The memory that this took is bounded."""
    tracemalloc.start()
    try:
        check(unpacked(content))
    except CertificateError as fault:
        return fault.what
    finally:
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert most < MOST_BYTES
    return None


def tampered(tamper: tampering.Tamper, seeds: range) -> list[int]:
    """The seeds by which a tampered file was accepted, though it is not the original."""
    accepted = []
    for seed in seeds:
        original = tampering.sample_file(seed % 5)
        content = tamper(original, Random(seed))
        if refusal(content) is None and content != original:
            accepted.append(seed)
    return accepted


def test_the_sample_holds_every_claim_that_boxes_and_rows_make() -> None:
    certificate = unpacked(tampering.sample_file())
    verdict = check(certificate)
    kinds = {*Claim} - {Claim.SAME, Claim.UNREACHED}
    assert {claim for claim, count in verdict.designs.items() if count} == kinds
    rows = certificate.head.rows
    assert certificate.columns["claim"][rows:].tolist() == [
        Claim.DOMINATED,
        Claim.CONSTRAINT,
        Claim.UNFIT,
        Claim.MISSING,
    ]


@pytest.mark.parametrize("tamper", tampering.ALL, ids=lambda tamper: tamper.__name__)
def test_a_tampered_certificate_is_refused(tamper: tampering.Tamper) -> None:
    assert tampered(tamper, range(ROUNDS)) == []


@pytest.mark.slow
@pytest.mark.parametrize("tamper", tampering.ALL, ids=lambda tamper: tamper.__name__)
def test_a_thousand_tampered_certificates_are_refused(tamper: tampering.Tamper) -> None:
    assert tampered(tamper, range(ROUNDS, ROUNDS + 1 + 1000 // len(tampering.ALL))) == []


@pytest.mark.parametrize("tamper", tampering.CLAIMS, ids=lambda tamper: tamper.__name__)
def test_a_false_claim_is_named_where_all_digests_are_made_anew(tamper: tampering.Tamper) -> None:
    why = refusal(tamper(tampering.sample_file(), Random(1)))
    assert why is not None
    assert "digest" not in why
    assert "seal" not in why


def test_figures_that_were_changed_all_through_are_refused_by_the_study() -> None:
    """Every claim is true of them, and every digest is theirs. What they are not is the figures of the study."""
    study, excluded = tampering.sample()
    members = tampering.members_of(tampering.sample_file())
    values = tampering.array(members["figures.npy"])
    members["figures.npy"] = tampering.array_bytes(np.ascontiguousarray(values * np.array([[2.0], [1], [1]])))
    forged = unpacked(tampering.digested(members))
    assert check(forged).front == check(unpacked(tampering.sample_file())).front
    assert differences(forged, study, excluded) == ["column figures"]


def test_no_certificate_at_all_is_refused() -> None:
    for content in (b"", b"text", b"PK\x03\x04", b"SQLite format 3\0" + bytes(100), bytes(1000)):
        assert refusal(content) is not None
