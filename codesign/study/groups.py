"""Rows of equal values: the one place where columns are grouped."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Groups:
    """Groups of rows, in the order of their values; the last column counts first.

    ``which``: the group of each row. ``firsts``: the first row of each group.
    """

    which: Indices
    firsts: Indices

    @classmethod
    def of(cls, *columns: NDArray[Any]) -> Groups:
        """The rows that are equal in all columns, of which there is at least one. Missing values (NaN) are equal.

        >>> groups = Groups.of(np.array([3, 1, 3]))
        >>> groups.which.tolist(), groups.firsts.tolist()
        ([1, 0, 1], [1, 0])
        """
        # In sorted order a group begins where any column differs from the row before (two NaN do not differ). The sum
        # of the begins up to a row, less 1, is the number of its group, which goes back to the place of the row.
        order = np.lexsort(columns)
        begins = np.ones(len(order), np.bool_)
        begins[1:] = False
        for column in columns:
            left, right = column[order[:-1]], column[order[1:]]
            begins[1:] |= (left != right) & ~(np.isnan(left) & np.isnan(right))
        which = np.empty(len(order), np.intp)
        which[order] = np.cumsum(begins) - 1
        return cls(which, order[begins])

    @cached_property
    def members(self) -> list[Indices]:
        """The rows of each group, rising."""
        # A stable sort by group keeps the rows of each in their order; the sums of the sizes are where to cut.
        ends = np.cumsum(np.bincount(self.which, minlength=len(self.firsts)))
        return np.split(np.argsort(self.which, kind="stable"), ends[:-1]) if len(ends) else []

    @property
    def in_turn(self) -> Groups:
        """The same groups in the order of their first rows."""
        order = np.argsort(self.firsts)
        number = np.empty(len(order), np.intp)
        number[order] = np.arange(len(order))
        return Groups(number[self.which], self.firsts[order])

    def least(self, values: NDArray[Any]) -> Indices:
        """The row of each group with the least value, of equals the first; one without a value where none has one."""
        # Sorted by group, then by value: the first row of each group has its least value.
        order = np.lexsort((values, self.which))
        return order[np.searchsorted(self.which[order], np.arange(len(self.firsts)))]
