"""``hwsw verify-front``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.requests import VerifyFront
from codesign.ground.errors import CertificateError, InputError, RefusedError, clip, printable
from codesign.ground.late import load
from codesign.ground.units import counted, format_count
from codesign.study.certificates.check import check
from codesign.study.certificates.file import read_certificate
from codesign.study.certificates.form import WORDS

if TYPE_CHECKING:
    from codesign.study.certificates.check import Verdict
    from codesign.study.certificates.form import Certificate

_MOST = 12


def verify_front(asked: VerifyFront) -> None:
    """Check the certificate in FILE: whether its front follows from the figures stated. Nothing is simulated."""
    if asked.store is None and (asked.conditions or asked.needs):
        option = "--condition" if asked.conditions else "--need"
        raise InputError("needs a store", option, "name it too: --store STORE")
    certificate = read_certificate(asked.file)
    try:
        verdict = check(certificate)
    except CertificateError as fault:
        raise RefusedError(f"refused: {fault.what}", str(asked.file), fault.hint) from fault
    if asked.complete and verdict.missing:
        what = f"refused: {counted(verdict.missing, 'design')} not computed"
        raise RefusedError(what, str(asked.file), "complete the exploration, and write it again")
    if asked.store is not None:
        _compare(certificate, asked.file, asked.store, asked.conditions, asked.needs)
    if asked.as_json:
        click.echo(json.dumps(_document(certificate, verdict)))
        return
    click.echo(_sentence(certificate, verdict))
    click.echo()
    for word, count in {WORDS[claim]: count for claim, count in verdict.designs.items() if count}.items():
        click.echo(f"{word:<22}{format_count(count):>14}")
    click.echo()
    for line in _trusted(verdict):
        click.echo(line)
    click.echo()
    click.echo(f"study    {certificate.digests.study}")
    click.echo(f"content  {certificate.digests.content}")
    if asked.store is not None:
        click.echo(f"It is the certificate of the exploration in {printable(str(asked.store), None)}.")


def _compare(
    certificate: Certificate, file: Path, store: Path, conditions: Mapping[str, object], needs: tuple[str, ...]
) -> None:
    # Only here: a check by itself needs nothing of what it checks.
    study = load("codesign.study:load_study")(store).needing(needs).at(conditions)
    different = load("codesign.study.certify:differences")(certificate, study)
    if different:
        what = f"refused: it is not of the exploration in {store}: they differ in {clip(', '.join(different), 200)}"
        hint = f"write its certificate: hwsw report {store} --certify FILE"
        raise RefusedError(what, str(file), hint)


def _sentence(certificate: Certificate, verdict: Verdict) -> str:
    definition, total = certificate.definition, sum(verdict.designs.values())
    whole = "" if not verdict.missing else f" of those computed ({format_count(verdict.missing)} were not)"
    names, count = printable(f"{definition.workload} on {definition.platform}", None), len(verdict.front)
    are = f"{counted(count, 'design')} of {format_count(total)} {'is' if count == 1 else 'are'} the front"
    return f"Accepted: of {names}, {are}{whole}."


def _trusted(verdict: Verdict) -> list[str]:
    """The facts taken on trust: those that are no claim, then the claims that keep the most designs off the front."""
    order = sorted(verdict.trusted, key=lambda each: (each.eligible is not None, -(each.eligible or 0), -each.designs))
    lines = [f"{'taken on trust':<48}{'designs':>14}{'eligible by figures':>22}"]
    for each in order[:_MOST]:
        what = clip(printable(each.what, None), 44)
        open_ = "" if each.eligible is None else format_count(each.eligible)
        lines.append(f"{what:<48}{format_count(each.designs):>14}{open_:>22}".rstrip())
    if len(order) > _MOST:
        lines.append(f"and {counted(len(order) - _MOST, 'claim')} more: --json")
    return lines


def _document(certificate: Certificate, verdict: Verdict) -> dict[str, object]:
    return {
        "platform": certificate.definition.platform,
        "workload": certificate.definition.workload,
        "designs": {claim.name.lower(): count for claim, count in verdict.designs.items()},
        "front": list(verdict.front),
        "trusted": [asdict(each) for each in verdict.trusted],
        "study": certificate.digests.study,
        "content": certificate.digests.content,
    }
