"""``hwsw plot``: the pictures of the pages as files for papers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from codesign.cli.options import Quantity, force_option, need_option, settings_of
from codesign.errors import InputError, choose_hint, printable

if TYPE_CHECKING:
    from codesign.exploration import Study
    from codesign.figures import ResultFigure
    from codesign.progress import Show
    from codesign.records import Record
    from codesign.report import Picture

_Command = TypeVar("_Command", bound=Callable[..., object])

_NONE = "none"
_MCAP = b"\x89MCAP"


def _picture_options(command: _Command) -> _Command:
    """The options ``-o``, ``--width`` and ``--force``. The command gets ``output`` and ``width``, mm or None."""
    command = force_option(command)
    command = click.option(
        "--width",
        type=click.FloatRange(20, 1000),
        metavar="MM",
        help="The width in mm, such as 88 for a column; letters keep their size.  [default: 150 to 230]",
    )(command)
    return click.option(
        "-o",
        "--output",
        required=True,
        type=click.Path(dir_okay=False, path_type=Path),
        help="The file: .pdf, .svg or .png.",
    )(command)


_SPECS = click.argument("specs", metavar="TRACE | PLATFORM WORKLOAD", nargs=-1, required=True)


@click.group(short_help="Draw pictures for papers.")
def plot() -> None:
    """Draw a picture as PDF, SVG or PNG, by the end of the name of the file.

    The same input gives the same bytes. A PDF embeds its fonts, and its texts stay texts. In Python the functions of
    codesign.report return the same pictures as figures of matplotlib.
    """


@plot.command(short_help="Draw the front of a stored exploration.")
@click.argument("store", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@_picture_options
@click.option("--x", "x", metavar="FIGURE", help="The figure to the right.  [default: the first objective]")
@click.option("--y", "y", metavar="FIGURE", help="The figure upwards.  [default: the second objective]")
@click.option(
    "--colour",
    metavar="FIGURE",
    default="share_reaching_goal",
    show_default=True,
    help="The figure that colours the points, or none.",
)
@click.option("--marker", metavar="AXIS", help="The axis that shapes the points.  [default: the part]")
@click.option(
    "--condition", "conditions", multiple=True, metavar="AXIS=VALUE", help="Draw one condition by itself."
)
@need_option
def front(
    store: Path,
    output: Path,
    width: float | None,
    x: str | None,
    y: str | None,
    colour: str,
    marker: str | None,
    conditions: tuple[str, ...],
    needs: tuple[str, ...],
) -> None:
    """Draw the feasible designs of STORE by two figures, and the front among them. Nothing is simulated."""
    from codesign.exploration import load_study
    from codesign.report import front_picture

    chosen = settings_of(conditions, "--condition")

    def draw(show: Show) -> Picture:
        study = load_study(store, show).needing(needs).at(chosen)
        axes = sorted(study.every_axis)
        if marker is not None and marker not in axes:
            raise InputError(
                f"{printable(marker)} is no axis of the study", "--marker", choose_hint(marker, axes)
            )
        return front_picture(
            study,
            x=_figure(study, x, "--x"),
            y=_figure(study, y, "--y"),
            colour=None if colour == _NONE else _figure(study, colour, "--colour"),
            marker=marker,
        )

    _drawn(draw, output, width, (store,))


def _figure(study: Study, name: str | None, option: str) -> ResultFigure | None:
    """The figure of that name, or short name; None for None."""
    from codesign.figures import FIGURES, SHORT_NAMES

    if name is None:
        return None
    figures = {**FIGURES, **study.figures}
    full = SHORT_NAMES.get(name, name)
    if full not in figures:
        raise InputError(f"no figure {printable(name)}", option, choose_hint(name, sorted(figures)))
    return figures[full]


@plot.command("map", short_help="Draw the map of a workload, or of a run with its paths.")
@click.argument("specs", metavar="WORKLOAD | TRACE | PLATFORM WORKLOAD", nargs=-1, required=True)
@_picture_options
@click.option("--at", type=Quantity("time", "time"), help="Of a mission, the moment to draw, such as 12s.")
def map_(specs: tuple[str, ...], output: Path, width: float | None, at: int | None) -> None:
    """Draw the map of WORKLOAD with its goals and starts.

    Of a TRACE, or of a run of WORKLOAD on PLATFORM, draw the field and the paths of the plan, or what the robots drove.
    """
    import codesign
    from codesign.report import run_map_picture, workload_map_picture

    def draw(show: Show) -> Picture | None:
        if len(specs) == 1 and not _is_trace(specs[0]):
            if at is not None:
                raise InputError("a workload has no moments", "--at", "name a trace, or a platform too")
            return workload_map_picture(codesign.load_workload(specs[0]))
        records = _records(specs, show)
        return run_map_picture(records) if at is None else _moment(records, at, specs[0])

    _drawn(draw, output, width, specs)


def _moment(records: Iterable[Record], at: int, where: str) -> Picture:
    from codesign.report import moment_picture
    from codesign.trace import moment
    from codesign.trace.floor import UNKNOWN

    seen = moment(records, at, where)
    return moment_picture(
        seen.time,
        seen.start,
        seen.free,
        goals=seen.goals,
        corner=seen.corner,
        unknown=None if seen.belief is None else seen.belief == UNKNOWN,
        way=seen.path,
        driven=seen.driven,
        robots=seen.robots,
    )


@plot.command(short_help="Draw when components and links were busy.")
@_SPECS
@_picture_options
def timeline(specs: tuple[str, ...], output: Path, width: float | None) -> None:
    """Draw when each component and link was busy, from TRACE, or from a run of WORKLOAD on PLATFORM."""
    from codesign.report import run_timeline_picture

    _drawn(lambda show: run_timeline_picture(_records(specs, show)), output, width, specs)


@plot.command(short_help="Draw the stages of harmonic control.")
@_SPECS
@_picture_options
def schedule(specs: tuple[str, ...], output: Path, width: float | None) -> None:
    """Draw the precision of each stage over time, and the local maxima left.

    They are those of TRACE, or of a run of WORKLOAD on PLATFORM. Stages are those of harmonic control.
    """
    from codesign.report import schedule_picture

    _drawn(lambda show: schedule_picture(_records(specs, show)), output, width, specs)


def _is_trace(name: str) -> bool:
    """Whether the name is that of a trace by its ending, or of a file which begins as a trace does."""
    if name.endswith(".mcap"):
        return True
    try:
        with open(name, "rb") as file:
            return file.read(len(_MCAP)) == _MCAP
    except (OSError, ValueError):
        return False


def _records(specs: Sequence[str], show: Show) -> list[Record]:
    """The records of a trace, or those of a run of a workload on a platform."""
    import codesign
    from codesign.progress import doing
    from codesign.trace import MemoryListener, open_trace

    if len(specs) == 1 and _is_trace(specs[0]):
        return list(open_trace(specs[0], show).records())
    if len(specs) != 2:
        raise InputError(
            "needs a run", " ".join(specs), "name a trace of hwsw run --trace, or a platform and a workload"
        )
    memory = MemoryListener()
    doing(show, "simulating")
    result = codesign.simulate(*specs, listeners=(memory,), keeping=True)
    if not result.simulated:
        reasons = "; ".join(map(str, result.reasons))
        raise InputError(
            f"the design does not fit, so there is no run: {printable(reasons)}", " ".join(specs)
        )
    return list(memory.records)


def _drawn(
    draw: Callable[[Show], Picture | None], output: Path, width: float | None, inputs: Iterable[Any]
) -> None:
    """Draw a picture and write it. What names the output is checked before any work."""
    from codesign.cli.outputs import check_outputs
    from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
    from codesign.progress import plans_shown
    from codesign.report.canvas import format_of

    format_of(output, "--output")
    check_outputs({"--output": output}, inputs, kind="plot")
    with progress_shown(after_s=LATER_S) as show, compiling_shown(show), plans_shown(show):
        picture = draw(show)
        if picture is None:
            raise InputError(
                "there is nothing of this kind in the run", " ".join(map(str, inputs)), "choose another plot"
            )
        picture.write(output, width)
    click.echo(f"written: {printable(str(output), None)}")
