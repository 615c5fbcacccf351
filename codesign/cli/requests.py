# fmt: off
"""What can be asked: the request of each command, in the order of the help. ``request`` says how one is written."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import click

from codesign.cli.options import (
    NOTHING,
    PLACE,
    Bag,
    Debug,
    Detail,
    Force,
    Json,
    MapFile,
    Memory,
    Needs,
    Page,
    Quantity,
    Reach,
    Settings,
    axes,
    settings,
)
from codesign.cli.request import ANSWER, Argument, Command, Option, Request
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

_Point = Annotated[int | None, Option("Take this point of STUDY, a file of hwsw explore.", "--point", metavar="INDEX")]
_Design = Annotated[tuple[str, ...], Argument("PLATFORM WORKLOAD | STUDY")]
_Store = Annotated[Path, Argument(type=_INPUT)]
_Trace = Annotated[Path, Argument(type=_INPUT)]
_Backend = Annotated[Literal["auto", "cxxrtl", "icarus", "verilator"], Option(
    "The simulator. auto: CXXRTL, and Verilator for a large array where it is installed."
)]
_From = Annotated[int, Option("Only from this simulated time, such as 12s.", "--from", type=_TIME)]
_To = Annotated[int | None, Option("Only up to this simulated time.", "--to", type=_TIME)]


class Run(Request):
    """Simulate WORKLOAD on PLATFORM (names or YAML files), and print the answer: one sentence and five figures.

    With --point, simulate a point of an explored study, from the specs that the study holds.

    -v adds all tables: costs, quality of the plan, resources, and the sources of the figures. For the exit code alone,
    use -q and send the output to /dev/null.

    The exit code is 3 where the design does not fit, or misses a --need. A mission that ends without its goal is a
    result: the exit code is 0, and the result says why.
    """

    specs: _Design
    point: Annotated[int | None, Option(
        "Run this point of STUDY, a file of hwsw explore, again.", metavar="INDEX"
    )] = None
    settings: Settings = NOTHING
    needs: Needs = ()
    trace: Annotated[Path | None, Option("Write an MCAP trace.")] = None
    bag: Bag = None
    trace_level: Annotated[Literal["mission", "messages", "blocks", "iterations"], Option(
        "How much the trace holds; each level holds what the one before holds, and more."
    )] = "blocks"
    page: Page = None
    granularity: Annotated[Literal["run_ahead", "visit"], Option(
        "How much a component computes in one event. The result is the same."
    )] = "run_ahead"
    memory: Memory = None
    levers: Annotated[bool, Option(
        "Repeat a mission with each of its levers moved, to find its bottleneck.", "--levers/--no-levers"
    )] = True
    detail: Annotated[str, Detail(
        "Print the sentence alone.", "Print all tables after the sentence and its figures."
    )] = ANSWER
    debug: Debug = False
    as_json: Annotated[bool, Option("Print the result as JSON.", "--json")] = False
    force: Force = False


class Advise(Request):
    """Answer which board suffices to plan on MAP at a rate, whether a cheaper one does, and why the next one does not.

    MAP is a file, or a shipped map such as house.

    Every planner, style and placement is searched on every board. A PLACE is ROW,COLUMN in whole numbers, or X,Y in
    metres of the map's frame, as 12.5,3.0 or 12m,3m. The exit code is 3 where no board suffices.
    """

    map_file: Annotated[Path, Argument("MAP", type=_MAP)]
    goals: Annotated[tuple[str, ...], Option("A goal, such as 12.5,3.0.", "--goal", metavar="PLACE")]
    rate: Annotated[str, Option("Plans a second, such as 10Hz.", metavar="RATE")]
    boards: Annotated[str | None, Option(
        "Boards to ask about: names or files.  [default: all]", metavar="NAME,..."
    )] = None
    power: Annotated[str | None, Option("Most mean power at that rate, such as 5W.", metavar="POWER")] = None
    price: Annotated[str | None, Option("Most that a board may cost, such as 200USD.", metavar="PRICE")] = None
    clearance: Annotated[str | None, Option("Distance to keep from obstacles, such as 0.3m.", metavar="LENGTH")] = None
    starts: Annotated[tuple[str, ...], Option("A start.  [default: 64 are drawn]", "--start", metavar="PLACE")] = ()
    task: Annotated[Literal["path", "field", "replan"], Option("What is asked of a plan.")] = "path"
    change: Annotated[int, Option(
        "Cells that change before a plan of task replan, drawn.", type=click.IntRange(min=1), metavar="COUNT"
    )] = 20
    reach: Reach = None
    unknown: Annotated[Literal["blocked", "free"] | None, Option("What unknown cells count as.")] = None
    resolution: Annotated[str | None, Option(
        "Size of a cell, for a map that does not say it.", metavar="LENGTH"
    )] = None
    budget: Annotated[float | None, Option(
        "Computing time after which no further design is begun.  [default: 45]", type=click.FloatRange(min=0),
        metavar="SECONDS"
    )] = None
    write: Annotated[Path | None, Option(
        "Write the workload of the winner into this folder.", type=_FOLDER, metavar="FOLDER"
    )] = None
    as_json: Annotated[bool, Option("Print the answer as JSON.", "--json")] = False
    force: Force = False


_Csv = Annotated[Path | None, Option("Write every computed point as CSV.")]
_Parquet = Annotated[Path | None, Option(
    "Write every computed point as a Parquet file, for pandas, Polars and DuckDB."
)]
_StudyPage = Annotated[Path | None, Option("Write a self-contained HTML page.", "--html")]
_Certificate = Annotated[Path | None, Option(
    "Write the certificate of the front: why each design off it is off it. hwsw verify-front checks it.", "--certify"
)]
_StudyDetail = Annotated[str, Detail(
    "Print the sentence alone.", "Print the best points, every point and the sources of the figures too."
)]


class Explore(Request):
    """Evaluate every point of WORKLOAD's exploration on PLATFORM, and print the front, after one sentence.

    Finished points are kept in one file. The command continues from that file when it runs again.

    Leave PLATFORM out where the workload has an axis platform, or with --axis platform=NAME,FILE.yaml.

    --axis and --condition replace the axis of that name in the file, or add one. --need adds a constraint.

    The exit code is 3 where no design is feasible.
    """

    specs: Annotated[tuple[str, ...], Argument("[PLATFORM] WORKLOAD")]
    store: Annotated[Path | None, Option(
        "The SQLite file of finished points.  [default: PLATFORM-WORKLOAD.sqlite]"
    )] = None
    settings: Annotated[Mapping[str, Any], settings("Set an axis for all points.")] = NOTHING
    axes: Annotated[Mapping[str, Any], axes(
        "Explore these values: a,b,c, or a range 1..8, 10MHz..100MHz:10MHz (step), 1..1024*2 (factor) or '10MHz..1GHz"
        " in 12 log' (count); 'a,b when OTHER=VALUE': where another axis has this value alone.", "--axis"
    )] = NOTHING
    conditions: Annotated[Mapping[str, Any], axes(
        "Run every design in these conditions; written as --axis.", "--condition"
    )] = NOTHING
    needs: Needs = ()
    workers: Annotated[int, Option(
        "The number of worker processes.", type=click.IntRange(1, 256), show_default="the number of cores"
    )] = os.cpu_count() or 1
    cluster: Annotated[str | None, Option(
        "Compute with the workers of a dask cluster: tcp://HOST:PORT, tls://HOST:PORT, or the scheduler's file.",
        metavar="ADDRESS"
    )] = None
    memory: Memory = None
    points: Annotated[int | None, Option(
        "Compute no more than N points.", type=click.IntRange(min=1), metavar="N"
    )] = None
    time_ms: Annotated[int | None, Option(
        "Begin no point after this time, such as 10min.", "--time",
        type=Quantity(Dimension.TIME, scale=10**9, least=1), metavar="TIME"
    )] = None
    search: Annotated[str | None, Option(
        "Compute what a search asks for, and as many random points beside it: nsga2, tpe (extra search), random, or"
        " bound, which proves the front; all: no search. --points N limits each. All points of a small space are"
        " computed instead, where they take few simulations: exact, and cheaper than bound.  [default: explore.search"
        " of the workload]", metavar="NAME"
    )] = None
    seed: Annotated[int | None, Option("The seed of --search: the same seed, the same designs.", metavar="S")] = None
    check: Annotated[int | None, Option(
        "Run N random points alone too, and compare every figure with the study, to the last bit.",
        type=click.IntRange(min=1), metavar="N"
    )] = None
    csv: _Csv = None
    parquet: _Parquet = None
    page: _StudyPage = None
    certificate: _Certificate = None
    force: Force = False
    detail: _StudyDetail = ANSWER
    debug: Debug = False
    as_json: Annotated[bool, Option("Print every point, feasible or not, as JSON.", "--json")] = False


class Explain(Request):
    """Say why a design takes its time and its energy, why it is out, what is better, and how sure that is.

    With a file of hwsw explore and the INDEX of a design: the design among its neighbours. With PLATFORM and WORKLOAD:
    the run, and what it is with each lever and each next value. Each lever is run by itself, for the whole design.

    The exit code is 3 where the design is not feasible.
    """

    what: Annotated[str, Argument("STUDY|PLATFORM")]
    which: Annotated[str, Argument("INDEX|WORKLOAD")]
    settings: Annotated[Mapping[str, object], settings("Of a run: set an axis, e.g. fabric.clock=50MHz.")] = NOTHING
    conditions: Annotated[Mapping[str, object], settings(
        "Of a study: in one condition, by its value, or by its number in the list, from 0.", "--condition"
    )] = NOTHING
    detail: Annotated[str, Detail("Print the sentence alone.", "Print all parts, levers and neighbours.")] = ANSWER
    debug: Debug = False
    as_json: Annotated[bool, Option("Print the explanation as JSON.", "--json")] = False


class Compare(Request):
    """Simulate each PLATFORM:WORKLOAD and print the figures side by side.

    Each design plans on the map of its own workload. With --on, or --map with --goal and --start, all designs are asked
    the same on one map. By default the shipped designs of harmonic control, wavefront, breadth-first search and
    relaxation on a host are compared on the labyrinth. Where a design cannot use the map, its column says why, and the
    others still run.

    The exit code is 3 where no design is feasible, or none meets every --need, and 1 where none could run.
    """

    designs: Annotated[tuple[str, ...], Argument("[PLATFORM:WORKLOAD]...")] = ()
    like: Annotated[str | None, Option(
        "Use the map, goals and starts of this workload in every design.  [default: of each design its own; labyrinth"
        " without designs]", "--on", metavar="WORKLOAD"
    )] = None
    map_file: Annotated[Path | None, Option("Use this map in every design.", "--map", type=_INPUT)] = None
    goal: Annotated[Place | None, Option("The goal on --map.", **PLACE)] = None
    start: Annotated[Place | None, Option("The start on --map.", **PLACE)] = None
    reach: Reach = None
    task: Annotated[Literal["path", "field", "replan"] | None, Option(
        "What is asked of every design.  [default: that of the workload; path on --map]"
    )] = None
    settings: Annotated[Mapping[str, object], settings("Set an axis, in every design that has it.")] = NOTHING
    needs: Needs = ()
    memory: Memory = None
    detail: Annotated[str, Detail(
        "Print a sentence for each design alone.", "Print all tables of each design after the comparison."
    )] = ANSWER
    debug: Debug = False
    page: Page = None
    as_json: Annotated[bool, Option("Print the results as JSON.", "--json")] = False
    force: Force = False


class Report(Request):
    """Write the tables, the CSV and the HTML page of the exploration in STORE. Nothing is simulated.

    --need judges the designs anew, with a further constraint. The exit code is 3 where none is feasible.
    """

    store: _Store
    conditions: Annotated[Mapping[str, object], settings(
        "Show one condition by itself: by its value, or by its number in the list, from 0.", "--condition"
    )] = NOTHING
    needs: Needs = ()
    csv: _Csv = None
    parquet: _Parquet = None
    page: _StudyPage = None
    certificate: _Certificate = None
    force: Force = False
    detail: _StudyDetail = ANSWER
    debug: Debug = False
    as_json: Annotated[bool, Option("Print every point as JSON.", "--json")] = False


class Plot(Request):
    """Draw a picture as PDF, SVG or PNG, by the end of the name of the file.

    The same input gives the same bytes. A PDF embeds its fonts, and its texts stay texts. In Python the functions of
    codesign.views.report return the same pictures as figures of matplotlib.
    """


_Picture = Annotated[Path, Option("The file: .pdf, .svg or .png.", "-o", "--output")]
_Width = Annotated[float | None, Option(
    "The width in mm, such as 88 for a column; letters keep their size.  [default: 150 to 230]",
    type=click.FloatRange(20, 1000), metavar="MM"
)]
_OfRun = Annotated[tuple[str, ...], Argument("TRACE | PLATFORM WORKLOAD")]


class PlotFront(Request):
    """Draw the feasible designs of STORE by two figures, and the front among them. Nothing is simulated."""

    store: _Store
    output: _Picture
    width: _Width = None
    force: Force = False
    x: Annotated[str | None, Option(
        "The figure to the right.  [default: the first objective]", metavar="FIGURE"
    )] = None
    y: Annotated[str | None, Option("The figure upwards.  [default: the second objective]", metavar="FIGURE")] = None
    colour: Annotated[str, Option(
        "The figure that colours the points, or none.", metavar="FIGURE"
    )] = "share_reaching_goal"
    marker: Annotated[str | None, Option(
        "The axis that shapes the points.  [default: the part]", metavar="AXIS"
    )] = None
    conditions: Annotated[Mapping[str, object], settings("Draw one condition by itself.", "--condition")] = NOTHING
    needs: Needs = ()


class PlotMap(Request):
    """Draw the map of WORKLOAD with its goals and starts.

    Of a TRACE, or of a run of WORKLOAD on PLATFORM, draw the field and the paths of the plan, or what the robots drove.
    """

    specs: Annotated[tuple[str, ...], Argument("WORKLOAD | TRACE | PLATFORM WORKLOAD")]
    output: _Picture
    width: _Width = None
    force: Force = False
    at: Annotated[int | None, Option("Of a mission, the moment to draw, such as 12s.", type=_TIME)] = None


class PlotTimeline(Request):
    """Draw when each component and link was busy, from TRACE, or from a run of WORKLOAD on PLATFORM."""

    specs: _OfRun
    output: _Picture
    width: _Width = None
    force: Force = False


class PlotSchedule(Request):
    """Draw the precision of each stage over time, and the local maxima left.

    They are those of TRACE, or of a run of WORKLOAD on PLATFORM. Stages are those of harmonic control.
    """

    specs: _OfRun
    output: _Picture
    width: _Width = None
    force: Force = False


class VerifyFront(Request):
    """Check the certificate in FILE: whether its front follows from the figures stated. Nothing is simulated.

    What the certificate says and nothing in it shows is counted as taken on trust.

    The exit code is 3 where it is refused, and 1 where FILE cannot be read as a certificate.
    """

    file: Annotated[Path, Argument(type=_INPUT)]
    store: Annotated[Path | None, Option(
        "Check too that it is the certificate of the exploration in this store.", type=_INPUT
    )] = None
    conditions: Annotated[Mapping[str, object], settings(
        "With --store: the condition that it was written for, as in hwsw report.", "--condition"
    )] = NOTHING
    needs: Needs = ()
    complete: Annotated[bool, Option("Refuse it where designs were not computed.")] = False
    as_json: Annotated[bool, Option("Print the verdict as JSON.", "--json")] = False


class Trace(Request):
    """Read an MCAP trace of hwsw run --trace FILE."""


class TraceInfo(Request):
    """Print the contents of the trace FILE: its run, time span, topics and numbers of messages."""

    file: _Trace
    as_json: Json = False


class TraceShow(Request):
    """Print the records of the trace FILE in order of time, and the last field of a plan.

    With --at: the true map at that time, the robot's belief, its path and its position.
    """

    file: _Trace
    topics: Annotated[tuple[str, ...], Option("Only this topic. May be repeated.", "--topic")] = ()
    begin: _From = 0
    end: _To = None
    at: Annotated[int | None, Option(
        "Print the map at this simulated time instead of the records.", type=_TIME
    )] = None
    picture: Annotated[Path | None, Option("Draw the map of --at as a PNG or SVG.")] = None
    limit: Annotated[int, Option("The most lines to print.", type=click.IntRange(1))] = 200
    as_json: Annotated[bool, Option("Print each line as JSON.", "--json")] = False
    force: Force = False


class TraceExport(Request):
    """Export the trace FILE for other tools."""

    file: _Trace
    perfetto: Annotated[Path | None, Option("Write a trace of Perfetto, for ui.perfetto.dev.")] = None
    vcd: Annotated[Path | None, Option("Write a waveform, with a save file of GTKWave beside it.")] = None
    poses: Annotated[Path | None, Option("Write the positions and times of each robot as CSV.")] = None
    page: Annotated[Path | None, Option("Write the page of the run, which plays it.", "--html")] = None
    bag: Bag = None
    bag_begin: Annotated[int, Option(
        "When the run begins in the bag, in seconds since 1970.", "--ros2-begin", type=click.IntRange(0, 2 * 10**9),
        metavar="SECONDS"
    )] = 0
    begin: Annotated[int, Option("Of the waveform: only from this simulated time.", "--from", type=_TIME)] = 0
    end: Annotated[int | None, Option("Of the waveform: only up to this simulated time.", "--to", type=_TIME)] = None
    force: Force = False


class TraceLayout(Request):
    """Write a layout for the trace FILE: the topics that it has, in panels, seen from above, with plots and events."""

    file: _Trace
    output: Annotated[Path | None, Option(
        "The file to write.  [default: FILE with the ending .json, or .rbl for Rerun]", "-o", "--output"
    )] = None
    viewer: Annotated[Literal["foxglove", "ros2", "rerun"], Option(
        "A layout for Foxglove and Lichtblick, of the trace or of its ROS 2 bag; a blueprint for Rerun."
    )] = "foxglove"
    force: Force = False


class TraceStats(Request):
    """Print of the trace FILE how busy each component and link was, and how long messages, tasks and plans took."""

    file: _Trace
    as_json: Json = False


class TraceDiff(Request):
    """Print where the traces FIRST and SECOND differ first in simulated time, then all that differs.

    The exit code is 0 where all records are equal, and 3 where they differ.
    """

    first: _Trace
    second: _Trace
    as_json: Json = False


class TraceTimeline(Request):
    """Print the trace FILE as a Gantt chart: when each component and link worked, and the events of a mission."""

    file: _Trace
    begin: _From = 0
    end: _To = None
    width: Annotated[int | None, Option(
        "Columns; by default those of the terminal.", type=click.IntRange(60, 1000)
    )] = None


class FromBags(Request):
    """Make workloads of recordings."""


_METRE = click.FloatRange(0, 1000)


def _topic(topic: str) -> Option:
    words = f"Read this as {topic}; none leaves it out.  [default: by type and namespace]"
    return Option(words, metavar="TOPIC")


class FromBag(Request):
    """Make a workload of the run in BAG, a folder of a ROS 2 bag or its .mcap or .db3 file.

    It writes NAME.yaml (the workload), NAME-map.yaml and NAME-map.pgm (the map, as map_server has it), and
    NAME-goals.csv (what the recorded planner answered, and when). No file is overwritten.

    The bag needs /map, and the place of the robot: /tf with /tf_static, or /odom. /goal_pose gives the goals, /scan the
    obstacles and the sensor, /plan the recorded answers, /cmd_vel the period of the control loop. Topics of other names
    are found by their type; of several robots --namespace names one.
    """

    bag: Annotated[Path, Argument(type=_ANY)]
    folder: Annotated[Path, Option(
        "Write the files here.  [default: the current folder]", "-o", "--out", type=_FOLDER, metavar="DIR"
    )] = Path()
    name: Annotated[str | None, Option("Name of the workload and its files.  [default: that of the bag]")] = None
    like: Annotated[str, Option("Take planner and mapping of this workload.", metavar="WORKLOAD")] = "warehouse"
    platform: Annotated[str | None, Option(
        "Run the workload on this platform, and compare the answers.", "--on", metavar="PLATFORM"
    )] = None
    use_map: Annotated[Literal["first", "last"], Option("Which of several different maps is used.")] = "last"
    namespace: Annotated[str | None, Option(
        "Read the topics of the robot in this namespace.  [default: the one that the bag has]", metavar="NAMESPACE"
    )] = None
    base_frame: Annotated[str | None, Option(
        "Frame of the robot.  [default: that of the odometry]", metavar="FRAME"
    )] = None
    near: Annotated[float, Option("A goal is reached this near to it.", type=_METRE, metavar="METRES")] = 0.3
    slot: Annotated[int, Option(
        "Obstacles: cut time into slots so long.  [default: 1 s]", type=Quantity(Dimension.TIME, least=10**11),
        metavar="TIME"
    )] = 10**12
    margin: Annotated[float, Option(
        "Obstacles: leave out hits this near to an obstacle of the map.", type=_METRE, metavar="METRES"
    )] = 0.15
    radius: Annotated[float, Option(
        "Obstacles: cells this near to the robot are free.", type=_METRE, metavar="METRES"
    )] = 0.2
    least: Annotated[int, Option("Obstacles: leave out fewer hits.", type=click.IntRange(1))] = 3
    stay: Annotated[int | None, Option(
        "Obstacles: one that is not seen again stays so long.  [default: to the end]", type=_TIME, metavar="TIME"
    )] = None
    map_topic: Annotated[str | None, _topic("/map")] = None
    tf_topic: Annotated[str | None, _topic("/tf")] = None
    tf_static_topic: Annotated[str | None, _topic("/tf_static")] = None
    scan_topic: Annotated[str | None, _topic("/scan")] = None
    odom_topic: Annotated[str | None, _topic("/odom")] = None
    goal_topic: Annotated[str | None, _topic("/goal_pose")] = None
    plan_topic: Annotated[str | None, _topic("/plan")] = None
    command_topic: Annotated[str | None, _topic("/cmd_vel")] = None


class Reproduce(Request):
    """Print published and modelled figures row by row, with the error and the source of each figure.

    Each PLANNER selects the paper of that planner. Without one, all papers are reproduced.

    With --set, head and rows say which settings are not the published ones.
    """

    names: Annotated[tuple[str, ...], Argument("[PLANNER]...")] = ()
    quick: Annotated[bool, Option("Simulate fewer and smaller maps.")] = False
    page: Annotated[Path | None, Option("Write an HTML page with plots.", "--html")] = None
    plots: Annotated[Path | None, Option("Write the plots into this folder.", type=_FOLDER)] = None
    csv: Annotated[Path | None, Option("Write the rows as CSV.")] = None
    settings: Annotated[Mapping[str, object], settings(
        "Move a setting of the papers' runs; see --settings.", metavar="NAME=VALUE"
    )] = NOTHING
    listed: Annotated[bool, Option("List the settings that --set moves, and run nothing.", "--settings")] = False
    detail: Annotated[str, Detail(
        "Print the findings alone.", "Print the sources of the modelled figures too."
    )] = ANSWER
    debug: Debug = False
    as_json: Annotated[bool, Option("Print rows and findings as JSON.", "--json")] = False
    force: Force = False


class Calibrate(Request):
    """Fit costs to this machine, or laws to the reports of your FPGA tool, for platform files."""


class CalibrateHost(Request):
    """Time the planners' kernels on this machine, and print them as the key costs of a processor in a platform file."""

    seconds: Annotated[float, Option("The approximate time to measure.")] = 2.0
    as_json: Json = False


