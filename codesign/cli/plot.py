"""``hwsw plot``: the pictures of the pages as files for papers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import codesign
from codesign.cli.outputs import check_outputs
from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
from codesign.cli.requests import PlotFront, PlotMap, PlotSchedule, PlotTimeline
from codesign.ground.errors import InputError, choose_hint, printable
from codesign.ground.figures import FIGURES, SHORT_NAMES
from codesign.ground.progress import doing, plans_shown
from codesign.ground.records import MemoryListener
from codesign.study import load_study
from codesign.views.report import (
    front_picture,
    moment_picture,
    run_map_picture,
    run_timeline_picture,
    schedule_picture,
    workload_map_picture,
)
from codesign.views.report.canvas import format_of
from codesign.views.trace import moment, open_trace

if TYPE_CHECKING:
    from codesign.ground.figures import ResultFigure
    from codesign.ground.progress import Show
    from codesign.ground.records import Record
    from codesign.study import Study
    from codesign.views.report import Picture

_NONE = "none"
_MCAP = b"\x89MCAP"


def front(asked: PlotFront) -> None:
    """Draw the feasible designs of STORE by two figures, and the front among them. Nothing is simulated."""

    def draw(show: Show) -> Picture:
        study = load_study(asked.store, show).needing(asked.needs).at(asked.conditions)
        axes = sorted(study.every_axis)
        if asked.marker is not None and asked.marker not in axes:
            raise InputError(
                f"{printable(asked.marker)} is no axis of the study", "--marker", choose_hint(asked.marker, axes)
            )
        return front_picture(
            study,
            x=_figure(study, asked.x, "--x"),
            y=_figure(study, asked.y, "--y"),
            colour=None if asked.colour == _NONE else _figure(study, asked.colour, "--colour"),
            marker=asked.marker,
        )

    _drawn(draw, asked.output, asked.width, (asked.store,))


def _figure(study: Study, name: str | None, option: str) -> ResultFigure | None:
    """The figure of that name, or short name; None for None."""
    if name is None:
        return None
    figures = {**FIGURES, **study.figures}
    full = SHORT_NAMES.get(name, name)
    if full not in figures:
        raise InputError(f"no figure {printable(name)}", option, choose_hint(name, sorted(figures)))
    return figures[full]


def map_(asked: PlotMap) -> None:
    """Draw the map of WORKLOAD with its goals and starts."""

    def draw(show: Show) -> Picture | None:
        if len(asked.specs) == 1 and not _is_trace(asked.specs[0]):
            if asked.at is not None:
                raise InputError("a workload has no moments", "--at", "name a trace, or a platform too")
            return workload_map_picture(codesign.load_workload(asked.specs[0]))
        records = _records(asked.specs, show)
        if asked.at is None:
            return run_map_picture(records)
        return moment_picture(**moment(records, asked.at, asked.specs[0]).drawn)

    _drawn(draw, asked.output, asked.width, asked.specs)


def timeline(asked: PlotTimeline) -> None:
    """Draw when each component and link was busy, from TRACE, or from a run of WORKLOAD on PLATFORM."""
    _drawn(lambda show: run_timeline_picture(_records(asked.specs, show)), asked.output, asked.width, asked.specs)


def schedule(asked: PlotSchedule) -> None:
    """Draw the precision of each stage over time, and the local maxima left."""
    _drawn(lambda show: schedule_picture(_records(asked.specs, show)), asked.output, asked.width, asked.specs)


def _is_trace(name: str) -> bool:
    """True if the name is a trace's by its ending, or of a file which begins as a trace does."""
    if name.endswith(".mcap"):
        return True
    try:
        with open(name, "rb") as file:
            return file.read(len(_MCAP)) == _MCAP
    except (OSError, ValueError):
        return False


def _records(specs: Sequence[str], show: Show) -> list[Record]:
    """The records of a trace, or of a run of a workload on a platform."""
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
        raise InputError(f"the design does not fit, so there is no run: {printable(reasons)}", " ".join(specs))
    return list(memory.records)


def _drawn(draw: Callable[[Show], Picture | None], output: Path, width: float | None, inputs: Iterable[Any]) -> None:
    """Draw a picture and write it. What names the output is checked before any work."""
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
