"""The certificate of an answer about boards: why no cheaper board suffices, for a reader who simulates nothing.

It states, for every board that the answer is about, each family of designs with the reason why it is left out, and
each design that was simulated with what it falls short of. The checker holds each reason against its own numbers,
and the families against the space: every tile of an array is in one of them. What the numbers rest on (cycles, clocks,
demands) is taken on trust: it follows from the laws that the certificate names by the digest of the code.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from more_itertools import map_reduce
from pydantic import Field

from codesign.ground.errors import RunError
from codesign.ground.files import is_special, write_atomically
from codesign.inputs import list_platforms, load_platform
from codesign.maps.grid import MAX_CELLS
from codesign.study.advice.answer import Advice
from codesign.study.advice.candidates import Board, arrangements_of
from codesign.study.advice.certainty import shortfalls_of
from codesign.study.advice.needs import Needs, Question
from codesign.study.advice.search import COUNTS, Extent, Findings, Settled
from codesign.study.advice.trials import Shortfall
from codesign.study.identity import code_digest
from codesign.study.space import canonical
from codesign.system.results.model import ResultModel

MOST_BYTES = 256 * 2**20
"""A larger file is no certificate."""

_ROUNDING = 1e-9
"""Relative: sums of floats in another order may be off by so much."""


class Tried(ResultModel):
    """A design that was simulated and does not suffice, or of the recommended board: that does."""

    mapping: dict[str, dict[str, Any]] = Field(description="the mapping of its workload")
    settings: dict[str, str] = Field(description="axes of the platform that are set")
    time_s: float | None = Field(description="time of a plan, the worst over the starts tried, s")
    shortfalls: tuple[Shortfall, ...] = Field(description="the needs that it does not meet")


class OfBoard(ResultModel):
    """A board that costs less than the recommended one, with all that was searched on it."""

    board: str = Field(description="name of the platform")
    price_usd: float | None = Field(description="its price, USD")
    searched: Extent = Field(description="its designs by what became of them")
    excluded: Shortfall | None = Field(
        description="the need that no design on it meets; None: it depends on the design"
    )
    settled: tuple[Settled, ...] = Field(description="its families of designs")
    tried: tuple[Tried, ...] = Field(description="its designs that were simulated")


class Certificate(ResultModel):
    """The certificate of an answer."""

    kind: Literal["advice certificate"] = Field(default="advice certificate", description="what the file is")
    schema_version: Literal[1] = Field(default=1, description="version of this form")
    question: str = Field(description="the question as it was understood")
    problem: str = Field(description="SHA-256 over map, goals and starts")
    code: str = Field(description="SHA-256 over the code and the figures that the numbers rest on")
    needs: Needs = Field(description="what was asked for")
    rows: int = Field(description="rows of the map that is planned on", ge=1)
    columns: int = Field(description="columns of it", ge=1)
    recommended: str | None = Field(description="the board that is recommended; None where none suffices")
    price_usd: float | None = Field(description="its price, USD")
    winner: Tried | None = Field(description="its design")
    state: Literal["proved", "at own values", "not proved"] = Field(description="what is stated; see the answer")
    prices_usd: dict[str, float | None] = Field(description="the price of each board that was asked about, USD")
    beyond: tuple[str, ...] = Field(description="designs that it says nothing of, by planner and style")
    boards: tuple[OfBoard, ...] = Field(description="the boards that the statement is about")
    digest: str = Field(default="", description="SHA-256 over all of this but itself")

    @property
    def content(self) -> str:
        """The digest that it should have."""
        return hashlib.sha256(canonical(self.model_dump(mode="json", exclude={"digest"})).encode()).hexdigest()


def certificate_of(advice: Advice, question: Question, findings: Findings, about: Sequence[str]) -> Certificate:
    """The certificate of an answer. ``about``: the names of the boards that the statement is about."""
    boards = {board.board: board for board in advice.boards}
    best = boards.get(advice.recommended or "")
    winner = None
    if best is not None and best.design is not None:
        design = best.design
        winner = Tried(mapping=design.mapping, settings=design.settings, time_s=design.trial.time_s, shortfalls=())
    certificate = Certificate(
        question=advice.question,
        problem=question.problem.digest,
        code=code_digest(),
        needs=advice.needs,
        rows=advice.rows,
        columns=advice.columns,
        recommended=advice.recommended,
        price_usd=None if best is None else best.price_usd,
        winner=winner,
        state=advice.proof.state,
        beyond=advice.proof.beyond,
        prices_usd={name: board.price_usd for name, board in boards.items()},
        boards=tuple(
            OfBoard(
                board=name,
                price_usd=boards[name].price_usd,
                searched=boards[name].searched,
                excluded=findings.excluded.get(name, (None,))[0],
                settled=tuple(findings.settled[name]),
                tried=tuple(
                    Tried(
                        mapping={task: dict(mapped) for task, mapped in candidate.mapping.items()},
                        settings=dict(candidate.settings),
                        time_s=trial.time_s,
                        shortfalls=shortfalls_of(trial, candidate.board, advice.needs),
                    )
                    for candidate, trial in findings.tried[name]
                ),
            )
            for name in about
        ),
    )
    # Through JSON: a digest is of what a reader of the file sees.
    certificate = Certificate.model_validate_json(certificate.model_dump_json())
    return certificate.model_copy(update={"digest": certificate.content})


def write_certificate(certificate: Certificate, path: Path) -> None:
    """Write a certificate, completely or not at all, after the checker has accepted it.

    Raises:
        RunError: the checker refuses it; it cannot be written.
    """
    faults = list(faults_of(certificate))
    if faults:
        raise RunError(f"the checker refuses the certificate: {faults[0]}", str(path), "report it, with the question")
    write_atomically(path, certificate.model_dump_json(indent=1).encode())


def read_certificate(path: Path) -> Certificate:
    """Read a certificate.

    Raises:
        RunError: the file is none, too large, or its digest is not of its content.
    """
    hint = "hwsw advise --certify FILE writes one"
    try:
        if is_special(path):
            raise RunError("is no regular file", str(path), hint)
        if path.stat().st_size > MOST_BYTES:
            raise RunError(f"larger than {MOST_BYTES // 2**20} MiB", str(path), hint)
        certificate = Certificate.model_validate_json(path.read_bytes())
        content = certificate.content
    except OSError as fault:
        raise RunError(f"cannot be read: {fault.strerror}", str(path), hint) from None
    # A ValueError of the digest: NaN and infinity have none.
    except (ValueError, RecursionError):
        raise RunError("no certificate of an answer about boards", str(path), hint) from None
    if certificate.digest != content:
        raise RunError("its digest is not of its content: the file was changed", str(path), "ask for it again")
    return certificate


def faults_of(certificate: Certificate) -> Iterator[str]:
    """Every step of a certificate that does not follow from its own numbers; none: it is accepted."""
    if not 0 < certificate.needs.rate_hz < math.inf:
        yield "it asks for no rate"
        return
    if certificate.rows * certificate.columns > MAX_CELLS:
        yield f"its map has more than {MAX_CELLS:,} cells"
        return
    period, winner = certificate.needs.period_s, certificate.winner
    if (winner is None) != (certificate.recommended is None):
        yield "it has a recommended board without a design, or the other way round"
    if winner is not None and (winner.time_s is None or winner.time_s > period or winner.shortfalls):
        yield f"{certificate.recommended} does not suffice by its own figures"
    held = {board.board for board in certificate.boards}
    for name, price in certificate.prices_usd.items():
        cheaper = certificate.price_usd is not None and price is not None and price < certificate.price_usd
        if name not in held and (certificate.recommended is None or cheaper):
            yield f"{name} costs less, and nothing is stated about it"
    for board in certificate.boards:
        if _costs_more(board, certificate):
            yield f"{board.board} does not cost less than {certificate.recommended}"
        yield from _faults_of(board, certificate, period)


def _costs_more(board: OfBoard, certificate: Certificate) -> bool:
    if certificate.recommended is None or certificate.price_usd is None:
        return False
    return board.price_usd is None or board.price_usd >= certificate.price_usd


def _faults_of(board: OfBoard, certificate: Certificate, period: float) -> Iterator[str]:
    short = board.excluded
    if short is None:
        yield from _faults_of_designs(board, certificate, period)
    elif short.demand is not None and short.demand <= short.limit:
        yield f"{board.board} meets the need that is said to exclude it: {short.need}"


def _faults_of_designs(board: OfBoard, certificate: Certificate, period: float) -> Iterator[str]:
    counts = map_reduce(board.settled, lambda each: each.state, lambda each: each.designs, sum)
    if any(counts.get(state, 0) != getattr(board.searched, state) for state in COUNTS):
        yield f"{board.board}: its counts are not of its families"
    claimed = certificate.state != "not proved"
    if claimed and (not board.searched.complete or "left" in counts):
        yield f"{board.board}: designs are left, so nothing is proved of it"
    for each in board.settled:
        what = f"{board.board}: {each.planner} ({each.style}) {json.dumps(each.least, default=str)}"
        if each.state == "unfit" and not (each.demand or 0.0) > (math.inf if each.budget is None else each.budget):
            yield f"{what} fits: {each.resource} {each.demand} of {each.budget}"
        if each.state in ("bound", "counted"):
            if each.time_s is None or each.time_s <= period:
                yield f"{what} is not excluded by its bound"
            elif not _follows(each, each.time_s):
                yield f"{what}: its time does not follow from its units"
            elif each.sure and not (each.least_s or 0.0) > period:
                yield f"{what} is excluded at the figures' own values only"
        if certificate.state == "proved" and each.state not in ("tried", "left") and not each.sure:
            yield f"{what} is excluded at the figures' own values only"
    for design in board.tried:
        if not any(_is_short(short, design, period) for short in design.shortfalls):
            yield f"{board.board}: {json.dumps(design.mapping, default=str)} falls short of nothing"
    if claimed:
        yield from _uncovered(board, certificate)
        yield from _missing(board, certificate)


def _follows(each: Settled, time_s: float) -> bool:
    """True if the bound of a family is no more than its units at their rates, and the map on its link."""
    if "" in each.units and not math.isclose(each.unit_s.get("", 0.0) * (each.clock_hz or 0.0), 1.0, rel_tol=_ROUNDING):
        return False
    least = sum(amount * each.unit_s.get(unit, 0.0) for unit, amount in each.units.items()) + each.map_s
    return time_s <= least * (1 + _ROUNDING)


def _missing(board: OfBoard, certificate: Certificate) -> Iterator[str]:
    """The arrangements of a shipped board that the certificate says nothing about."""
    if board.board not in list_platforms() or certificate.state == "not proved":
        return
    held = set(map(_arrangement, board.settled))
    for each in arrangements_of(Board(board.board, load_platform(board.board)), None, certificate.needs):
        apart, memory = tuple(sorted(each.placed.apart.items())), each.placed.memory
        if (each.planner.name, each.style.style, each.component, apart, memory) not in held:
            yield f"{board.board}: nothing is stated about {each.planner.name} ({each.style.style})"


def _arrangement(each: Settled) -> tuple[str, str, str, tuple[tuple[str, str], ...], str | None]:
    return each.planner, each.style, each.component, tuple(sorted(each.apart.items())), each.memory


def _is_short(short: Shortfall, design: Tried, period: float) -> bool:
    """True if the demand of a shortfall passes its limit."""
    if short.need == "rate":
        return design.time_s is not None and design.time_s > period
    if short.demand is None:
        return True
    if short.need == "figure":
        return short.demand <= short.limit if short.lower else short.demand >= short.limit
    return short.demand < short.limit if short.lower else short.demand > short.limit


TILE = "tile rows", "tile columns"
"""The names of the ranges that tiles of a map are stated by."""


def _uncovered(board: OfBoard, certificate: Certificate) -> Iterator[str]:
    """The arrangements whose families do not hold every tile of the map."""
    tiled = [each for each in board.settled if set(TILE) <= set(each.ranges)]
    for (planner, style, *_), families in map_reduce(tiled, _arrangement).items():
        held = np.zeros((certificate.rows + 1, certificate.columns + 1), np.bool_)
        for each in families:
            (top, bottom), (left, right) = (each.ranges[name] for name in TILE)
            held[top : bottom + 1, left : right + 1] = True
        if not held[1:, 1:].all():
            row, column = map(int, np.argwhere(~held[1:, 1:])[0] + 1)
            yield f"{board.board}: {planner} ({style}) with tiles of {row} × {column} cells is in no family"
