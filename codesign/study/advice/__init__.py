"""Advice: one question about a map, one verdict about boards.

``advise`` searches every planner, style and placement on every board, and names the board of least cost that meets all
needs, with the reason why the cheaper ones do not.

The stages, one module each: ``motion`` (from a speed to a rate), ``needs`` (the question), ``candidates`` (the designs
of a board), ``trials`` (what a design comes to, and which are tried), ``answer`` (boards side by side), ``certainty``
(how sure it is), ``sentence`` (the verdict in words).

Of the designs that suffice on a board, the simplest is named: software before a circuit, a circuit before a split. The
board costs the same with each of them. The fastest stands beside it.

Mean power, not power while planning, is held against ``--power``: a battery sees the mean.
"""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import yaml

from codesign.ground.errors import CodesignError, RunError, StoreError
from codesign.ground.files import cache_folder, kept_folder, write_atomically
from codesign.ground.records import Listener
from codesign.study.advice.answer import (
    Advice,
    BoardAdvice,
    Design,
    advice_schema,
    cheapest,
    distance,
    driven_with,
    judged,
    met_alone,
    proof_of,
)
from codesign.study.advice.candidates import Board, Candidate, boards_of, is_file, price_remarks
from codesign.study.advice.certainty import Certainty, certainty_of
from codesign.study.advice.certificate import certificate_of, write_certificate
from codesign.study.advice.motion import Driven, driven_text, parse_motion
from codesign.study.advice.needs import Needs, Question, ask, limited, parse_needs, problem_section, workload_tree
from codesign.study.advice.search import BUDGET_S, Progress, search
from codesign.study.advice.sentence import verdict
from codesign.study.advice.trials import Laboratory, trial_of
from codesign.study.store import FileStore, MemoryStore, Store

# The workload of a design as a file, and the command that runs it.


def write_design(candidate: Candidate, question: Question, folder: Path, *, portable: bool) -> Path:
    """Write the workload of a design into ``folder``, which is made if it is missing.

    ``portable``: the path of the map is relative to the folder, so that both can be moved together.

    Raises:
        RunError: the folder cannot be written to.
    """
    section = dict(question.section)
    if portable:
        file = os.path.relpath(section["map"]["file"], folder.resolve())
        section["map"] = {**section["map"], "file": file}
    tree = workload_tree(candidate.planner.name, section, candidate.mapping)
    # YAML has no tuples, which samples of plug-ins may hold.
    plain = json.loads(json.dumps(tree))
    text = f"# {_first_line(candidate)}\n{yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise RunError(f"cannot make the folder: {fault.strerror}", str(folder), "name another") from fault
    path = design_file(folder, candidate.board)
    write_atomically(path, text.encode())
    return path


def design_file(folder: Path, board: Board) -> Path:
    """The workload of a design for a board, in ``folder``."""
    return folder / f"{board.name}.yaml"


def command_of(candidate: Candidate, workload: Path) -> str:
    """The command that runs a design, quoted for a shell."""
    board = candidate.board
    source = str(board.source) if is_file(board) else board.name
    words = ["hwsw", "run", source, str(workload)]
    return shlex.join([*words, *_settings(candidate.settings)])


def _settings(settings: Mapping[str, Any]) -> list[str]:
    return [word for axis, value in settings.items() for word in ("--set", f"{axis}={value}")]


def _first_line(candidate: Candidate) -> str:
    return f"The design that hwsw advise chose for {candidate.board.name}."


# The cache of trials: a second question about a map takes what the first one computed.

MOST_BYTES = 64 * 2**20
"""A larger file is removed before the next question. It holds some 100,000 trials."""


@contextmanager
def kept_trials() -> Iterator[tuple[Store, str]]:
    """The cache until the end of the block, with a remark where it cannot be used: then nothing is kept."""
    store: Store = MemoryStore()
    remark = ""
    path = cache_folder() / "advice.sqlite"
    try:
        kept_folder()
        if path.exists() and path.stat().st_size > MOST_BYTES:
            path.unlink()
        store = FileStore(path)
    except (StoreError, OSError) as fault:
        why = fault.what if isinstance(fault, StoreError) else fault.strerror
        remark = f"no trial is kept for a second question: {path}: {why}"
    try:
        yield store, remark
    finally:
        with suppress(StoreError):
            store.close()


__all__ = [
    "BUDGET_S",
    "Advice",
    "Needs",
    "Question",
    "advice_schema",
    "advise",
    "ask",
    "boards_of",
    "design_file",
    "limited",
    "parse_motion",
    "parse_needs",
    "problem_section",
]


