"""Platform and workload of a command: two files or names, or a point of a study; the values of its axes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import click

import codesign
from codesign import study
from codesign.ground.errors import InputError, clip
from codesign.ground.units import counted
from codesign.inputs import parse_value
from codesign.inputs.axes import axis_form

if TYPE_CHECKING:
    from codesign.inputs import Constraint, Platform, Workload
    from codesign.inputs.derived import DerivedFigure


@dataclass(frozen=True)
class Asked:
    """The demands of an exploration: its constraints, and the figures that it derives."""

    constraints: Sequence[Constraint] = ()
    figures: Mapping[str, DerivedFigure] = field(default_factory=dict)


def specs_of(specs: tuple[str, ...], point: int | None) -> tuple[Platform, Workload, Asked]:
    """Platform and workload, of two sources or of a point of a study; and what their exploration asks for."""
    if point is None:
        if len(specs) != 2:
            hint = "name a platform and a workload, or a file of hwsw explore with --point INDEX"
            raise InputError(f"{counted(len(specs), 'argument')}", _command(), hint)
        workload = codesign.load_workload(specs[1])
        section = workload.explore
        asked = Asked() if section is None else Asked(section.constraints, section.figures)
        return codesign.load_platform(specs[0]), workload, asked
    if len(specs) != 1:
        hint = "name the file of hwsw explore alone: the study holds platform and workload"
        raise InputError(f"{counted(len(specs), 'argument')}", f"{_command()} --point", hint)
    held = study.load_study(specs[0])
    platform, workload = held.point(point).specs()
    if held.specs is not None and held.specs.note:
        click.echo(f"note: {held.specs.note}", err=True)
    return platform, workload, Asked(held.constraints, held.figures)


def _command() -> str:
    return click.get_current_context().info_name or ""


def settings_of(texts: Iterable[str], option: str = "--set") -> dict[str, object]:
    """The raw value of each axis that the option names.

    Raises:
        InputError: a text is no setting, or an axis is set twice.
    """
    texts_by_axis = _by_axis(texts, option)
    return {axis: parse_value(value, f"{option} {axis}") for axis, value in texts_by_axis.items()}


def axes_of(texts: Iterable[str], option: str) -> dict[str, dict[str, Any]]:
    """Each axis that the option names, from lists and ranges: its ``values``, and what it depends on, ``when``.

    Raises:
        InputError: a text is no list of values of an axis, or an axis is set twice.
    """
    texts_by_axis = _by_axis(texts, option)
    return {axis: axis_form(values, f"{option} {axis}") for axis, values in texts_by_axis.items()}


def _by_axis(texts: Iterable[str], option: str) -> dict[str, str]:
    """The text behind each ``AXIS=``."""
    values: dict[str, str] = {}
    for text in texts:
        axis, separator, value = text.partition("=")
        if not separator or not axis:
            hint = f"write AXIS=VALUE, as in {option} relax.iterations=16"
            raise InputError(f"{clip(text)!r} is no setting", option, hint)
        if axis in values:
            raise InputError(f"{axis} is set twice", option, "keep one of the two")
        values[axis] = value
    return values
