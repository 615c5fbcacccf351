"""The picture of an object in a notebook: a class derives from ``InNotebooks``, and the report makes the HTML.

The report stands above most classes that it shows, so it is not imported here: ``codesign`` itself, which every program
loads first, names the function that makes the HTML.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from codesign.ground.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame

# Columns as a data frame of pandas, which loads when a frame is asked for.


def data_frame(columns: Mapping[str, Sequence[Any]]) -> DataFrame:
    """A frame with these columns. A column of numbers with gaps (None) is one of doubles, with NaN there.

    Raises:
        InputError: pandas is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise InputError(
            "a data frame needs pandas", hint="pip install 'hwsw-codesign[frames]', or pip install pandas"
        ) from None
    return pandas.DataFrame({name: list(values) for name, values in columns.items()})


_html: list[Callable[[object], str]] = []


def show_with(html: Callable[[object], str]) -> None:
    """Let ``html`` make what notebooks show of every object that is ``InNotebooks``."""
    _html[:] = [html]


class InNotebooks:
    """A class whose objects a notebook shows as small tables."""

    def _repr_html_(self) -> str:
        """The object as a few lines of HTML, with bounded tables."""
        (html,) = _html
        return html(self)