class CalibrateFpga(Request):
    """Show what reports of your FPGA tool say beside what the laws predict, and fit a factor to each term.

    The reports are those of Vivado, ISE, Quartus, Diamond, Radiant, Gowin EDA, Yosys and nextpnr, as text or JSON. All
    are of the design point PLATFORM WORKLOAD (names or YAML files). Without these, each report is of the design whose
    manifest.json, by hwsw rtl, stands in its folder or above.

    With -o, the factors are written as a calibration. Name it in your platform, with the key calibration of the FPGA:
    results then say the calibrated numbers, and cite it.
    """

    specs: Annotated[tuple[str, ...], Argument("[PLATFORM WORKLOAD]")] = ()
    reports: Annotated[tuple[Path, ...], Option(
        "A report of utilisation, timing or power. May be repeated.", "--report", type=_ANY, metavar="FILE"
    )]
    settings: Annotated[tuple[str, ...], Option(
        "Set an axis of the design point.", "--set", metavar="AXIS=VALUE"
    )] = ()
    clock: Annotated[str | None, Option("The clock of the design, where a report has several.", metavar="NAME")] = None
    added_to: Annotated[Path | None, Option(
        "A calibration; its samples are taken too.", "--with", metavar="FILE"
    )] = None
    output: Annotated[Path | None, Option(
        "Write the calibration, such as calibrations/mine.yaml.", "-o", "--output", metavar="FILE"
    )] = None
    reasons: Annotated[tuple[str, ...], Option(
        "Accept reports of TERM, such as lut4, that differ from the law by more than a factor of 2. May be repeated.",
        "--explain", metavar="TERM=REASON"
    )] = ()
    as_json: Annotated[bool, Option("Print the comparison as JSON.", "--json")] = False
    force: Force = False


