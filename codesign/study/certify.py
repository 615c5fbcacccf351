"""The certificate of the front of a study. ``codesign.study.certificates`` checks it, and knows no study."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from codesign.ground.errors import CertificateError
from codesign.inputs.aggregate import rule_as_written
from codesign.inputs.axes import value_text
from codesign.study.certificates.check import Verdict, check
from codesign.study.certificates.file import write_certificate
from codesign.study.certificates.form import MAX_BOXES, MAX_ROWS, Certificate, Definition, Head, layout
from codesign.study.claims import Claims
from codesign.study.space import Box
from codesign.study.table import Table


def certify(table: Table, path: Path | str, excluded: Sequence[Box] | None = None) -> Verdict:
    """Write the certificate of the front of a study to a file, once the checker has accepted it.

    ``excluded``: boxes of designs that were not computed; by default those of the study.

    Raises:
        CertificateError: the study has no objectives, or more designs than a certificate holds; or nothing excludes a
            box, or a design betters its box. RunError: the file cannot be written.
    """
    certificate = certificate_of(table, excluded)
    verdict = check(certificate)
    write_certificate(certificate, Path(path))
    return verdict


def certificate_of(table: Table, excluded: Sequence[Box] | None = None) -> Certificate:
    """The certificate of the front of a study; see ``certify``."""
    if not table.objectives:
        raise CertificateError("the study has no objectives, so it has no front", hint="name objectives")
    space = table.decisions
    claims = Claims(table, table.excluded if excluded is None else excluded)
    if len(claims.designs) > MAX_ROWS or len(claims.boxes) > MAX_BOXES:
        most = f"a certificate has at most {MAX_ROWS:,} designs one by one, and {MAX_BOXES:,} boxes"
        raise CertificateError(most, hint="certify a part of the study, by --set or --axis")
    given = claims.columns
    definition = _definition(table, claims)
    head = Head(
        format="hwsw certificate",
        version=1,
        rows=len(claims.designs),
        boxes=len(claims.boxes),
        reasons=len(claims.reasons.held),
        parts=[{axis: list(numbers) for axis, numbers in box.axes.items()} for box in space.parts],
        tasks=claims.tasks,
        names=claims.reasons.names,
        texts=claims.texts.texts,
    )
    columns = {
        name: np.ascontiguousarray(given[name], kind).reshape(shape)
        for name, (kind, shape) in layout(definition, head).items()
    }
    return Certificate.of(definition, head, columns)


def differences(certificate: Certificate, table: Table, excluded: Sequence[Box] | None = None) -> list[str]:
    """In what a certificate is not that of a study; nothing where they are equal."""
    own, its = certificate_of(table, excluded), certificate
    heads = [json.loads(each.texts[0]) | json.loads(each.texts[1]) for each in (own, its)]
    texts = [name for name, value in heads[0].items() if value != heads[1][name]]
    columns = [
        f"column {name}"
        for name, column in own.columns.items()
        if not np.array_equal(column, its.columns[name], equal_nan=column.dtype.kind == "f")
    ]
    return texts or columns or ([] if own.digests == its.digests else ["text"])


def _definition(table: Table, claims: Claims) -> Definition:
    """What the study is of, and what for."""
    space, figures = table.decisions, claims.figures
    numbers = {axis: [*map(value_text, values)] for axis, values in space.axes.items()}
    document: dict[str, Any] = {
        "platform": table.platform,
        "workload": table.workload,
        "axes": [
            {
                "axis": axis,
                "values": list(values),
                "when": {
                    other: [numbers[other].index(value_text(value)) for value in held]
                    for other, held in space.when.get(axis, {}).items()
                },
            }
            for axis, values in space.axes.items()
        ],
        "conditions": [{"axis": axis, "values": list(values)} for axis, values in table.conditions.items()],
        "aggregate": {name: rule_as_written(rule) for name, rule in table.aggregate.items()},
        "derived": {name: figure.as_written for name, figure in table.figures.items()},
        "figures": [
            {"name": figure.name, "unit": figure.unit, "best": "greatest" if table.world.maximise(figure) else "least"}
            for figure in figures
        ],
        "objectives": [
            {"figure": figures.index(figure), "direction": "maximise" if table.world.maximise(figure) else "minimise"}
            for figure in table.objectives
        ],
        "constraints": [
            {
                "figure": figures.index(limit.figure),
                "bound": limit.bound,
                "limit": limit.value,
                "budget": claims.budgets.index(limit.of_part) if limit.of_part else None,
            }
            for limit in claims.limits
        ],
        "budgets": [limit.figure.name for limit in claims.budgets],
        "identity": dict(table.specs.identity) if table.specs else {},
        "contents": {axis: dict(own) for axis, own in table.specs.contents.items()} if table.specs else {},
    }
    return Definition.model_validate(document)
