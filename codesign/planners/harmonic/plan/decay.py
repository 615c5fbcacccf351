"""A lower bound on the iterations of one block, from the slowest decay of its error.

Let e = L_b - h ≥ 0 be the error of the values h at precision b, and A the average over the four neighbours, on the
computed cells. As h' = floor((N + E + S + W) / 4) loses at most 3/4, e' ≥ A e - 3/4. With w = A w + 1 that is
e' + ¾w ≥ A (e + ¾w), so after k iterations e_k + ¾w ≥ A^k (e_0 + ¾w). Let φ ≥ 0 with A φ ≥ μ φ in every cell; A is
symmetric. The values have settled once e_k = 0, so

    ¾ φ·w ≥ μ^k (φ·e_0 + ¾ φ·w),    k ≥ ln(1 + φ·e_0 / (¾ φ·w)) / ln(1/μ).

φ comes from inverse iteration, so μ is close to the largest eigenvalue. Nothing rests on how close: μ is the least
ratio of A φ to φ, and w is enlarged until w ≥ A w + 1 holds. φ·e_0 is exact, in integers.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from codesign.planners.harmonic.plan.fixed_point import Field
    from codesign.planners.harmonic.plan.warm_start import FieldBounds

ROUNDS = 40
"""Rounds of inverse iteration."""

SCALE = 300
"""φ is taken in units of 2^-300: exact for every value above 2^-248."""

_SAFE = 1e-9
"""Relative room for the rounding of doubles, far above it."""


class Decay:
    """The slowest decay of a map as one block.

    ``bounds``: of the map and its goals.
    """

    def __init__(self, bounds: FieldBounds) -> None:
        from scipy.sparse.csgraph import connected_components

        average, self._cells = bounds.average, bounds.cells
        weights = np.ones(len(self._cells))
        for _ in range(ROUNDS):
            weights = np.maximum(bounds.solve(weights), 0.0)
            weights /= weights.max()
        # Goals may part the map: the component with the best ratio is taken, and the weights elsewhere are 0.
        count, component = connected_components(average, directed=False)
        ratios = np.full(count, np.inf)
        np.minimum.at(ratios, component, np.divide(average @ weights, np.maximum(weights, 2.0**-200)))
        best = int(np.argmax(ratios))
        self._rate = float(ratios[best]) - 1e-12
        weights = np.where(component == best, weights, 0.0)
        steps = bounds.noise
        steps = steps / (steps - average @ steps).min()
        self._loss = 0.75 * float(weights @ steps) * (1 + _SAFE)
        self._weights = np.array([int(math.ldexp(weight, SCALE)) for weight in weights], object)

    def sum_of(self, field: Field) -> int:
        """φ · h of a field, in units of 2^-SCALE."""
        values = field.to_ints().ravel()[self._cells]
        return int((self._weights * values).sum())

    def least_iterations(self, error: int) -> int:
        """A lower bound on the iterations of a stage: those that change a bit, and one that sees that none does.

        ``error``: φ · e_0, by ``sum_of``.
        """
        if error <= 0 or not 0.0 < self._rate < 1.0:
            return 1
        exponent = math.log(error) - SCALE * math.log(2) - math.log(self._loss)
        # ln(1 + x) ≥ ln x; the exact form where x is small enough for doubles.
        grown = math.log1p(math.exp(exponent)) if exponent < 100 else exponent
        return math.ceil(grown / -math.log(self._rate) * (1 - _SAFE)) + 1