class Rtl(Request):
    """Write the circuit of WORKLOAD on PLATFORM into the folder DIR, as Verilog that any tool takes.

    The folder has the Verilog of the design point, a self-checking test bench for Icarus and Verilator, the images of
    its memories, the stream with the map, the clock constraint for the tools of the part, golden vectors with a test
    for cocotb, a core file for FuseSoC, and a README. The same design point gives the same bytes.

    The folder is written whole or not at all.
    """

    specs: _Design
    point: _Point = None
    settings: Settings = NOTHING
    folder: Annotated[Path, Option(
        "Write into this folder, which is made.", "-o", "--output", type=_ANY, metavar="DIR"
    )]
    force: Annotated[bool, Option(
        "Write into a folder that is not empty: replace the files of this command there."
    )] = False
    debug: Debug = False


class Verify(Request):
    """Simulate the circuit of WORKLOAD on PLATFORM, and compare all that it reports with the model.

    Every event is compared in its kind, its value and its cycle, every phase in its cycles, and a display in every
    cycle. A difference is printed with its first cycle.

    With --all, random design points on random maps are verified. Sample S is the same for the same seed S.

    The exit code is 3 where a circuit differs from the model, and 1 where a run fails.
    """

    specs: Annotated[tuple[str, ...], Argument("[PLATFORM WORKLOAD | STUDY]")] = ()
    point: Annotated[int | None, Option("Verify this point of STUDY, a file of hwsw explore.", metavar="INDEX")] = None
    settings: Settings = NOTHING
    every: Annotated[bool, Option("Verify random design points of every style that has a circuit.", "--all")] = False
    planners: Annotated[tuple[str, ...], Option("With --all: only the circuits of this planner.", "--planner")] = ()
    points: Annotated[int | None, Option(
        "With --all: points of each style.  [default: 3]", type=click.IntRange(1, 10_000), metavar="N"
    )] = None
    seed: Annotated[int | None, Option(
        "With --all: the first seed.  [default: 0]", type=click.IntRange(0), metavar="S"
    )] = None
    backend: _Backend = "auto"
    jobs: Annotated[int, Option("Points verified at a time.", type=click.IntRange(1, 256))] = 1
    waves: Annotated[Path | None, Option(
        "Write the waveform around the first difference (VCD, for GTKWave), circuit and model above each other."
    )] = None
    cycles: Annotated[tuple[int, int] | None, Option(
        "With --waves: write these cycles, whether or not they differ.", type=click.IntRange(0), nargs=2,
        metavar="FIRST LAST"
    )] = None
    debug: Debug = False
    as_json: Annotated[bool, Option("Print every point as JSON.", "--json")] = False
    force: Force = False


