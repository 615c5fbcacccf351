"""``hwsw workload from-bag``."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import codesign
from codesign.cli.progress import LATER_S, progress_shown
from codesign.cli.requests import FromBag
from codesign.cli.specs import settings_of as values_of
from codesign.ground.errors import InputError, SpecError, clip, printable
from codesign.ground.files import write_atomically
from codesign.ground.progress import doing
from codesign.ground.records import MemoryListener
from codesign.inputs.files import read_spec
from codesign.system import point_of
from codesign.views.bags import (
    Choices,
    Rule,
    Topics,
    facts_of,
    file_name,
    goals_csv,
    map_files,
    read_bag,
    settings_of,
    workload_text,
)
from codesign.views.report import render_text
from codesign.views.report.scenario_tables import board_latencies, goals_table

if TYPE_CHECKING:
    from codesign.ground.progress import Show
    from codesign.views.bags import BagFacts

_SECOND = 10**12


def from_bag(asked: FromBag) -> None:
    """Make a workload of the run in BAG, a folder of a ROS 2 bag or its .mcap or .db3 file."""
    choices = _choices(asked)
    planner, mapping = _plan_like(asked.like)
    chosen = file_name(asked.name if asked.name is not None else asked.bag.resolve().stem)
    paths = {key: asked.folder / f"{chosen}{end}" for key, end in _ENDS.items()}
    _check_new(paths.values())
    with progress_shown(after_s=LATER_S) as show:
        doing(show, "reading the bag")
        recording = read_bag(asked.bag, choices.topics, asked.use_map == "last", show)
        doing(show, "placing the run on the map")
        facts = facts_of(recording, choices)
        files = {**map_files(facts, chosen), f"{chosen}-goals.csv": goals_csv(facts)}
        files[f"{chosen}.yaml"] = workload_text(facts, chosen, planner, mapping, asked.like).encode()
        _write(asked.folder, files)
        latencies = [] if asked.platform is None else _answers(asked.platform, paths["workload"], facts, show)
    click.echo(render_text(goals_table(facts, asked.platform, latencies)))
    for path in paths.values():
        click.echo(f"written: {printable(str(path), None)}")
    words = shlex.join([asked.platform or "PLATFORM", str(paths["workload"])])
    click.echo(f"next: hwsw run {printable(words, None)}")


_ENDS = {"workload": ".yaml", "map": "-map.yaml", "image": "-map.pgm", "goals": "-goals.csv"}


def _choices(asked: FromBag) -> Choices:
    topics = {name.removesuffix("_topic"): value for name, value in vars(asked).items() if name.endswith("_topic")}
    stay = None if asked.stay is None else asked.stay / _SECOND
    rule = Rule(asked.slot / _SECOND, asked.margin, asked.radius, asked.least, stay)
    return Choices(Topics(**topics, base=asked.base_frame, namespace=asked.namespace), rule, asked.near)


def _plan_like(like: str) -> tuple[str, dict[str, Any]]:
    """The planner of a workload, and its mapping as it is written. A run of what is written here checks both."""
    document = read_spec(like, "workloads")
    if document.faults:
        raise SpecError(document.faults)
    tree = document.tree if isinstance(document.tree, dict) else {}
    planner, mapping, problem = (tree.get(key) for key in ("planner", "mapping", "problem"))
    if not isinstance(planner, str) or not isinstance(mapping, dict) or not isinstance(problem, dict):
        raise InputError(f"{clip(like)} is no workload with a planner, a problem and a mapping", "--like", _OTHER)
    if "map" not in problem:
        raise InputError(f"{clip(like)} plans on no map with a goal", "--like", _OTHER)
    return planner, mapping


_OTHER = "name a workload that plans on a map, such as warehouse or office-harmonic"


def _check_new(paths: Any) -> None:
    for path in paths:
        if path.exists():
            hint = "choose another folder with -o or another --name, or remove the file first"
            raise InputError("exists already", printable(str(path), None), hint)


def _write(folder: Path, files: dict[str, bytes]) -> None:
    """Write all files into the folder, or none; the workload comes last."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        what = f"the folder cannot be made: {fault.strerror}"
        raise InputError(what, f"-o {printable(str(folder), None)}", "name another folder") from fault
    written: list[Path] = []
    try:
        for name, content in files.items():
            write_atomically(folder / name, content)
            written.append(folder / name)
    except BaseException:
        for path in written:
            path.unlink(missing_ok=True)
        raise


def _answers(platform: str, file: Path, facts: BagFacts, show: Show) -> list[int | None]:
    """The times that the platform, with the robot of the bag, takes for the first plan to each goal, ps."""
    doing(show, "running the workload")
    loaded = codesign.load_platform(platform)
    robots = [name for name, each in loaded.components.items() if each.type == "robot"]
    texts = [f"{key}={value}" for key, value in (settings_of(facts, robots[0]) if robots else {}).items()]
    records = MemoryListener()
    point = point_of(loaded, codesign.load_workload(str(file)), values_of(tuple(texts)))
    result = codesign.simulate(*point, listeners=[records])
    if not result.simulated:
        reasons = "; ".join(f"{reason.name}: {reason.demand:,.6g} of {reason.limit:,.6g}" for reason in result.reasons)
        click.echo(f"{platform} cannot run the workload: {printable(reasons)}", err=True)
    return board_latencies(records.records)
