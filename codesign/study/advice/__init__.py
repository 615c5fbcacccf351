"""Advice: one question about a map, one verdict about boards.

``advise`` searches every planner, style and placement on every board, and names the board of least cost that meets all
needs, with the reason why the cheaper ones do not.

The stages, one module each: ``motion`` (from a speed to a rate), ``needs`` (the question), ``candidates`` (the designs
of a board), ``trials`` (what a design comes to, and which are tried), ``answer`` (boards side by side), ``certainty``
(how sure it is), ``sentence`` (the verdict in words), ``way_on`` (its designs as files, and the commands for them).

Of the designs that suffice on a board, the simplest is named: software before a circuit, a circuit before a split. The
board costs the same with each of them. The fastest stands beside it.

Mean power, not power while planning, is held against ``--power``: a battery sees the mean.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from codesign.ground.errors import CodesignError, RunError, StoreError
from codesign.ground.files import cache_folder, kept_folder
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
from codesign.study.advice.candidates import Board, Candidate, boards_of, price_remarks
from codesign.study.advice.certainty import Certainty, certainty_of
from codesign.study.advice.certificate import certificate_of, write_certificate
from codesign.study.advice.motion import Driven, driven_text, parse_motion
from codesign.study.advice.needs import Needs, Question, ask, limited, parse_needs, problem_section
from codesign.study.advice.search import BUDGET_S, Progress, search
from codesign.study.advice.sentence import verdict
from codesign.study.advice.trials import Laboratory, trial_of
from codesign.study.advice.way_on import (
    COMMANDS,
    WayOn,
    best_circuits,
    command_of,
    files_of,
    mission_remark,
    write_design,
)
from codesign.study.store import FileStore, MemoryStore, Store

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
    "COMMANDS",
    "Advice",
    "Needs",
    "Question",
    "advice_schema",
    "advise",
    "ask",
    "boards_of",
    "files_of",
    "limited",
    "parse_motion",
    "parse_needs",
    "problem_section",
    "write_design",
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

    ``write``: the folder for the files of ``WayOn``; by default the workload of the winner is written into the cache.
    ``certificate``: the file for the certificate. ``budget_s``: see ``search``. ``listeners`` take the
    records of the winner's run.

    Raises:
        RunError: a file cannot be written into ``write``, or the certificate.
    """
    laboratory = Laboratory(question)
    with kept_trials() as (store, remark):
        findings = search(laboratory, boards, store, budget_s=budget_s, progress=progress)
        circuits = {} if write is None else best_circuits(laboratory, boards, findings, store, budget_s)
    needs = question.needs
    advice, best = judged(boards, findings, needs)
    winner = advice[0] if advice[0].suffices else None
    certainty, unkept = None, ""
    if winner is not None:
        certainty = _confirmed(laboratory, best[winner.board], winner.design, listeners)
    driven = driven_with(advice, needs.motion)
    way = None if write is None else WayOn(laboratory, write, circuits)
    if way is not None:
        advice = [way.of(row, best.get(row.board), driven.get(row.board)) for row in advice]
    elif winner is not None:
        advice[0], unkept = _kept(laboratory, advice[0], best[winner.board])
    proof, about = proof_of(winner, advice, findings)
    # A board whose chip has no work is its computer at a higher price.
    near = min(about, key=lambda each: (each.under is not None, distance(each)), default=None)
    witness = None if near is None else (near, _certainty(laboratory, best.get(near.board)))
    about_it = (needs.remark, remark, unkept, *price_remarks(boards), mission_remark(needs, advice))
    texts = (*question.grid.remarks, *laboratory.failures[:1], *about_it)
    by_price = None if winner is None else cheapest(winner, advice, boards)
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
    if way is not None:
        way.write(answer)
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


def _kept(laboratory: Laboratory, winner: BoardAdvice, candidate: Candidate) -> tuple[BoardAdvice, str]:
    """The winner with the file of its best design in the cache; or as it is, with a remark on why there is none."""
    try:
        folder = kept_folder("advice", laboratory.key(candidate)[:12])
        file = write_design(candidate, laboratory.question, folder)
    except (RunError, OSError) as fault:
        why = fault.what if isinstance(fault, RunError) else fault.strerror
        return winner, f"the winner's workload is not kept (--write FOLDER writes it): {why}"
    return winner.model_copy(update={"workload": str(file), "command": command_of(candidate, file)}), ""


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
