"""The way on from an answer: the designs of its boards as files, and the commands that go on from there.

Each board gets its best design and its best circuit as workloads, and a mission with its best design. The robot of all
missions is the same, so they differ in the board alone. It is a point, as the plans of the answer are, and the robot of
a shipped platform in all else that was not asked.

A search ends on a board at the first design that suffices, and software comes first. So circuits are looked for once
more, for these files alone: no statement of the answer rests on it.
"""

from __future__ import annotations

import copy
import json
import os
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml

from codesign.ground.errors import CodesignError, InputError, RunError, SpecError, printable
from codesign.ground.files import write_atomically
from codesign.ground.units import PICOSECONDS_PER_SECOND, format_power
from codesign.hardware.calibrate.calibration import plain_yaml
from codesign.hardware.rtl.placed import placed, refuse_what_does_not_fit
from codesign.inputs import design_point, load_platform
from codesign.inputs.components import FpgaComponent, RobotComponent
from codesign.inputs.platform import state_behind
from codesign.inputs.yaml_tree import parse_document
from codesign.planners.interface import LOAD
from codesign.study.advice.answer import Advice, BoardAdvice, Design, design_of
from codesign.study.advice.candidates import Board, Candidate, is_file
from codesign.study.advice.certainty import amount, shortfalls_of
from codesign.study.advice.motion import Driven
from codesign.study.advice.needs import Needs, Question, workload_tree
from codesign.study.advice.search import Findings, Tried, order, search
from codesign.study.advice.sentence import design_text, shortfall_text, time_text
from codesign.study.advice.trials import Laboratory, Shortfall
from codesign.study.store import Store
from codesign.system import catalog
from codesign.system.bind import planner_code
from codesign.system.outcome import fit_system
from codesign.system.scenarios import bind

ANSWER, COMMANDS = "answer.json", "commands.sh"


_KINDS = {".yaml": "", "-circuit.yaml": "", "-mission.yaml": "", "-robot.yaml": "robot"}


def files_of(folder: Path, boards: Sequence[Board]) -> dict[Path, str]:
    """Every file that may be written into ``folder``, with its kind; "" of a workload.

    Raises:
        InputError: two boards would share a file.
    """
    files = {folder / ANSWER: "answer", folder / COMMANDS: "commands"}
    for board in boards:
        for ending, kind in _KINDS.items():
            path = folder / f"{board.name}{ending}"
            if path in files:
                raise InputError("two boards share this file", f"--write {path}", "give one of them another name:")
            files[path] = kind
    return files


def write_design(candidate: Candidate, question: Question, folder: Path) -> Path:
    """Write the workload of a design into ``folder``.

    Raises:
        RunError: the folder cannot be written to.
    """
    path = folder / f"{candidate.board.name}.yaml"
    write_all({path: _workload_text(candidate.board, _tree(candidate, question.section))})
    return path


def write_all(files: Mapping[Path, str]) -> None:
    """Write files into a folder, which is made if it is missing.

    Raises:
        RunError: the folder cannot be written to.
    """
    for path, text in files.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as fault:
            raise RunError(f"cannot make the folder: {fault.strerror}", str(path.parent), "name another") from fault
        write_atomically(path, text.encode("utf-8", "surrogateescape"))


def _tree(candidate: Candidate, section: Mapping[str, Any]) -> dict[str, Any]:
    return workload_tree(candidate.planner.name, section, candidate.mapping)


def _workload_text(board: Board, tree: Mapping[str, Any], folder: Path | None = None, what: str = "") -> str:
    """A workload as a file; the path of its map is relative to ``folder``, so that both can be moved together."""
    # YAML has no tuples, which samples of plug-ins may hold.
    plain = json.loads(json.dumps(tree))
    if folder is not None:
        section = plain["problem"]["map"]
        section["file"] = os.path.relpath(section["file"], folder.resolve())
    head = f"# The design that hwsw advise chose for {board.name}{what}."
    return f"{head}\n{yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)}"


