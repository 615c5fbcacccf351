"""Columns as a data frame of pandas, which loads when a frame is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from codesign.ground.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame


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
