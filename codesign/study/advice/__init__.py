"""Advice: one question about a map, one verdict about boards.

``advise`` searches every planner, style and placement on every board, and names the board of least cost that meets all
needs, with the reason why the cheaper ones do not.

The stages, one module each: ``needs`` (the question), ``boards`` (the catalogue), ``candidates`` (the designs of a
board), ``trials`` (what a design comes to), ``cache`` (trials kept on disk), ``search`` (which designs are tried, in
which order), ``shortfalls`` (a design against the needs), ``answer`` (boards side by side), ``certainty`` (how sure it
is), ``sentence`` (the verdict in words), ``files`` (the winner as a file).

Of the designs that suffice on a board, the simplest is named: software before a circuit, a circuit before a split. The
board costs the same with each of them. The fastest stands beside it.

Mean power, not power while planning, is held against ``--power``: a battery sees the mean.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from more_itertools import map_reduce

from codesign.ground.errors import RunError
from codesign.ground.files import cache_folder, kept_folder
from codesign.study.advice.answer import Advice, BoardAdvice, Design, advice_schema, cheaper_than, judged, met_alone
from codesign.study.advice.boards import Board, boards_of
from codesign.study.advice.cache import kept_trials
from codesign.study.advice.candidates import Candidate
from codesign.study.advice.certainty import Certainty, certainty_of
from codesign.study.advice.files import command_of, design_file, write_design
from codesign.study.advice.needs import Needs, Question, ask, parse_needs, problem_section
from codesign.study.advice.search import BUDGET_S, Findings, Progress, search
from codesign.study.advice.sentence import verdict
from codesign.study.advice.trials import Laboratory, trial_of

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
    "parse_needs",
    "problem_section",
]


def advise(
    question: Question,
    boards: Sequence[Board],
    *,
    write: Path | None = None,
    budget_s: float = BUDGET_S,
    progress: Progress = lambda _done, _total: None,
) -> Advice:
    """Answer a question about boards.

    ``write``: the folder for the workload of the winner; by default it is written into the cache. ``budget_s``: see
    ``search``.

    Raises:
        RunError: the workload of the winner cannot be written into ``write``.
    """
    laboratory = Laboratory(question)
    with kept_trials() as (store, remark):
        findings = search(laboratory, boards, store, budget_s=budget_s, progress=progress)
    needs = question.needs
    advice, best = judged(boards, findings, needs)
    winner = advice[0] if advice[0].suffices else None
    command, certainty, next_certainty, unkept = None, None, None, ""
    if winner is not None:
        candidate = best[winner.board]
        certainty = _confirmed(laboratory, candidate, winner.design)
        try:
            folder = kept_folder("advice", laboratory.key(candidate)[:12]) if write is None else write
            file = write_design(candidate, question, folder, portable=write is not None)
            command = command_of(candidate, file)
        except (RunError, OSError) as fault:
            if write is not None:
                raise
            why = fault.what if isinstance(fault, RunError) else fault.strerror
            unkept = f"the winner's workload is not kept (--write FOLDER writes it): {why}"
        next_certainty = _of_next(laboratory, best, cheaper_than(winner, advice))
    return Advice(
        verdict=verdict(
            advice, needs, met_alone(boards, findings, needs), certainty, next_certainty, complete=not findings.left
        ),
        certainty=certainty,
        next_certainty=next_certainty,
        needs=needs,
        rows=question.problem.rows,
        columns=question.problem.columns,
        free_cells=int(question.problem.free.sum()),
        reach=question.problem.reach,
        starts=len(question.problem.starts),
        recommended=None if winner is None else winner.board,
        boards=tuple(advice),
        not_searched=_left(findings),
        remarks=tuple(text for text in (*question.grid.remarks, *laboratory.failures[:1], remark, unkept) if text),
        simulated=findings.simulated,
        kept=findings.kept,
        command=command,
    )


def _confirmed(laboratory: Laboratory, candidate: Candidate, design: Design | None) -> Certainty:
    """The certainty of the recommendation, by a run of its design, which has to come to the figures of its trial.

    Raises:
        RunError: it comes to others.
    """
    result = laboratory.result(candidate)
    assert design is not None, "a board suffices by a design"
    kept = {key: getattr(design.trial, key) for key in ("clock_hz", "time_low_s")}
    trial = trial_of(result).model_copy(update=kept)
    if trial != design.trial:
        raise RunError(
            f"the run of {candidate.board.name} does not come to the figures of its trial",
            str(cache_folder()),
            "remove this folder, and report it",
        )
    return certainty_of(result, candidate.board, laboratory.question.needs)


def _of_next(laboratory: Laboratory, best: Mapping[str, Candidate], cheaper: Sequence[BoardAdvice]) -> Certainty | None:
    """The certainty that the next cheaper board does not suffice; None if that is no matter of its figures."""
    if not cheaper or {short.need for short in cheaper[0].shortfalls} != {"rate"}:
        return None
    candidate = best[cheaper[0].board]
    return certainty_of(laboratory.result(candidate), candidate.board, laboratory.question.needs)


def _left(findings: Findings) -> tuple[str, ...]:
    """What the budget did not reach: planner, style and precision, with the boards."""

    def what(candidate: Candidate) -> str:
        bits = f" at {candidate.bits} bits and more" if candidate.bits else ""
        return f"{candidate.planner.name} ({candidate.style.style}){bits}"

    boards_of = map_reduce(findings.left, what, lambda candidate: candidate.board.name)
    return tuple(f"{left} on {', '.join(sorted(set(boards)))}" for left, boards in sorted(boards_of.items()))
