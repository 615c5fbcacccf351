"""The values of options that name axes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from codesign.ground.errors import InputError, clip
from codesign.inputs import parse_value
from codesign.inputs.axes import axis_form


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
