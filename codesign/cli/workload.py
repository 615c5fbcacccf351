"""``hwsw workload from-bag``."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codesign.cli.options import Quantity
from codesign.errors import InputError, clip, printable

if TYPE_CHECKING:
    from codesign.bags import BagFacts, Choices
    from codesign.progress import Show

_LIKE = "warehouse"
_SECOND = 10**12
_METRE = click.FloatRange(0, 1000)


@click.group(short_help="Make a workload of a recorded ROS 2 bag.")
def workload() -> None:
    """Make workloads of recordings."""


def _topics(command: Any) -> Any:
    for name, topic in reversed(
        [
            ("map", "/map"), ("tf", "/tf"), ("tf-static", "/tf_static"), ("scan", "/scan"), ("odom", "/odom"),
            ("goal", "/goal_pose"), ("plan", "/plan"), ("command", "/cmd_vel"),
        ]
    ):  # fmt: skip
        words = f"Read this as {topic}; none leaves it out.  [default: by type and namespace]"
        command = click.option(f"--{name}-topic", metavar="TOPIC", help=words)(command)
    return command


@workload.command("from-bag", short_help="Make a workload of a ROS 2 bag.")
@click.argument("bag", type=click.Path(path_type=Path))
@click.option(
    "-o", "--out", "folder", type=click.Path(file_okay=False, path_type=Path), default=Path(), metavar="DIR",
    help="Write the files here.  [default: the current folder]",
)  # fmt: skip
@click.option("--name", help="Name of the workload and its files.  [default: that of the bag]")
@click.option(
    "--like",
    default=_LIKE,
    show_default=True,
    metavar="WORKLOAD",
    help="Take planner and mapping of this workload.",
)
@click.option(
    "--on", "platform", metavar="PLATFORM", help="Run the workload on this platform, and compare the answers."
)
@click.option(
    "--use-map", type=click.Choice(["first", "last"]), default="last", show_default=True,
    help="Which of several different maps is used.",
)  # fmt: skip
@click.option(
    "--namespace", metavar="NAMESPACE",
    help="Read the topics of the robot in this namespace.  [default: the one that the bag has]",
)  # fmt: skip
@click.option("--base-frame", metavar="FRAME", help="Frame of the robot.  [default: that of the odometry]")
@click.option(
    "--near",
    type=_METRE,
    default=0.3,
    show_default=True,
    metavar="METRES",
    help="A goal is reached this near to it.",
)
@click.option(
    "--slot", type=Quantity("time", "time", least=_SECOND // 10), default=_SECOND, metavar="TIME",
    help="Obstacles: cut time into slots so long.  [default: 1 s]",
)  # fmt: skip
@click.option(
    "--margin", type=_METRE, default=0.15, show_default=True, metavar="METRES",
    help="Obstacles: leave out hits this near to an obstacle of the map.",
)  # fmt: skip
@click.option(
    "--radius", type=_METRE, default=0.2, show_default=True, metavar="METRES",
    help="Obstacles: cells this near to the robot are free.",
)  # fmt: skip
@click.option(
    "--least", type=click.IntRange(1), default=3, show_default=True, help="Obstacles: leave out fewer hits."
)
@click.option(
    "--stay", type=Quantity("time", "time"), metavar="TIME",
    help="Obstacles: one that is not seen again stays so long.  [default: to the end]",
)  # fmt: skip
@_topics
def from_bag(
    bag: Path, folder: Path, name: str | None, like: str, platform: str | None, use_map: str, **options: Any
) -> None:
    """Make a workload of the run in BAG, a folder of a ROS 2 bag or its .mcap or .db3 file.

    It writes NAME.yaml (the workload), NAME-map.yaml and NAME-map.pgm (the map, as map_server has it), and
    NAME-goals.csv (what the recorded planner answered, and when). No file is overwritten.

    The bag needs /map, and the place of the robot: /tf with /tf_static, or /odom. /goal_pose gives the goals, /scan the
    obstacles and the sensor, /plan the recorded answers, /cmd_vel the period of the control loop. Topics of other names
    are found by their type; of several robots --namespace names one.
    """
    from codesign.bags import facts_of, file_name, goals_csv, map_files, read_bag, workload_text
    from codesign.cli.progress import LATER_S, progress_shown
    from codesign.progress import doing
    from codesign.report import render_text
    from codesign.report.bag_tables import goals_table

    choices = _choices(options)
    planner, mapping = _plan_like(like)
    chosen = file_name(name if name is not None else bag.resolve().stem)
    paths = {key: folder / f"{chosen}{end}" for key, end in _ENDS.items()}
    _check_new(paths.values())
    with progress_shown(after_s=LATER_S) as show:
        doing(show, "reading the bag")
        recording = read_bag(bag, choices.topics, use_map == "last", show)
        doing(show, "placing the run on the map")
        facts = facts_of(recording, choices)
        files = {**map_files(facts, chosen), f"{chosen}-goals.csv": goals_csv(facts)}
        files[f"{chosen}.yaml"] = workload_text(facts, chosen, planner, mapping, like).encode()
        _write(folder, files)
        latencies = [] if platform is None else _answers(platform, paths["workload"], facts, show)
    click.echo(render_text(goals_table(facts, platform, latencies)))
    for path in paths.values():
        click.echo(f"written: {printable(str(path), None)}")
    words = shlex.join([platform or "PLATFORM", str(paths["workload"])])
    click.echo(f"next: hwsw run {printable(words, None)}")


_ENDS = {"workload": ".yaml", "map": "-map.yaml", "image": "-map.pgm", "goals": "-goals.csv"}


def _choices(options: dict[str, Any]) -> Choices:
    from codesign.bags import Choices, Rule, Topics

    stay = options["stay"]
    names = {key.removesuffix("_topic"): value for key, value in options.items() if key.endswith("_topic")}
    rule = Rule(
        options["slot"] / _SECOND, options["margin"], options["radius"], options["least"],
        None if stay is None else stay / _SECOND,
    )  # fmt: skip
    topics = Topics(**names, base=options["base_frame"], namespace=options["namespace"])
    return Choices(topics, rule, options["near"])


def _plan_like(like: str) -> tuple[str, dict[str, Any]]:
    """The planner of a workload, and its mapping as it is written. A run of what is written here checks both."""
    from codesign.errors import SpecError
    from codesign.inputs.files import read_spec

    document = read_spec(like, "workloads")
    if document.faults:
        raise SpecError(document.faults)
    tree = document.tree if isinstance(document.tree, dict) else {}
    planner, mapping, problem = (tree.get(key) for key in ("planner", "mapping", "problem"))
    if not isinstance(planner, str) or not isinstance(mapping, dict) or not isinstance(problem, dict):
        raise InputError(
            f"{clip(like)} is no workload with a planner, a problem and a mapping", "--like", _OTHER
        )
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
    from codesign.files import write_atomically

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
    """How long the platform, with the robot of the bag, takes for the first plan to each goal, ps."""
    import codesign
    from codesign.bags import settings_of
    from codesign.cli.options import settings_of as values_of
    from codesign.progress import doing
    from codesign.records import MemoryListener
    from codesign.report.bag_tables import board_latencies
    from codesign.system import point_of

    doing(show, "running the workload")
    loaded = codesign.load_platform(platform)
    robots = [name for name, each in loaded.components.items() if each.type == "robot"]
    texts = [f"{key}={value}" for key, value in (settings_of(facts, robots[0]) if robots else {}).items()]
    records = MemoryListener()
    point = point_of(loaded, codesign.load_workload(str(file)), values_of(tuple(texts)))
    result = codesign.simulate(*point, listeners=[records])
    if not result.simulated:
        reasons = "; ".join(
            f"{reason.name}: {reason.demand:,.6g} of {reason.limit:,.6g}" for reason in result.reasons
        )
        click.echo(f"{platform} cannot run the workload: {printable(reasons)}", err=True)
    return board_latencies(records.records)