class Synth(Request):
    """Synthesise the circuit of WORKLOAD on PLATFORM by Yosys, and hold the laws against what it takes.

    LUT, flip-flops, block RAMs and multipliers are counted by module, and by line of the demand.

    With --place, nextpnr places and routes the circuit: parts of the families ECP5, GW2A and GW1N. What was made once
    is kept in the cache.
    """

    specs: _Design
    point: _Point = None
    settings: Settings = NOTHING
    family: Annotated[str | None, Option(
        "Synthesise for another family than that of the part.", metavar="NAME"
    )] = None
    placing: Annotated[bool, Option("Place and route too: the clock and its critical path.", "--place")] = False
    seeds: Annotated[int | None, Option(
        "With --place: place N times, from seed 1 on, and take the median.  [default: 1]", type=click.IntRange(1, 100),
        metavar="N"
    )] = None
    debug: Debug = False
    as_json: Annotated[bool, Option("Print all figures as JSON.", "--json")] = False


class Fidelity(Request):
    """Compare what the laws predict with circuits that were simulated, synthesised and placed, and with papers.

    Circuits of random design points are simulated here. The rows of synthesis and placement are those that the package
    holds: hwsw synth makes such rows of one design point.

    What does not match is listed with its reason, and with the experiment that would settle it.
    """

    page: Annotated[Path | None, Option("Write the page, in Markdown.", "-o", "--output")] = None
    picture: Annotated[Path | None, Option("Write the picture of law over measured, as SVG.")] = None
    quick: Annotated[bool, Option("Simulate fewer design points of each circuit.")] = False
    jobs: Annotated[int, Option("Simulations at a time.", type=click.IntRange(1, 64))] = 1
    backend: _Backend = "auto"
    debug: Debug = False
    as_json: Annotated[bool, Option("Print everything that is compared as JSON.", "--json")] = False
    force: Force = False


