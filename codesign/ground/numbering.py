"""Numbers for distinct values: of things that are met one by one, and of the entries or rows of an array."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

K = TypeVar("K")


class Numbering(dict[K, int]):
    """A number for each distinct thing, in the order in which they are met; ``[*numbering]`` has the things.

    >>> numbering = Numbering()
    >>> [numbering[text] for text in "abac"]
    [0, 1, 0, 2]
    """

    def __missing__(self, key: K) -> int:
        number = self[key] = len(self)
        return number


def distinct(values: NDArray[Any], axis: int | None = None) -> tuple[NDArray[Any], NDArray[np.intp]]:
    """The distinct entries of an array, rising, or its rows along an axis; and the number of each among them, 1-D.

    >>> used, numbers = distinct(np.array([7, 3, 7]))
    >>> used.tolist(), numbers.tolist()
    ([3, 7], [1, 0, 1])
    """
    used, numbers = np.unique(values, axis=axis, return_inverse=True)
    return used, numbers.reshape(-1).astype(np.intp, copy=False)
