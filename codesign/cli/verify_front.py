"""``hwsw verify-front``."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import need_option, settings_of
from codesign.errors import CertificateError, InputError, RefusedError, clip, printable
from codesign.units import counted, format_count

if TYPE_CHECKING:
    from codesign.certificates.check import Verdict
    from codesign.certificates.form import Certificate

_FILE = click.Path(exists=True, dir_okay=False, path_type=Path)
_MOST = 12


@click.command(name="verify-front", short_help="Check the certificate of a front. Nothing is simulated.")
@click.argument("file", type=_FILE)
@click.option(
    "--store", type=_FILE, help="Check too that it is the certificate of the exploration in this store."
)
@click.option(
    "--condition",
    "conditions",
    multiple=True,
    metavar="AXIS=VALUE",
    help="With --store: the condition that it was written for, as in hwsw report.",
)
@need_option
@click.option("--complete", is_flag=True, help="Refuse it where designs were not computed.")
@click.option("--json", "as_json", is_flag=True, help="Print the verdict as JSON.")
def verify_front(
    file: Path,
    store: Path | None,
    conditions: tuple[str, ...],
    needs: tuple[str, ...],
    complete: bool,
    as_json: bool,
) -> None:
    """Check the certificate in FILE: whether its front follows from the figures stated. Nothing is simulated.

    What the certificate says and nothing in it shows is counted as taken on trust.

    The exit code is 3 where it is refused, and 1 where FILE cannot be read as a certificate.
    """
    from codesign.certificates.check import check
    from codesign.certificates.file import read_certificate

    if store is None and (conditions or needs):
        option = "--condition" if conditions else "--need"
        raise InputError("needs a store", option, "name it too: --store STORE")
    certificate = read_certificate(file)
    try:
        verdict = check(certificate)
    except CertificateError as fault:
        raise RefusedError(f"refused: {fault.what}", str(file), fault.hint) from fault
    if complete and verdict.missing:
        what = f"refused: {counted(verdict.missing, 'design')} not computed"
        raise RefusedError(what, str(file), "complete the exploration, and write it again")
    if store is not None:
        _compare(certificate, file, store, conditions, needs)
    if as_json:
        click.echo(json.dumps(_document(certificate, verdict)))
        return
    click.echo(_sentence(certificate, verdict))
    click.echo()
    for word, count in _counts(verdict).items():
        click.echo(f"{word:<22}{format_count(count):>14}")
    click.echo()
    for line in _trusted(verdict):
        click.echo(line)
    click.echo()
    click.echo(f"study    {certificate.digests.study}")
    click.echo(f"content  {certificate.digests.content}")
    if store is not None:
        click.echo(f"It is the certificate of the exploration in {printable(str(store), None)}.")


def _compare(
    certificate: Certificate, file: Path, store: Path, conditions: tuple[str, ...], needs: tuple[str, ...]
) -> None:
    from codesign.exploration import load_study
    from codesign.exploration.certify import differences

    study = load_study(store).needing(needs).at(settings_of(conditions, "--condition"))
    different = differences(certificate, study)
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


def _counts(verdict: Verdict) -> dict[str, int]:
    from codesign.certificates.form import WORDS

    return {WORDS[claim]: count for claim, count in verdict.designs.items() if count}


def _trusted(verdict: Verdict) -> list[str]:
    """What was taken on trust: what is no claim, then the claims that keep the most designs off the front."""
    order = sorted(
        verdict.trusted, key=lambda each: (each.eligible is not None, -(each.eligible or 0), -each.designs)
    )
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