def command_of(candidate: Candidate, workload: Path, *, word: str = "run", platform: Path | None = None) -> str:
    """The command that runs a design, quoted for a shell. ``platform``: a file in place of its board."""
    board = candidate.board
    source = str(platform) if platform else str(board.source) if is_file(board) else board.name
    settings = [word for axis, value in candidate.settings.items() for word in ("--set", f"{axis}={value}")]
    return shlex.join(["hwsw", word, source, str(workload), *settings])


# The best circuit of a board.

CIRCUITS_S = 10.0
"""Seconds of computing that circuits may take besides, where software suffices. Assumed."""


def best_circuits(
    laboratory: Laboratory, boards: Sequence[Board], findings: Findings, store: Store, budget_s: float
) -> dict[str, Tried]:
    """The best circuit that was tried on each board, by its name: it fits and its plans serve, whatever the needs."""
    question, tried = laboratory.question, findings.tried
    missing = [each for each in boards if each.platform.of(FpgaComponent)]
    missing = [each for each in missing if not any(map(_is_circuit, tried[each.name]))]
    if missing and question.needs.on is None:
        asked = Laboratory(replace(question, needs=question.needs.model_copy(update={"on": "fabric"})))
        tried = tried | search(asked, missing, store, budget_s=min(budget_s, CIRCUITS_S)).tried
    best = {board.name: _best_of(list(filter(_is_circuit, tried[board.name])), board, laboratory) for board in boards}
    return {name: circuit for name, circuit in best.items() if circuit is not None}


def _best_of(circuits: list[Tried], board: Board, laboratory: Laboratory) -> Tried | None:
    """The best of some circuits, tried from all starts: a search tries most from the farthest start alone."""
    while circuits:
        best = min(circuits, key=lambda each: order(each, board, laboratory.question.needs))
        if best[1].starts == len(laboratory.question.problem.starts):
            return best
        circuits.remove(best)
        circuits += filter(_is_circuit, [laboratory.trial(best[0])])
    return None


def _is_circuit(tried: Tried) -> bool:
    """True of a design with a task on an FPGA that fits and serves."""
    candidate, trial = tried
    components = candidate.board.platform.components
    in_fabric = any(components[mapped["component"]].chip is not None for mapped in candidate.mapping.values())
    return in_fabric and trial.time_s is not None and not trial.shortfalls


def _no_rtl(laboratory: Laboratory, candidate: Candidate) -> str:
    """The reason why ``hwsw rtl`` refuses a design; "" where it takes it."""
    try:
        with planner_code(candidate.planner):
            design = placed(*laboratory.point(candidate))
            refuse_what_does_not_fit(design)
            design.style.circuit(design.job)
    except CodesignError as refused:
        return _reason(refused)
    return ""


def _reason(refused: CodesignError) -> str:
    return refused.faults[0].what if isinstance(refused, SpecError) else refused.what


# The mission.

ROBOT_OF = "zynq"
"""The shipped platform whose robot drives, with its line, in all that was not asked."""

_ASKED = (("kinematics", "speed", "--speed"), ("sensor", "range", "--range"), ("kinematics", "acceleration", "--brake"))
"""The figures of the robot that a question may give: section, key and option."""


def _robot(needs: Needs, driven: Driven | None) -> tuple[dict[str, Any], dict[str, Any]]:
    """The raw robot of a mission and its line. ``driven``: the speed that it may drive with the board."""
    tree = copy.deepcopy(load_platform(ROBOT_OF).document.tree)
    robot, motion = tree["components"]["robot"], needs.motion
    asked, sources = {}, {option: f"asked for: {option}" for _, _, option in _ASKED}
    if motion is not None:
        asked = {"--range": f"{motion.sight_m:.9g} m", "--brake": f"{motion.brake_mps2:.9g} m/s^2"}
        allowed = motion.wanted_mps if driven is None else driven.speed_mps
        asked["--speed"] = f"{motion.speed_mps or allowed:.9g} m/s"
        if motion.speed_mps is None:
            sources["--speed"] = "not asked for; the speed that hwsw advise allows"
    for section, key, option in _ASKED:
        value, source = robot[section][key]["value"], f"not asked for; that of the robot of {ROBOT_OF}"
        if option in asked:
            value, source = asked[option], sources[option]
        robot[section][key] = {"value": value, "status": "assumed", "source": source}
    source = "a point, as the plans of hwsw advise are; --clearance grows the obstacles"
    robot["radius"] = {"value": "0 m", "status": "assumed", "source": source}
    return robot, tree["links"]["body"]


