"""The certificate of a study of a million points: made, written, read and checked, and refused where it was changed."""

from __future__ import annotations

import resource
import time
from typing import Any

from benchmarks.bench_study import synthetic
from codesign.ground.errors import CertificateError
from codesign.study.certificates.check import check
from codesign.study.certificates.file import packed, unpacked
from codesign.study.certify import certificate_of


def run() -> list[Any]:
    """The rows of the table."""
    study = synthetic()
    rows, begin = [], time.process_time()
    rows.append(_row("front", len(study.front), begin))
    begin = time.process_time()
    certificate = certificate_of(study)
    rows.append(_row("claims", f"{certificate.head.rows:,} designs", begin))
    begin = time.process_time()
    content = packed(certificate)
    rows.append(_row("file", f"{len(content) / 1e6:.1f} MB", begin))
    begin = time.process_time()
    certificate = unpacked(content)
    rows.append(_row("read", f"{certificate.head.rows:,} designs", begin))
    begin = time.process_time()
    rows.append(_row("checked", f"{len(check(certificate).front)} on the front", begin))
    begin = time.process_time()
    rows.append(_row("one byte changed", _refusal(content[:10_000] + b"!" + content[10_001:]), begin))
    return rows


def _refusal(content: bytes) -> str:
    try:
        check(unpacked(content))
    except CertificateError as fault:
        return fault.what
    return "accepted"


def _row(case: str, outcome: object, begin: float) -> dict[str, str]:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    seconds = time.process_time() - begin
    return {"case": case, "outcome": str(outcome), "processor s": f"{seconds:.2f}", "peak MiB": f"{peak:,.0f}"}
