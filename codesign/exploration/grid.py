"""The combinations of the values of axes by their index: the last axis moves fastest."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.int64]


class Grid:
    """Every combination of the values of some axes.

    >>> grid = Grid({"a": (1, 2), "b": ("x", "y", "z")})
    >>> len(grid), grid.at(4), grid.places("a").tolist()
    (6, {'a': 2, 'b': 'y'}, [0, 0, 0, 1, 1, 1])
    """

    def __init__(self, axes: Mapping[str, tuple[Any, ...]]) -> None:
        self.axes = axes
        self.shape = tuple(len(values) for values in axes.values())
        self._steps = dict(
            zip(axes, [math.prod(self.shape[place + 1 :]) for place in range(len(axes))], strict=True)
        )

    def __len__(self) -> int:
        return math.prod(self.shape)

    def at(self, index: int) -> dict[str, Any]:
        """The value of each axis in one combination."""
        return {name: values[index // self._steps[name] % len(values)] for name, values in self.axes.items()}

    def step(self, name: str) -> int:
        """How far apart two combinations are that differ by one place on an axis."""
        return self._steps[name]

    def places(self, name: str, indices: NDArray[np.intp] | None = None) -> Numbers:
        """The number of the value of an axis, of all combinations or of some."""
        each = np.arange(len(self)) if indices is None else indices
        return np.asarray(each // self._steps[name] % len(self.axes[name]), np.int64)

    def values(self, name: str, indices: NDArray[np.intp] | None = None) -> Numbers:
        """As ``places``; of values that are equal as JSON, the number of the first."""
        texts = [json.dumps(value, sort_keys=True) for value in self.axes[name]]
        return np.array([texts.index(text) for text in texts], np.int64)[self.places(name, indices)]