class Check(Request):
    """Check FILES (YAML files, or names of shipped platforms and workloads), and report all faults with their places.

    A platform and a workload are checked against each other too, with the map, its goals and each variant. A run that
    would need too much memory is a fault. Without --json, notes report where a design does different work from what its
    parameters suggest.
    """

    files: Annotated[tuple[str, ...], Argument()]
    settings: Settings = NOTHING
    memory: Memory = None
    as_json: Annotated[bool, Option("Print the faults as JSON.", "--json")] = False


class Map(Request):
    """Show the map in FILE, or a shipped map by its name, as a workload with these steps would plan on it.

    Rows are counted from 0 at the top, columns from 0 at the left. Metres are those of map_server: x to the right, y
    up. Cropping keeps both.
    """

    file: Annotated[Path, Argument(type=MapFile(path_type=Path))]
    unknown: Annotated[str | None, Option(
        "What a cell counts as that the map says nothing about.", metavar="blocked|free"
    )] = None
    inflate: Annotated[str | None, Option(
        "Block cells this near to an obstacle: '0.3 m' or '6 cells'.", metavar="RADIUS"
    )] = None
    downsample: Annotated[int | None, Option("Join N × N cells to one.", metavar="N")] = None
    crop: Annotated[str | None, Option("The part of the map that is shown.", metavar="none|free|reachable")] = None
    resolution: Annotated[str | None, Option(
        "Metres a cell, where the map does not say so: '5 cm'.", metavar="LENGTH"
    )] = None
    at: Annotated[Place | None, Option(
        "Find the nearest free cell: 40,60 is a cell, 12.5,3.0 are metres.", **PLACE
    )] = None
    png: Annotated[Path | None, Option("Write the part shown as an image.")] = None
    as_json: Annotated[bool, Option("Print the figures as JSON.", "--json")] = False
    force: Force = False


