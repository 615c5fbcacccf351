"""The request of each command, in the order of the help. ``request`` says how one is written."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from codesign.cli.options import (
    BAG,
    DEBUG,
    FORCE,
    JSON,
    MEMORY,
    NEEDS,
    PAGE,
    REACH,
    SETTINGS,
    MapFile,
    Number,
    Quantity,
    axis,
    place,
    printed,
    setting,
)
from codesign.cli.request import Command, Request, argument, option
from codesign.ground.units import Dimension

if TYPE_CHECKING:
    from codesign.inputs.places import Place
else:
    Place = Any  # Its module is loaded to read one.

_INPUT = click.Path(exists=True, dir_okay=False, path_type=Path)
_FOLDER = click.Path(file_okay=False, path_type=Path)
_ANY = click.Path(path_type=Path)
_MAP = MapFile(exists=True, dir_okay=False, path_type=Path)
_TIME = Quantity(Dimension.TIME)
_COUNT = click.IntRange(1)

_POINT: Any = option("Take this point of STUDY, a file of hwsw explore.", "--point INDEX")
_BACKEND: Any = option(
    "The simulator. auto: CXXRTL, and Verilator for a large array where it is installed.", default="auto"
)
_FROM: Any = option("Only from this simulated time, such as 12s.", "--from", type=_TIME, default=0)
_TO: Any = option("Only up to this simulated time.", "--to", type=_TIME)


class Run(Request):
    """Simulate WORKLOAD on PLATFORM (names or YAML files), and print the answer: one sentence and five figures.

    With --point, simulate a point of an explored study, from the specs that the study holds.

    -v adds all tables: costs, quality of the plan, resources, and the sources of the figures. For the exit code alone,
    use -q and send the output to /dev/null.

    The exit code is 3 where the design does not fit, or misses a --need. A mission that ends without its goal is a
    result: the exit code is 0, and the result says why.
    """

    specs: tuple[str, ...] = argument("PLATFORM WORKLOAD | STUDY")
    point: int | None = option("Run this point of STUDY, a file of hwsw explore, again.", "--point INDEX")
    settings: Mapping[str, object] = SETTINGS
    needs: tuple[str, ...] = NEEDS
    trace: Path | None = option("Write an MCAP trace.")
    bag: Path | None = BAG
    trace_level: Literal["mission", "messages", "blocks", "iterations"] = option(
        "How much the trace holds; each level holds what the one before holds, and more.", default="blocks"
    )
    page: Path | None = PAGE
    granularity: Literal["run_ahead", "visit"] = option(
        "How much a component computes in one event. The result is the same.", default="run_ahead"
    )
    memory: int | None = MEMORY
    levers: bool = option(
        "Repeat a mission with each of its levers moved, to find its bottleneck.", "--levers/--no-levers", default=True
    )
    detail: str = printed("Print the sentence alone.", "Print all tables after the sentence and its figures.")
    debug: bool = DEBUG
    as_json: bool = option("Print the result as JSON.", "--json")
    force: bool = FORCE


class Advise(Request):
    """Answer which board suffices to plan on MAP at a rate, whether a cheaper one does, and why the next one does not.

    MAP is a file, or a shipped map such as house.

    In place of --rate, --speed with --range and --brake asks for the rate at which a robot of that speed stops for what
    it sees. Without --speed, the answer says how fast it may drive with each board.

    Every planner, style and placement is searched on every board. A PLACE is ROW,COLUMN in whole numbers, or X,Y in
    metres of the map's frame, as 12.5,3.0 or 12m,3m. The exit code is 3 where no board suffices, and 4 where the search
    ended before that, or that no cheaper board does, was proved.
    """

    map_file: Path = argument("MAP", type=_MAP)
    goals: tuple[str, ...] = option("A goal, such as 12.5,3.0.", "--goal PLACE")
    rate: str | None = option("Plans a second, such as 10Hz.", "--rate RATE")
    speed: str | None = option("Speed of the robot, such as 1.5m/s, in place of --rate.", "--speed SPEED")
    sight: str | None = option("Distance that the robot's sensor sees, such as 4m.", "--range LENGTH")
    brake: str | None = option("Deceleration of its brakes, such as 2m/s^2.", "--brake ACCELERATION")
    sensor: str | None = option("Scans of its sensor a second, such as 10Hz.  [default: no limit]", "--sensor RATE")
    delay: str | None = option(
        "Latency of sensor, messages and actuators together, such as 50ms.  [default: 0]", "--delay TIME"
    )
    boards: str | None = option("Boards to ask about: names or files.  [default: all]", "--boards NAME,...")
    power: str | None = option("Most mean power at that rate, such as 5W.", "--power POWER")
    price: str | None = option("Most that a board may cost, such as 200USD.", "--price PRICE")
    prices: Path | None = option(
        "A file of your own prices, in place of the declared ones.", "--prices FILE", type=_INPUT
    )
    clearance: str | None = option("Distance to keep from obstacles, such as 0.3m.", "--clearance LENGTH")
    detour: float | None = option(
        "Most that a path may be as long as the shortest, such as 1.1.", "--detour TIMES", type=Number(min=1)
    )
    needs: tuple[str, ...] = NEEDS
    share: float | None = option(
        "Share of a part's logic that a design may use.  [default: 0.8]",
        "--share",
        type=Number(min=0, max=1, min_open=True),
    )
    on: Literal["fabric", "host", "split"] | None = option("Only designs of this placement.")
    planner: str | None = option("Only designs of this planner.")
    style: str | None = option("Only designs of this architecture style.")
    starts: tuple[str, ...] = option("A start.  [default: 64 are drawn]", "--start PLACE", default=())
    task: Literal["path", "field", "replan"] = option("What is asked of a plan.", default="path")
    change: int = option(
        "Cells that change before a plan of task replan, drawn.", "--change COUNT", type=_COUNT, default=20
    )
    reach: float | None = REACH
    unknown: Literal["blocked", "free"] | None = option("What unknown cells count as.")
    resolution: str | None = option("Size of a cell, for a map that does not say it.", "--resolution LENGTH")
    budget: float | None = option(
        "Computing time after which no further design is begun.  [default: 45]", "--budget SECONDS", type=Number(min=0)
    )
    page: Path | None = option("Write a self-contained HTML page of the answer.", "--html")
    write: Path | None = option(
        "Write into this folder: each board's best design, its best circuit and a mission, the answer as JSON, and the"
        " commands for them.",
        "--write FOLDER",
        type=_FOLDER,
    )
    certificate: Path | None = option(
        "Write the certificate: why no cheaper board suffices. hwsw verify-advice checks it.", "--certify"
    )
    as_json: bool = option("Print the answer as JSON.", "--json")
    force: bool = FORCE


class StudyOutputs(Request):
    """The outputs of a study."""

    csv: Path | None = option("Write every computed point as CSV.")
    parquet: Path | None = option("Write every computed point as a Parquet file, for pandas, Polars and DuckDB.")
    page: Path | None = option("Write a self-contained HTML page.", "--html")
    certificate: Path | None = option(
        "Write the certificate of the front: why each design off it is off it. hwsw verify-front checks it.",
        "--certify",
    )
    force: bool = FORCE
    detail: str = printed(
        "Print the sentence alone.", "Print the best points, every point and the sources of the figures too."
    )
    debug: bool = DEBUG
    as_json: bool = option("Print every point, feasible or not, as JSON.", "--json")


class Explore(StudyOutputs):
    """Evaluate every point of WORKLOAD's exploration on PLATFORM, and print the front, after one sentence.

    Finished points are kept in one file. The command continues from that file when it runs again.

    Leave PLATFORM out where the workload has an axis platform, or with --axis platform=NAME,FILE.yaml.

    --axis and --condition replace the axis of that name in the file, or add one. --need adds a constraint.

    The exit code is 3 where no design is feasible.
    """

    specs: tuple[str, ...] = argument("[PLATFORM] WORKLOAD")
    store: Path | None = option("The SQLite file of finished points.  [default: PLATFORM-WORKLOAD.sqlite]")
    settings: Mapping[str, Any] = setting("Set an axis for all points.")
    axes: Mapping[str, Any] = axis(
        "Explore these values: a,b,c, or a range 1..8, 10MHz..100MHz:10MHz (step), 1..1024*2 (factor) or"
        " '10MHz..1GHz in 12 log' (count); 'a,b when OTHER=VALUE': where another axis has this value alone.",
        "--axis",
    )
    conditions: Mapping[str, Any] = axis("Run every design in these conditions; written as --axis.", "--condition")
    needs: tuple[str, ...] = NEEDS
    workers: int = option(
        "The number of worker processes.",
        type=click.IntRange(1, 256),
        show_default="the number of cores",
        default=os.cpu_count() or 1,
    )
    cluster: str | None = option(
        "Compute with the workers of a dask cluster: tcp://HOST:PORT, tls://HOST:PORT, or the scheduler's file.",
        "--cluster ADDRESS",
    )
    memory: int | None = MEMORY
    points: int | None = option("Compute no more than N points.", "--points N", type=_COUNT)
    time_ms: int | None = option(
        "Begin no point after this time, such as 10min.",
        "--time TIME",
        type=Quantity(Dimension.TIME, scale=10**9, least=1),
    )
    search: str | None = option(
        "Compute what a search asks for, and as many random points beside it: nsga2, tpe (extra search), random, or"
        " bound, which proves the front; all: no search. --points N limits each. All points of a small space are"
        " computed instead, where they take few simulations: exact, and cheaper than bound.  [default:"
        " explore.search of the workload]",
        "--search NAME",
    )
    seed: int | None = option("The seed of --search: the same seed, the same designs.", "--seed S")
    check: int | None = option(
        "Run N random points alone too, and compare every figure with the study, to the last bit.",
        "--check N",
        type=_COUNT,
    )


class Explain(Request):
    """Say why a design takes its time and its energy, why it is out, what is better, and how sure that is.

    With a file of hwsw explore and the INDEX of a design: the design among its neighbours. With PLATFORM and WORKLOAD:
    the run, and what it is with each lever and each next value. Each lever is run by itself, for the whole design.

    The exit code is 3 where the design is not feasible.
    """

    what: str = argument("STUDY|PLATFORM")
    which: str = argument("INDEX|WORKLOAD")
    settings: Mapping[str, object] = setting("Of a run: set an axis, e.g. fabric.clock=50MHz.")
    conditions: Mapping[str, object] = setting(
        "Of a study: in one condition, by its value, or by its number in the list, from 0.", "--condition"
    )
    detail: str = printed("Print the sentence alone.", "Print all parts, levers and neighbours.")
    debug: bool = DEBUG
    as_json: bool = option("Print the explanation as JSON.", "--json")


class Compare(Request):
    """Simulate each PLATFORM:WORKLOAD and print the figures side by side.

    Each design plans on the map of its own workload. With --on, or --map with --goal and --start, all designs are asked
    the same on one map. By default the shipped designs of harmonic control, wavefront, breadth-first search and
    relaxation on a host are compared on the labyrinth. Where a design cannot use the map, its column says why, and the
    others still run.

    The exit code is 3 where no design is feasible, or none meets every --need, and 1 where none could run.
    """

    designs: tuple[str, ...] = argument("[PLATFORM:WORKLOAD]...", default=())
    like: str | None = option(
        "Use the map, goals and starts of this workload in every design.  [default: of each design its own;"
        " labyrinth without designs]",
        "--on WORKLOAD",
    )
    map_file: Path | None = option("Use this map in every design.", "--map", type=_INPUT)
    goal: Place | None = place("The goal on --map.")
    start: Place | None = place("The start on --map.")
    reach: float | None = REACH
    task: Literal["path", "field", "replan"] | None = option(
        "What is asked of every design.  [default: that of the workload; path on --map]"
    )
    settings: Mapping[str, object] = setting("Set an axis, in every design that has it.")
    needs: tuple[str, ...] = NEEDS
    memory: int | None = MEMORY
    detail: str = printed(
        "Print a sentence for each design alone.", "Print all tables of each design after the comparison."
    )
    debug: bool = DEBUG
    page: Path | None = PAGE
    as_json: bool = option("Print the results as JSON.", "--json")
    force: bool = FORCE


class Report(StudyOutputs):
    """Write the tables, the CSV and the HTML page of the exploration in STORE. Nothing is simulated.

    --need judges the designs anew, with a further constraint. The exit code is 3 where none is feasible.
    """

    store: Path = argument(type=_INPUT)
    conditions: Mapping[str, object] = setting(
        "Show one condition by itself: by its value, or by its number in the list, from 0.", "--condition"
    )
    needs: tuple[str, ...] = NEEDS


class Plot(Request):
    """Draw a picture as PDF, SVG or PNG, by the end of the name of the file.

    The same input gives the same bytes. A PDF embeds its fonts, and its texts stay texts. In Python the functions of
    codesign.views.report return the same pictures as figures of matplotlib.
    """


class Drawn(Request):
    """The file of a picture."""

    output: Path = option("The file: .pdf, .svg or .png.", "-o", "--output")
    width: float | None = option(
        "The width in mm, such as 88 for a column; letters keep their size.  [default: 150 to 230]",
        "--width MM",
        type=Number(20, 1000),
    )
    force: bool = FORCE


class PlotFront(Drawn):
    """Draw the feasible designs of STORE by two figures, and the front among them. Nothing is simulated."""

    store: Path = argument(type=_INPUT)
    x: str | None = option("The figure to the right.  [default: the first objective]", "--x FIGURE")
    y: str | None = option("The figure upwards.  [default: the second objective]", "--y FIGURE")
    colour: str = option(
        "The figure that colours the points, or none.", "--colour FIGURE", default="share_reaching_goal"
    )
    marker: str | None = option("The axis that shapes the points.  [default: the part]", "--marker AXIS")
    conditions: Mapping[str, object] = setting("Draw one condition by itself.", "--condition")
    needs: tuple[str, ...] = NEEDS


class PlotMap(Drawn):
    """Draw the map of WORKLOAD with its goals and starts.

    Of a TRACE, or of a run of WORKLOAD on PLATFORM, draw the field and the paths of the plan, or what the robots drove.
    """

    specs: tuple[str, ...] = argument("WORKLOAD | TRACE | PLATFORM WORKLOAD")
    at: int | None = option("Of a mission, the moment to draw, such as 12s.", type=_TIME)


class PlotTimeline(Drawn):
    """Draw when each component and link was busy, from TRACE, or from a run of WORKLOAD on PLATFORM."""

    specs: tuple[str, ...] = argument("TRACE | PLATFORM WORKLOAD")


class PlotSchedule(Drawn):
    """Draw the precision of each stage over time, and the local maxima left.

    They are drawn from TRACE, or from a run of WORKLOAD on PLATFORM. The stages are of harmonic control.
    """

    specs: tuple[str, ...] = argument("TRACE | PLATFORM WORKLOAD")


class VerifyFront(Request):
    """Check the certificate in FILE: whether its front follows from the figures stated. Nothing is simulated.

    What the certificate says and nothing in it shows is counted as taken on trust.

    The exit code is 3 where it is refused, and 1 where FILE cannot be read as a certificate.
    """

    file: Path = argument(type=_INPUT)
    store: Path | None = option("Check too that it is the certificate of the exploration in this store.", type=_INPUT)
    conditions: Mapping[str, object] = setting(
        "With --store: the condition that it was written for, as in hwsw report.", "--condition"
    )
    needs: tuple[str, ...] = NEEDS
    complete: bool = option("Refuse it where designs were not computed.")
    as_json: bool = option("Print the verdict as JSON.", "--json")


class VerifyAdvice(Request):
    """Check the certificate in FILE, of hwsw advise --certify: whether no cheaper board suffices follows from it.

    Nothing is simulated. The exit code is 3 where it is refused, and 1 where FILE cannot be read as a certificate.
    """

    file: Path = argument(type=_INPUT)
    as_json: bool = option("Print the verdict as JSON.", "--json")


class Trace(Request):
    """Read an MCAP trace of hwsw run --trace FILE."""


class TraceInfo(Request):
    """Print the contents of the trace FILE: its run, time span, topics and numbers of messages."""

    file: Path = argument(type=_INPUT)
    as_json: bool = JSON


class TraceShow(Request):
    """Print the records of the trace FILE in order of time, and the last field of a plan.

    With --at: the true map at that time, the robot's belief, its path and its position.
    """

    file: Path = argument(type=_INPUT)
    topics: tuple[str, ...] = option("Only this topic. May be repeated.", "--topic", default=())
    begin: int = _FROM
    end: int | None = _TO
    at: int | None = option("Print the map at this simulated time instead of the records.", type=_TIME)
    picture: Path | None = option("Draw the map of --at as a PNG or SVG.")
    limit: int = option("The most lines to print.", type=_COUNT, default=200)
    as_json: bool = option("Print each line as JSON.", "--json")
    force: bool = FORCE


class TraceExport(Request):
    """Export the trace FILE for other tools."""

    file: Path = argument(type=_INPUT)
    perfetto: Path | None = option("Write a trace of Perfetto, for ui.perfetto.dev.")
    vcd: Path | None = option("Write a waveform, with a save file of GTKWave beside it.")
    poses: Path | None = option("Write the positions and times of each robot as CSV.")
    page: Path | None = option("Write the page of the run, which plays it.", "--html")
    bag: Path | None = BAG
    bag_begin: int = option(
        "When the run begins in the bag, in seconds since 1970.",
        "--ros2-begin SECONDS",
        type=click.IntRange(0, 2 * 10**9),
        default=0,
    )
    begin: int = option("Of the waveform: only from this simulated time.", "--from", type=_TIME, default=0)
    end: int | None = option("Of the waveform: only up to this simulated time.", "--to", type=_TIME)
    force: bool = FORCE


class TraceLayout(Request):
    """Write a layout for the trace FILE: the topics that it has, in panels, seen from above, with plots and events."""

    file: Path = argument(type=_INPUT)
    output: Path | None = option(
        "The file to write.  [default: FILE with the ending .json, or .rbl for Rerun]", "-o", "--output"
    )
    viewer: Literal["foxglove", "ros2", "rerun"] = option(
        "A layout for Foxglove and Lichtblick, of the trace or of its ROS 2 bag; a blueprint for Rerun.",
        default="foxglove",
    )
    force: bool = FORCE


class TraceStats(Request):
    """Print of the trace FILE how busy each component and link was, and how long messages, tasks and plans took."""

    file: Path = argument(type=_INPUT)
    as_json: bool = JSON


class TraceDiff(Request):
    """Print where the traces FIRST and SECOND differ first in simulated time, then all that differs.

    The exit code is 0 where all records are equal, and 3 where they differ.
    """

    first: Path = argument(type=_INPUT)
    second: Path = argument(type=_INPUT)
    as_json: bool = JSON


class TraceTimeline(Request):
    """Print the trace FILE as a Gantt chart: when each component and link worked, and the events of a mission."""

    file: Path = argument(type=_INPUT)
    begin: int = _FROM
    end: int | None = _TO
    width: int | None = option("Columns; by default those of the terminal.", type=click.IntRange(60, 1000))


class FromBags(Request):
    """Make workloads of recordings."""


_METRE = Number(0, 1000)


def _topic(topic: str) -> Any:
    return option(f"Read this as {topic}; none leaves it out.  [default: by type and namespace]", metavar="TOPIC")


class FromBag(Request):
    """Make a workload of the run in BAG, a folder of a ROS 2 bag or its .mcap or .db3 file.

    It writes NAME.yaml (the workload), NAME-map.yaml and NAME-map.pgm (the map, as map_server has it), and
    NAME-goals.csv (what the recorded planner answered, and when). No file is overwritten.

    The bag needs /map, and the place of the robot: /tf with /tf_static, or /odom. /goal_pose gives the goals, /scan the
    obstacles and the sensor, /plan the recorded answers, /cmd_vel the period of the control loop. Topics of other names
    are found by their type; of several robots --namespace names one.
    """

    bag: Path = argument(type=_ANY)
    folder: Path = option(
        "Write the files here.  [default: the current folder]", "-o", "--out DIR", type=_FOLDER, default=Path()
    )
    name: str | None = option("Name of the workload and its files.  [default: that of the bag]")
    like: str = option("Take planner and mapping of this workload.", "--like WORKLOAD", default="warehouse")
    platform: str | None = option("Run the workload on this platform, and compare the answers.", "--on PLATFORM")
    use_map: Literal["first", "last"] = option("Which of several different maps is used.", default="last")
    namespace: str | None = option(
        "Read the topics of the robot in this namespace.  [default: the one that the bag has]", "--namespace NAMESPACE"
    )
    base_frame: str | None = option("Frame of the robot.  [default: that of the odometry]", "--base-frame FRAME")
    near: float = option("A goal is reached this near to it.", "--near METRES", type=_METRE, default=0.3)
    slot: int = option(
        "Obstacles: cut time into slots so long.  [default: 1 s]",
        "--slot TIME",
        type=Quantity(Dimension.TIME, least=10**11),
        default=10**12,
    )
    margin: float = option(
        "Obstacles: leave out hits this near to an obstacle of the map.", "--margin METRES", type=_METRE, default=0.15
    )
    radius: float = option(
        "Obstacles: cells this near to the robot are free.", "--radius METRES", type=_METRE, default=0.2
    )
    least: int = option("Obstacles: leave out fewer hits.", type=_COUNT, default=3)
    stay: int | None = option(
        "Obstacles: one that is not seen again stays so long.  [default: to the end]", "--stay TIME", type=_TIME
    )
    map_topic: str | None = _topic("/map")
    tf_topic: str | None = _topic("/tf")
    tf_static_topic: str | None = _topic("/tf_static")
    scan_topic: str | None = _topic("/scan")
    odom_topic: str | None = _topic("/odom")
    goal_topic: str | None = _topic("/goal_pose")
    plan_topic: str | None = _topic("/plan")
    command_topic: str | None = _topic("/cmd_vel")


class Reproduce(Request):
    """Print published and modelled figures row by row, with the error and the source of each figure.

    Each PLANNER selects the paper of that planner. Without one, all papers are reproduced.

    With --set, head and rows say which settings are not the published ones.
    """

    names: tuple[str, ...] = argument("[PLANNER]...", default=())
    quick: bool = option("Simulate fewer and smaller maps.")
    page: Path | None = option("Write an HTML page with plots.", "--html")
    plots: Path | None = option("Write the plots into this folder.", type=_FOLDER)
    csv: Path | None = option("Write the rows as CSV.")
    settings: Mapping[str, object] = setting(
        "Move a setting of the papers' runs; see --settings.", metavar="NAME=VALUE"
    )
    listed: bool = option("List the settings that --set moves, and run nothing.", "--settings")
    detail: str = printed("Print the findings alone.", "Print the sources of the modelled figures too.")
    debug: bool = DEBUG
    as_json: bool = option("Print rows and findings as JSON.", "--json")
    force: bool = FORCE


class Calibrate(Request):
    """Fit costs to this machine, or laws to the reports of your FPGA tool, for platform files."""


class CalibrateHost(Request):
    """Time the planners' kernels on this machine, and print them as keys of a processor in a platform file.

    The costs of the kernels are fitted to plans on maps of several kinds and sizes. Their interval holds the time of a
    plan on one more map with 95 %. Load and jitter are of the same runs.

    With --write, they are written as a host file. Name it in your platform, with the key host of a processor.

    Another board needs Python and NumPy alone. With --script, a script for it is printed: run it there as "python3
    probe.py > board.json", and name that file with --from.
    """

    seconds: float = option("The approximate time to measure.", default=20.0)
    script: bool = option("Print a Python script that measures a board which has NumPy alone.", "--script")
    board: Path | None = option("Take what the script printed on a board.", "--from FILE", type=_ANY)
    write: Path | None = option("Write a host file, such as hosts/mine.yaml.", "--write FILE")
    like: str | None = option(
        "The host that stands for what is not measured: power, and kernels by their ratio.", "--like HOST"
    )
    as_json: bool = option("Print all of it as JSON, with fits and residuals.", "--json")
    force: bool = FORCE


class Measured(Request):
    """Hold a plan that was measured on the real board against the model, and solve for the figures that decide it.

    FILE names platform and workload, and says what a plan took: its median and its 99th percentile. With --write, the
    platform is written with these figures, whose status is measured. Ask the next question with that file: hwsw advise
    --boards, or hwsw run.

    The exit code is 3 where the measured time lies outside of the interval of the model.
    """

    file: Path = argument("FILE", type=_ANY)
    write: Path | None = option("Write the platform with the figures that were solved for.", "--write PLATFORM.yaml")
    as_json: bool = option("Print the comparison as JSON.", "--json")
    force: bool = FORCE


class CalibrateFpga(Request):
    """Show what reports of your FPGA tool say beside what the laws predict, and fit a factor to each term.

    The reports are from Vivado, ISE, Quartus, Diamond, Radiant, Gowin EDA, Yosys and nextpnr, as text or JSON. All
    are of the design point PLATFORM WORKLOAD (names or YAML files). Without these, each report is of the design whose
    manifest.json, by hwsw rtl, stands in its folder or above.

    With -o, the factors are written as a calibration. Name it in your platform, with the key calibration of the FPGA:
    results then say the calibrated numbers, and cite it.
    """

    specs: tuple[str, ...] = argument("[PLATFORM WORKLOAD]", default=())
    reports: tuple[Path, ...] = option(
        "A report of utilisation, timing or power. May be repeated.", "--report FILE", type=_ANY
    )
    settings: tuple[str, ...] = option("Set an axis of the design point.", "--set AXIS=VALUE", default=())
    clock: str | None = option("The clock of the design, where a report has several.", "--clock NAME")
    added_to: Path | None = option("A calibration; its samples are taken too.", "--with FILE")
    output: Path | None = option("Write the calibration, such as calibrations/mine.yaml.", "-o", "--output FILE")
    reasons: tuple[str, ...] = option(
        "Accept reports of TERM, such as lut4, that differ from the law by more than a factor of 2. May be repeated.",
        "--explain TERM=REASON",
        default=(),
    )
    as_json: bool = option("Print the comparison as JSON.", "--json")
    force: bool = FORCE


class Rtl(Request):
    """Write the circuit of WORKLOAD on PLATFORM into the folder DIR, as Verilog that any tool takes.

    The folder has the Verilog of the design point, a self-checking test bench for Icarus and Verilator, the images of
    its memories, the stream with the map, the clock constraint for the tools of the part, golden vectors with a test
    for cocotb, a core file for FuseSoC, and a README. The same design point gives the same bytes.

    The folder is written whole or not at all.
    """

    specs: tuple[str, ...] = argument("PLATFORM WORKLOAD | STUDY")
    point: int | None = _POINT
    settings: Mapping[str, object] = SETTINGS
    folder: Path = option("Write into this folder, which is made.", "-o", "--output DIR", type=_ANY)
    force: bool = option("Write into a folder that is not empty: replace the files of this command there.")
    debug: bool = DEBUG


class Verify(Request):
    """Simulate the circuit of WORKLOAD on PLATFORM, and compare all that it reports with the model.

    Every event is compared in its kind, its value and its cycle, every phase in its cycles, and a display in every
    cycle. A difference is printed with its first cycle.

    With --all, random design points on random maps are verified. Sample S is the same for the same seed S.

    The exit code is 3 where a circuit differs from the model, and 1 where a run fails.
    """

    specs: tuple[str, ...] = argument("[PLATFORM WORKLOAD | STUDY]", default=())
    point: int | None = option("Verify this point of STUDY, a file of hwsw explore.", "--point INDEX")
    settings: Mapping[str, object] = SETTINGS
    every: bool = option("Verify random design points of every style that has a circuit.", "--all")
    planners: tuple[str, ...] = option("With --all: only the circuits of this planner.", "--planner", default=())
    points: int | None = option(
        "With --all: points of each style.  [default: 3]", "--points N", type=click.IntRange(1, 10000)
    )
    seed: int | None = option("With --all: the first seed.  [default: 0]", "--seed S", type=click.IntRange(0))
    backend: Literal["auto", "cxxrtl", "icarus", "verilator"] = _BACKEND
    jobs: int = option("Points verified at a time.", type=click.IntRange(1, 256), default=1)
    waves: Path | None = option(
        "Write the waveform around the first difference (VCD, for GTKWave), circuit and model above each other."
    )
    cycles: tuple[int, int] | None = option(
        "With --waves: write these cycles, whether or not they differ.",
        "--cycles FIRST LAST",
        type=click.IntRange(0),
        nargs=2,
    )
    debug: bool = DEBUG
    as_json: bool = option("Print every point as JSON.", "--json")
    force: bool = FORCE


class Synth(Request):
    """Synthesise the circuit of WORKLOAD on PLATFORM by Yosys, and hold the laws against what it takes.

    LUT, flip-flops, block RAMs and multipliers are counted by module, and by line of the demand.

    With --place, nextpnr places and routes the circuit: parts of the families ECP5, GW2A and GW1N. What was made once
    is kept in the cache.
    """

    specs: tuple[str, ...] = argument("PLATFORM WORKLOAD | STUDY")
    point: int | None = _POINT
    settings: Mapping[str, object] = SETTINGS
    family: str | None = option("Synthesise for another family than that of the part.", "--family NAME")
    placing: bool = option("Place and route too: the clock and its critical path.", "--place")
    seeds: int | None = option(
        "With --place: place N times, from seed 1 on, and take the median.  [default: 1]",
        "--seeds N",
        type=click.IntRange(1, 100),
    )
    debug: bool = DEBUG
    as_json: bool = option("Print all figures as JSON.", "--json")


class Fidelity(Request):
    """Compare what the laws predict with circuits that were simulated, synthesised and placed, and with papers.

    Circuits of random design points are simulated here. The rows of synthesis and placement are those that the package
    holds: hwsw synth makes such rows of one design point.

    What does not match is listed with its reason, and with the experiment that would settle it.
    """

    page: Path | None = option("Write the page, in Markdown.", "-o", "--output")
    picture: Path | None = option("Write the picture of law over measured, as SVG.")
    quick: bool = option("Simulate fewer design points of each circuit.")
    jobs: int = option("Simulations at a time.", type=click.IntRange(1, 64), default=1)
    backend: Literal["auto", "cxxrtl", "icarus", "verilator"] = _BACKEND
    debug: bool = DEBUG
    as_json: bool = option("Print everything that is compared as JSON.", "--json")
    force: bool = FORCE


class Check(Request):
    """Check FILES (YAML files, or names of shipped platforms and workloads), and report all faults with their places.

    A platform and a workload are checked against each other too, with the map, its goals and each variant. A run that
    would need too much memory is a fault. Without --json, notes report where a design does different work from what its
    parameters suggest.
    """

    files: tuple[str, ...] = argument()
    settings: Mapping[str, object] = SETTINGS
    memory: int | None = MEMORY
    as_json: bool = option("Print the faults as JSON.", "--json")


class Map(Request):
    """Show the map in FILE, or a shipped map by its name, as a workload with these steps would plan on it.

    Rows are counted from 0 at the top, columns from 0 at the left. Metres are as in map_server: x to the right, y
    up. Cropping keeps both.
    """

    file: Path = argument(type=MapFile(path_type=Path))
    unknown: str | None = option("What a cell counts as that the map says nothing about.", "--unknown blocked|free")
    inflate: str | None = option("Block cells this near to an obstacle: '0.3 m' or '6 cells'.", "--inflate RADIUS")
    downsample: int | None = option("Join N × N cells to one.", "--downsample N")
    crop: str | None = option("The part of the map that is shown.", "--crop none|free|reachable")
    resolution: str | None = option("Metres a cell, where the map does not say so: '5 cm'.", "--resolution LENGTH")
    at: Place | None = place("Find the nearest free cell: 40,60 is a cell, 12.5,3.0 are metres.")
    png: Path | None = option("Write the part shown as an image.")
    as_json: bool = option("Print the figures as JSON.", "--json")
    force: bool = FORCE


class Schema(Request):
    """Print the JSON Schema of a platform, workload, part, host, calibration or prices file, or of a --json output.

    The output is a result (hwsw run), a study (hwsw explore), an explanation (hwsw explain), an advice (hwsw advise) or
    a reproduction (hwsw reproduce).
    """

    kind: Literal[
        "platform",
        "workload",
        "part",
        "host",
        "calibration",
        "prices",
        "result",
        "study",
        "explanation",
        "reproduction",
        "advice",
    ] = argument()


class List(Request):
    """List the shipped platforms, parts, hosts and workloads, and the installed planners and styles.

    With PLANNER, list the parameters of that planner: task, name, accepted values, default and meaning; its styles, and
    its policies for planning again.
    """

    planner: str | None = argument()
    as_json: bool = JSON


class Show(Request):
    """Print the shipped platform, part, workload or map NAME. Its path is a comment on standard error.

    Where files of several kinds have one name, write platform:NAME, part:NAME, workload:NAME or map:NAME.
    """

    name: str = argument()
    path_only: bool = option("Print the path of the file alone.", "--path")


class Init(Request):
    """Write my-platform.yaml and my-workload.yaml into FOLDER, ready to run and to edit.

    Without options: harmonic control of a labyrinth on virtex4-pci. With an option, the workload has the first style
    and parameters of the planner that fit the board and the map. Without --goal, the goal is the free cell nearest to
    the middle of the map, in its largest connected area. No file is overwritten.
    """

    folder: Path = argument(type=_FOLDER, default=Path())
    board: str | None = option("Begin with this platform: a name or a file.", "--board PLATFORM")
    planner: str | None = option("Plan with this planner.")
    map_file: Path | None = option("Plan on this map: a file, or the name of a shipped one.", "--map", type=_MAP)
    goal: Place | None = place("The goal on the map.")


COMMANDS = {
    "run": Command(Run, "run:run", "Simulate one design point: its time, resources, power and quality of the plan."),
    "advise": Command(
        Advise, "advise:advise", "Answer which board suffices for a map at a rate, and why no cheaper one does."
    ),
    "explore": Command(
        Explore, "explore:explore", "Evaluate every point of a workload's exploration, and find the front."
    ),
    "explain": Command(Explain, "explain:explain", "Say why a design of an exploration, or a run, is as it is."),
    "compare": Command(Compare, "compare:compare", "Compare designs of any planner on one map."),
    "report": Command(Report, "explore:report", "Write the tables and the HTML page of a stored exploration."),
    "plot": Command(Plot, "", "Draw a front, a map, a time line or a schedule as PDF, SVG or PNG."),
    "plot front": Command(PlotFront, "plot:front", "Draw the front of a stored exploration."),
    "plot map": Command(PlotMap, "plot:map_", "Draw the map of a workload, or of a run with its paths."),
    "plot timeline": Command(PlotTimeline, "plot:timeline", "Draw when components and links were busy."),
    "plot schedule": Command(PlotSchedule, "plot:schedule", "Draw the stages of harmonic control."),
    "verify-front": Command(
        VerifyFront, "verify_front:verify_front", "Check the certificate of a front. Nothing is simulated."
    ),
    "verify-advice": Command(
        VerifyAdvice,
        "verify_advice:verify_advice",
        "Check the certificate of an answer about boards. Nothing is simulated.",
    ),
    "trace": Command(Trace, "", "Read the trace of a run."),
    "trace info": Command(TraceInfo, "trace:info", "Print the contents of a trace."),
    "trace show": Command(TraceShow, "trace:show", "Print the records of a trace."),
    "trace export": Command(TraceExport, "trace:export", "Export a trace for other tools."),
    "trace layout": Command(TraceLayout, "trace:layout", "Write the layout of a viewer for a trace."),
    "trace stats": Command(TraceStats, "trace:stats", "Print how busy all was, and how long things took."),
    "trace diff": Command(TraceDiff, "trace:diff", "Compare two traces."),
    "trace timeline": Command(TraceTimeline, "trace:timeline", "Print a Gantt chart."),
    "workload": Command(FromBags, "", "Make a workload of a recorded ROS 2 bag."),
    "workload from-bag": Command(FromBag, "workload:from_bag", "Make a workload of a ROS 2 bag."),
    "reproduce": Command(Reproduce, "reproduce:reproduce", "Compare the model with the published tables, row by row."),
    "calibrate": Command(Calibrate, "", "Fit costs to this machine, or laws to the reports of your FPGA tool."),
    "calibrate host": Command(CalibrateHost, "calibrate:host", "Measure the cost of each kernel on this machine."),
    "calibrate fpga": Command(CalibrateFpga, "calibrate:fpga", "Fit the laws of a style to reports of your FPGA tool."),
    "measured": Command(
        Measured, "calibrate:measured", "Hold a measured plan against the model, and feed it back into the platform."
    ),
    "rtl": Command(Rtl, "rtl:rtl", "Write the Verilog of a design point, with its test bench and memory images."),
    "verify": Command(Verify, "rtl:verify", "Compare circuits in Verilog with the model, cycle for cycle."),
    "synth": Command(
        Synth, "rtl:synth", "Synthesise a circuit with open tools, place and route it, and compare it with the laws."
    ),
    "fidelity": Command(
        Fidelity,
        "fidelity:fidelity",
        "Hold all laws against circuits that were simulated, synthesised and placed, and against papers.",
    ),
    "check": Command(Check, "inspect:check", "Check platform and workload files, and report all faults at once."),
    "map": Command(Map, "inspect:map_", "Show a map: its size, free cells, components, and what cropping saves."),
    "schema": Command(
        Schema, "inspect:schema", "Print a JSON Schema, for editors and for programs that read the JSON output."
    ),
    "list": Command(
        List,
        "begin:list_",
        "List platforms, parts, hosts, workloads, planners and styles, or the parameters of a planner.",
    ),
    "show": Command(Show, "begin:show", "Print a shipped platform, part, workload or map."),
    "init": Command(Init, "begin:init", "Write a first platform and workload, for a board, a planner and a map."),
}
"""Every command, in the order in which a newcomer needs them."""
