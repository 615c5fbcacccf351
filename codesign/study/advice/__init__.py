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
from more_itertools import map_reduce

from codesign.ground.errors import RunError, StoreError
from codesign.ground.files import cache_folder, kept_folder, write_atomically
from codesign.ground.records import Listener
from codesign.study.advice.answer import (
    Advice,
    BoardAdvice,
    Design,
    advice_schema,
    cheaper_than,
    driven_with,
    judged,
    met_alone,
)
from codesign.study.advice.candidates import Board, Candidate, boards_of, is_file, price_remarks
from codesign.study.advice.certainty import Certainty, certainty_of
from codesign.study.advice.motion import Driven, driven_text, parse_motion
from codesign.study.advice.needs import Needs, Question, ask, parse_needs, problem_section, workload_tree
from codesign.study.advice.sentence import verdict
from codesign.study.advice.trials import BUDGET_S, Findings, Laboratory, Progress, search, trial_of
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
    "parse_motion",
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
    listeners: Sequence[Listener] = (),
) -> Advice:
    """Answer a question about boards.

    ``write``: the folder for the workload of the winner; by default it is written into the cache. ``budget_s``: see
    ``search``. ``listeners`` take the records of the winner's run.

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
        certainty = _confirmed(laboratory, candidate, winner.design, listeners)
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
    texts = (*question.grid.remarks, *laboratory.failures[:1], needs.remark, remark, unkept, *price_remarks(boards))
    driven = driven_with(advice, needs.motion)
    return Advice(
        question=str(question),
        verdict=verdict(
            advice, needs, met_alone(boards, findings, needs), certainty, next_certainty, complete=not findings.left
        ),
        driving=_driving(needs, driven, winner),
        certainty=certainty,
        next_certainty=next_certainty,
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
        not_searched=_left(findings),
        remarks=tuple(text for text in texts if text),
        simulated=findings.simulated,
        kept=findings.kept,
        command=command,
    )


def _driving(needs: Needs, driven: Mapping[str, Driven], winner: BoardAdvice | None) -> str:
    """The speed with the winner; without one, with the board that is fastest."""
    if needs.motion is None or not driven:
        return ""
    best = winner.board if winner else max(driven, key=lambda board: driven[board].speed_mps)
    return driven_text(needs.motion, best, driven[best])


def _confirmed(
    laboratory: Laboratory, candidate: Candidate, design: Design | None, listeners: Sequence[Listener]
) -> Certainty:
    """The certainty of the recommendation, by a run of its design, which has to come to the figures of its trial.

    Raises:
        RunError: it comes to others.
    """
    result = laboratory.result(candidate, listeners)
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
    """The chains that the budget did not reach: planner, style and precision, with the boards."""

    def what(candidate: Candidate) -> str:
        bits = f" at {candidate.bits} bits and more" if candidate.bits else ""
        return f"{candidate.planner.name} ({candidate.style.style}){bits}"

    boards_of = map_reduce(findings.left, what, lambda candidate: candidate.board.name)
    return tuple(f"{left} on {', '.join(sorted(set(boards)))}" for left, boards in sorted(boards_of.items()))