def advise(
    question: Question,
    boards: Sequence[Board],
    *,
    write: Path | None = None,
    certificate: Path | None = None,
    budget_s: float = BUDGET_S,
    progress: Progress = lambda _done, _total: None,
    listeners: Sequence[Listener] = (),
) -> Advice:
    """Answer a question about boards.

    ``write``: the folder for the workload of each board's best design; by default that of the winner is written into
    the cache. ``certificate``: the file for the certificate. ``budget_s``: see ``search``. ``listeners`` take the
    records of the winner's run.

    Raises:
        RunError: a workload cannot be written into ``write``, or the certificate.
    """
    laboratory = Laboratory(question)
    with kept_trials() as (store, remark):
        findings = search(laboratory, boards, store, budget_s=budget_s, progress=progress)
    needs = question.needs
    advice, best = judged(boards, findings, needs)
    winner = advice[0] if advice[0].suffices else None
    certainty, unkept = None, ""
    if winner is not None:
        certainty = _confirmed(laboratory, best[winner.board], winner.design, listeners)
    try:
        advice = _written(laboratory, advice, best, write)
    except (RunError, OSError) as fault:
        if write is not None:
            raise
        why = fault.what if isinstance(fault, RunError) else fault.strerror
        unkept = f"the winner's workload is not kept (--write FOLDER writes it): {why}"
    proof, about = proof_of(winner, advice, findings)
    # A board whose chip has no work is its computer at a higher price.
    near = min(about, key=lambda each: (each.under is not None, distance(each)), default=None)
    witness = None if near is None else (near, _certainty(laboratory, best.get(near.board)))
    texts = (*question.grid.remarks, *laboratory.failures[:1], needs.remark, remark, unkept, *price_remarks(boards))
    driven = driven_with(advice, needs.motion)
    by_price = None if winner is None else cheapest(winner, advice)
    answer = Advice(
        question=str(question),
        verdict=verdict(advice, needs, met_alone(boards, findings, needs), certainty, proof, witness, by_price),
        driving=_driving(needs, driven, winner),
        certainty=certainty,
        witness=None if near is None else near.board,
        witness_certainty=None if witness is None else witness[1],
        cheapest=by_price,
        proof=proof,
        needs=needs,
        goals=question.goals,
        cell_m=question.grid.resolution,
        rows=question.problem.rows,
        columns=question.problem.columns,
        free_cells=int(question.problem.free.sum()),
        reach=question.problem.reach,
        starts=len(question.problem.starts),
        recommended=None if winner is None else winner.board,
        boards=tuple(advice),
        driven=driven,
        not_searched=tuple(f"{each.searched.left:,} or more on {each.board}" for each in about if each.searched.left),
        remarks=tuple(text for text in texts if text),
        simulated=findings.simulated,
        kept=findings.kept,
        command=None if winner is None else advice[0].command,
    )
    if certificate is not None:
        names = [board.board for board in about]
        write_certificate(certificate_of(answer, question, findings, names), certificate)
    return answer


def _driving(needs: Needs, driven: Mapping[str, Driven], winner: BoardAdvice | None) -> str:
    """The speed with the winner; without one, with the board that is fastest."""
    if needs.motion is None or not driven:
        return ""
    best = winner.board if winner else max(driven, key=lambda board: driven[board].speed_mps)
    return driven_text(needs.motion, best, driven[best])


def _written(
    laboratory: Laboratory, advice: Sequence[BoardAdvice], best: Mapping[str, Candidate], write: Path | None
) -> list[BoardAdvice]:
    """The boards with the files of their best designs: of all into ``write``, or of the winner into the cache."""
    each = []
    for number, board in enumerate(advice):
        candidate = best.get(board.board)
        if candidate is None or (write is None and (number or not board.suffices)):
            each.append(board)
            continue
        folder = kept_folder("advice", laboratory.key(candidate)[:12]) if write is None else write
        file = write_design(candidate, laboratory.question, folder, portable=write is not None)
        each.append(board.model_copy(update={"workload": str(file), "command": command_of(candidate, file)}))
    return each


def _confirmed(
    laboratory: Laboratory, candidate: Candidate, design: Design | None, listeners: Sequence[Listener]
) -> Certainty:
    """The certainty of the recommendation, by a run of its design, which has to come to the figures of its trial.

    Raises:
        RunError: it comes to others.
    """
    result = laboratory.result(candidate, listeners)
    assert design is not None, "a board suffices by a design"
    if trial_of(result) != design.trial:
        raise RunError(
            f"the run of {candidate.board.name} does not come to the figures of its trial",
            str(cache_folder()),
            "remove this folder, and report it",
        )
    return certainty_of(result, candidate.board, laboratory.question.needs)


def _certainty(laboratory: Laboratory, candidate: Candidate | None) -> Certainty | None:
    """The certainty of a design that was tried; None where it is refused."""
    try:
        if candidate is None:
            return None
        return certainty_of(laboratory.result(candidate), candidate.board, laboratory.question.needs)
    except CodesignError:
        return None