def mission_remark(needs: Needs, boards: Sequence[BoardAdvice]) -> str:
    """The figures of the missions' robot that nobody asked for; "" where no mission has such a robot."""
    if needs.motion is not None or not any(board.mission_command for board in boards):
        return ""
    robot = _robot(needs, None)[0]
    figures = ", ".join(f"{key} {robot[of][key]['value']} ({option})" for of, key, option in _ASKED)
    return f"Missions: assumed is the robot of {ROBOT_OF}: {figures}."


def _mission(
    laboratory: Laboratory, candidate: Candidate, driven: Driven | None, folder: Path
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The platform with a robot and the workload that drives it, as YAML has them; both were held against each other.

    Raises:
        CodesignError: such a mission cannot be.
    """
    question, board, motion = laboratory.question, candidate.board, laboratory.question.needs.motion
    places = bind(*laboratory.point(candidate), grid=question.grid).placement.places
    tree, origin = copy.deepcopy(board.platform.document.tree), board.platform.document.folder
    for name, raw in tree["components"].items():
        if {*state_behind(raw, origin)} != {*state_behind(raw, folder)}:
            raise InputError(f"{name} names a part, host or calibration beside the file of the board")
    robot, line = _robot(question.needs, driven)
    known = list(board.platform.of(RobotComponent))
    name = known[0] if known else _free("robot", tree)
    tree["components"][name] = robot
    if not known:
        tree["links"] = (tree.get("links") or {}) | {_free("body", tree): line | {"between": [places[LOAD], name]}}
    scenario: dict[str, Any] = {"type": "drive", "robot": name}
    if motion is not None and motion.sensor_hz:
        scenario["control_period"] = f"{round(PICOSECONDS_PER_SECOND / motion.sensor_hz)} ps"
    section = {key: value for key, value in question.section.items() if key not in ("task", "change")}
    section["starts"] = [list(question.problem.named(question.problem.starts[0]))]
    workload = _tree(candidate, section) | {"scenario": scenario}
    file = folder / f"{board.name}-robot.yaml"
    platform = load_platform(parse_document(plain_yaml(tree).encode(), str(file), folder))
    point = design_point(platform, catalog.load_workload(workload), candidate.settings)
    with planner_code(candidate.planner):
        reasons = fit_system(bind(*point, grid=question.grid)).reasons
    if reasons:
        first = reasons[0]
        raise InputError(f"it does not fit: {first.name} {first.demand:,.6g} against {first.limit:,.6g}")
    return tree, workload


def _free(name: str, tree: Mapping[str, Any]) -> str:
    """A name that no component or link of a platform has."""
    taken = {*tree["components"], *(tree.get("links") or {})}
    return next(each for each in (name, *(f"{name}_{i}" for i in range(len(taken) + 1))) if each not in taken)


# All of it.


@dataclass
class WayOn:
    """The files of an answer in ``folder``, and its boards with them. ``circuits``: see ``best_circuits``."""

    laboratory: Laboratory
    folder: Path
    circuits: Mapping[str, Tried]
    files: dict[Path, str] = field(default_factory=dict)

    def of(self, row: BoardAdvice, candidate: Candidate | None, driven: Driven | None) -> BoardAdvice:
        """A board with its files, which are added to ``files``. ``candidate``: its best design."""
        found: dict[str, Any] = {}
        if candidate is not None:
            found = self._design(candidate, "") | self._mission_of(row, candidate, driven)
        if row.board in self.circuits:
            found |= self._circuit_of(self.circuits[row.board], candidate)
        return row.model_copy(update=found)

    def _put(self, candidate: Candidate, tree: Mapping[str, Any], ending: str, what: str = "") -> Path:
        path = self.folder / f"{candidate.board.name}{ending}.yaml"
        self.files[path] = _workload_text(candidate.board, tree, self.folder, what)
        return path

    def _design(self, candidate: Candidate, ending: str, what: str = "", of: str = "") -> dict[str, Any]:
        path = self._put(candidate, _tree(candidate, self.laboratory.question.section), ending, what)
        return {f"{of}workload": str(path), f"{of}command": command_of(candidate, path)}

    def _circuit_of(self, tried: Tried, best: Candidate | None) -> dict[str, Any]:
        (candidate, trial), needs, board = tried, self.laboratory.question.needs, tried[0].board
        ending, what = ("", "") if candidate is best else ("-circuit", " among circuits")
        found = self._design(candidate, ending, what, "circuit_")
        found["circuit"] = design_of(tried, board, needs)
        found["circuit_shortfalls"] = shortfalls_of(trial, board, needs)
        found["no_rtl"] = _no_rtl(self.laboratory, candidate)
        if not found["no_rtl"]:
            command = command_of(candidate, Path(found["circuit_workload"]), word="rtl")
            found["rtl_command"] = f"{command} {shlex.join(['-o', str(self.folder / f'{board.name}-rtl')])}"
        return found

    def _mission_of(self, row: BoardAdvice, candidate: Candidate, driven: Driven | None) -> dict[str, Any]:
        try:
            if row.design is None or row.design.trial.time_s is None:
                raise InputError("its design cannot be run")
            tree, workload = _mission(self.laboratory, candidate, driven, self.folder)
        except CodesignError as refused:
            return {"no_mission": _reason(refused)}
        platform = self.folder / f"{row.board}-robot.yaml"
        self.files[platform] = f"# A robot that hwsw advise put on {row.board}, for a mission.\n{plain_yaml(tree)}"
        mission = self._put(candidate, workload, "-mission", " in a mission")
        command = command_of(candidate, mission, platform=platform)
        return {"mission_platform": str(platform), "mission_workload": str(mission), "mission_command": command}

    def write(self, answer: Advice) -> None:
        """Write all files, those of the whole answer last.

        Raises:
            RunError: the folder cannot be written to.
        """
        whole = {ANSWER: f"{answer.model_dump_json(indent=2)}\n", COMMANDS: commands_text(answer)}
        write_all(self.files | {self.folder / name: text for name, text in whole.items()})


def commands_text(answer: Advice) -> str:
    """The rows of an answer, each with the commands that go on from its board, for a shell."""
    head = "# The commands of an answer of hwsw advise. Their paths start in the folder that it was called in."
    blocks = [[head, f"# {answer.question}"]]
    for board in answer.boards:
        price = "price not known" if board.price_usd is None else amount(board.price_usd, "USD")
        row = f"# {board.board}: {price}, {_row(board.design, board.shortfalls, answer.needs)}"
        block: list[str | None] = [row, board.command]
        if board.circuit is not None and board.circuit_workload != board.workload:
            row = _row(board.circuit, board.circuit_shortfalls, answer.needs)
            block += [f"# The best circuit that was tried on it: {row}", board.circuit_command]
        block += [f"# No RTL: {board.no_rtl}" if board.no_rtl else board.rtl_command]
        block += [f"# No mission: {board.no_mission}" if board.no_mission else board.mission_command]
        blocks.append([line for line in block if line])
    return "\n".join("".join(f"{_one_line(line)}\n" for line in block) for block in blocks)


def _one_line(line: str) -> str:
    """A remark made safe for a shell; a command as it is."""
    return " ".join(printable(line, None).split()) if line.startswith("#") else line


def _row(design: Design | None, short: Sequence[Shortfall], needs: Needs) -> str:
    """What a design comes to: the time of a plan, its power, and what it falls short of."""
    parts = [] if design is None else [design_text(design)]
    if design is not None and design.trial.time_s is not None:
        trial = design.trial
        parts.append(f"a plan takes {time_text(design.trial.time_s, trial.time_low_s, trial.time_high_s)}")
        power = design.mean_power_w if design.input_power_w is None else design.input_power_w
        if power is not None:
            least = "at least " if design.input_power_w is None else ""
            parts.append(f"{least}{format_power(power)} at its plug")
    why = "; ".join(shortfall_text(each, needs) for each in short)
    return ", ".join([*parts, f"does not suffice: {why}" if why else "suffices"])
