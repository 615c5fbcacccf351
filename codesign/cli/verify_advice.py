"""``hwsw verify-advice``."""

from __future__ import annotations

import json

import click

from codesign.cli.requests import VerifyAdvice
from codesign.ground.errors import RefusedError, printable
from codesign.ground.units import counted
from codesign.study.advice.certificate import Certificate, faults_of, read_certificate
from codesign.study.advice.search import COUNTS


def verify_advice(asked: VerifyAdvice) -> None:
    """Check the certificate in FILE: whether no cheaper board follows from its figures. Nothing is simulated."""
    certificate = read_certificate(asked.file)
    faults = list(faults_of(certificate))
    if faults:
        more = f", and {len(faults) - 1:,} more" if len(faults) > 1 else ""
        raise RefusedError(f"refused: {faults[0]}{more}", str(asked.file), "ask the question again with --certify")
    if asked.as_json:
        click.echo(json.dumps(_document(certificate)))
        return
    click.echo(f"Accepted: {printable(_sentence(certificate), None)}.")
    click.echo()
    for word, count in _designs(certificate).items():
        click.echo(f"{word:<22}{count:>14,}")
    click.echo()
    click.echo("taken on trust: the units, clocks, demands and simulated times, which follow from laws and maps")
    click.echo(f"problem  {certificate.problem}")
    click.echo(f"code     {certificate.code}")
    click.echo(f"content  {certificate.digest}")


def _sentence(certificate: Certificate) -> str:
    boards = counted(len(certificate.boards), "board")
    about = f"{boards} that cost less than {certificate.recommended}" if certificate.recommended else boards
    return {
        "proved": f"no design of {about} suffices, at any value inside the declared intervals",
        "at own values": f"no design of {about} suffices, at the figures' own values",
        "not proved": f"of {about} not all designs were looked at, so that none suffices is not proved",
    }[certificate.state]


def _designs(certificate: Certificate) -> dict[str, int]:
    """The designs of all boards by what became of them."""
    return {state: sum(getattr(each.searched, state) for each in certificate.boards) for state in COUNTS}


def _document(certificate: Certificate) -> dict[str, object]:
    return {
        "state": certificate.state,
        "recommended": certificate.recommended,
        "boards": len(certificate.boards),
        "designs": _designs(certificate),
        "digest": certificate.digest,
    }
