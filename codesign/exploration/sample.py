"""Some points of a space, numbered anew: what a study holds of a space that is too large to hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.exploration.space import Space, canonical


class Sample(Space):
    """Some points of a space by their own numbers, 0 for the first of ``places``.

    ``places``: int64, the place of each in the enumeration of the whole space.

    >>> whole = Space({"relax.iterations": range(1000), "fpga.clock": ["100 MHz", "150 MHz"]}, "")
    >>> some = Sample(whole, np.array([7, 1999]))
    >>> len(some), some.values(1)
    (2, {'relax.iterations': 999, 'fpga.clock': '150 MHz'})
    """

    def __init__(self, whole: Space, places: NDArray[np.int64]) -> None:
        super().__init__(whole.axes, whole.fingerprint, whole.contents, whole.when)
        self.whole, self.places = whole, places
        self._rows = {place: number for number, place in enumerate(places.tolist())}

    @classmethod
    def of(cls, whole: Space, designs: Sequence[int], conditions: int = 1) -> Sample:
        """The points of designs, each in all conditions."""
        return cls(whole, points_of(designs, conditions))

    def __reduce__(self) -> tuple[type[Sample], tuple[Any, ...]]:
        return Sample, (self.whole, self.places)

    def __len__(self) -> int:
        return len(self.places)

    def values(self, index: int) -> dict[str, Any]:
        """The value of each axis that exists for a point."""
        if not 0 <= index < len(self):
            raise IndexError(f"no point {index} among {len(self)}")
        return self.whole.values(int(self.places[index]))

    def index(self, values: Mapping[str, Any]) -> int:
        """The number of the point with these values.

        Raises:
            KeyError: there is no such point, or it is none of these.
        """
        row = self._rows.get(self.whole.index(values))
        if row is None:
            raise KeyError(f"no point here has {canonical(dict(values))}")
        return row

    def levels(self, indices: NDArray[np.int64]) -> dict[str, NDArray[np.int32]]:
        """See ``Space.levels``."""
        return self.whole.levels(self.places[indices])


def points_of(designs: Sequence[int], conditions: int) -> NDArray[np.int64]:
    """The places of the points of designs, each in all conditions, in their order."""
    begins = np.array(designs, np.int64) * conditions
    return np.asarray((begins[:, None] + np.arange(conditions)).reshape(-1), np.int64)
