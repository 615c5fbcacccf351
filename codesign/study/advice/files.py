"""The workload of a design as a file, and the command that runs it."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from codesign.ground.errors import RunError
from codesign.ground.files import write_atomically
from codesign.study.advice.boards import Board, is_file
from codesign.study.advice.candidates import Candidate
from codesign.study.advice.needs import Question, workload_tree


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