class Schema(Request):
    """Print the JSON Schema of a platform, workload, part, host or calibration file, or of the output of --json.

    The output is a result (hwsw run), a study (hwsw explore), an explanation (hwsw explain), an advice (hwsw advise) or
    a reproduction (hwsw reproduce).
    """

    kind: Annotated[Literal[
        "platform", "workload", "part", "host", "calibration", "result", "study", "explanation", "reproduction",
        "advice"
    ], Argument()]


class List(Request):
    """List the shipped platforms, parts, hosts and workloads, and the installed planners and styles.

    With PLANNER, list the parameters of that planner: task, name, accepted values, default and meaning; its styles, and
    its policies for planning again.
    """

    planner: Annotated[str | None, Argument()] = None
    as_json: Json = False


class Show(Request):
    """Print the shipped platform, part, workload or map NAME. Its path is a comment on standard error.

    Where files of several kinds have one name, write platform:NAME, part:NAME, workload:NAME or map:NAME.
    """

    name: Annotated[str, Argument()]
    path_only: Annotated[bool, Option("Print the path of the file alone.", "--path")] = False


class Init(Request):
    """Write my-platform.yaml and my-workload.yaml into FOLDER, ready to run and to edit.

    Without options: harmonic control of a labyrinth on virtex4-pci. With an option, the workload has the first style
    and parameters of the planner that fit the board and the map. Without --goal, the goal is the free cell nearest to
    the middle of the map, in its largest connected area. No file is overwritten.
    """

    folder: Annotated[Path, Argument(type=_FOLDER)] = Path()
    board: Annotated[str | None, Option("Begin with this shipped platform.", metavar="PLATFORM")] = None
    planner: Annotated[str | None, Option("Plan with this planner.")] = None
    map_file: Annotated[Path | None, Option(
        "Plan on this map: a file, or the name of a shipped one.", "--map", type=_MAP
    )] = None
    goal: Annotated[Place | None, Option("The goal on the map.", **PLACE)] = None


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
    "trace": Command(Trace, "", "Read the trace of a run."),
    "trace info": Command(TraceInfo, "trace:info", "Print the contents of a trace."),
    "trace show": Command(TraceShow, "trace:show", "Print the records of a trace."),
    "trace export": Command(TraceExport, "trace_views:export", "Export a trace for other tools."),
    "trace layout": Command(TraceLayout, "trace_views:layout", "Write the layout of a viewer for a trace."),
    "trace stats": Command(TraceStats, "trace_views:stats", "Print how busy all was, and how long things took."),
    "trace diff": Command(TraceDiff, "trace_views:diff", "Compare two traces."),
    "trace timeline": Command(TraceTimeline, "trace_views:timeline", "Print a Gantt chart."),
    "workload": Command(FromBags, "", "Make a workload of a recorded ROS 2 bag."),
    "workload from-bag": Command(FromBag, "workload:from_bag", "Make a workload of a ROS 2 bag."),
    "reproduce": Command(Reproduce, "reproduce:reproduce", "Compare the model with the published tables, row by row."),
    "calibrate": Command(Calibrate, "", "Fit costs to this machine, or laws to the reports of your FPGA tool."),
    "calibrate host": Command(CalibrateHost, "calibrate:host", "Measure the cost of each kernel on this machine."),
    "calibrate fpga": Command(
        CalibrateFpga, "calibrate:fpga", "Fit the laws of a style to reports of your FPGA tool."
    ),
    "rtl": Command(Rtl, "rtl:rtl", "Write the Verilog of a design point, with its test bench and memory images."),
    "verify": Command(Verify, "rtl:verify", "Compare circuits in Verilog with the model, cycle for cycle."),
    "synth": Command(
        Synth, "synth:synth", "Synthesise a circuit with open tools, place and route it, and compare it with the laws."
    ),
    "fidelity": Command(
        Fidelity, "fidelity:fidelity",
        "Hold all laws against circuits that were simulated, synthesised and placed, and against papers."
    ),
    "check": Command(Check, "inspect:check", "Check platform and workload files, and report all faults at once."),
    "map": Command(Map, "map:map_", "Show a map: its size, free cells, components, and what cropping saves."),
    "schema": Command(
        Schema, "inspect:schema", "Print a JSON Schema, for editors and for programs that read the JSON output."
    ),
    "list": Command(
        List, "begin:list_",
        "List platforms, parts, hosts, workloads, planners and styles, or the parameters of a planner."
    ),
    "show": Command(Show, "begin:show", "Print a shipped platform, part, workload or map."),
    "init": Command(Init, "begin:init", "Write a first platform and workload, for a board, a planner and a map."),
}
"""Every command, in the order in which a newcomer needs them."""
