"""Tables I and II of Saudi and Sulaiman (2016): iterations k and execution time t on an area of 330 × 270."""

from __future__ import annotations

from dataclasses import dataclass

PAPER = "Saudi and Sulaiman 2016"

ROWS, COLUMNS = 270, 330
CELLS = ROWS * COLUMNS


@dataclass(frozen=True)
class Run:
    """One run: ``omega`` and ``r`` (None where the method has none), ``iterations`` k, ``seconds`` t."""

    omega: float | None
    r: float | None
    iterations: int
    seconds: float


GS = Run(None, None, 51454, 77.12)
"""Table I."""

AM = tuple(
    Run(omega, None, k, t)
    for omega, k, t in (
        (1.50, 18020, 68.95),
        (1.55, 15784, 61.37),
        (1.60, 13696, 53.59),
        (1.65, 11715, 45.42),
        (1.70, 9838, 38.23),
        (1.75, 8059, 31.09),
        (1.80, 6366, 25.00),
        (1.85, 4771, 18.72),
        (1.90, 3263, 13.01),
        (1.91, 2987, 11.56),
        (1.92, 2709, 10.52),
        (1.93, 2444, 9.58),
        (1.94, 2192, 8.74),
        (1.95, 1972, 7.84),
        (1.955, 1873, 7.53),
        (1.96, 1794, 7.00),
        (1.965, 1743, 6.70),
        (1.97, 1728, 6.70),
        (1.975, 1936, 7.61),
        (1.98, 2445, 9.55),
        (1.985, 3302, 13.03),
        (1.99, 4904, 19.08),
    )
)
"""Table I."""

MAM_COARSE = tuple(
    Run(omega, r, k, t)
    for omega, r, k, t in (
        (1.50, 1.55, 16830, 67.81),
        (1.55, 1.60, 14656, 57.45),
        (1.60, 1.65, 12617, 49.39),
        (1.65, 1.70, 10687, 42.59),
        (1.70, 1.75, 8846, 35.50),
        (1.75, 1.80, 7105, 27.86),
        (1.80, 1.85, 5427, 21.23),
        (1.85, 1.90, 3824, 15.16),
        (1.90, 1.95, 2220, 8.78),
    )
)
"""Table I."""

_R = (1.91, 1.92, 1.93, 1.94, 1.95, 1.96, 1.97, 1.98, 1.99)

_FINE: dict[float, tuple[tuple[int, ...], tuple[float, ...]]] = {
    1.95: (
        (2211, 2175, 2125, 2061, 1972, 1836, 1513, 1513, 1713),
        (8.75, 8.67, 8.37, 8.12, 7.86, 7.28, 5.97, 6.64, 6.84),
    ),
    1.955: (
        (2059, 2045, 2015, 1970, 1971, 1819, 1589, 1584, 1752),
        (8.03, 8.58, 7.89, 7.89, 7.97, 7.17, 6.24, 6.84, 6.92),
    ),
    1.96: (
        (1878, 1881, 1879, 1871, 1846, 1794, 1648, 1626, 1919),
        (7.45, 7.39, 7.37, 7.31, 7.20, 7.05, 6.50, 6.34, 7.52),
    ),
    1.965: (
        (1604, 1655, 1695, 1729, 1754, 1756, 1697, 1763, 2149),
        (6.30, 6.42, 6.59, 6.83, 6.89, 6.89, 6.64, 6.90, 8.28),
    ),
    1.97: (
        (1469, 1437, 1492, 1430, 1595, 1686, 1729, 1939, 2417),
        (5.78, 5.70, 5.86, 5.33, 6.17, 6.50, 6.61, 7.47, 9.41),
    ),
    1.975: (
        (1508, 1429, 1482, 1480, 1529, 1500, 1766, 2160, 2784),
        (5.89, 5.58, 5.84, 5.75, 5.94, 5.86, 6.91, 8.45, 2784.0),
    ),
}

MAM_FINE = tuple(
    Run(omega, r, k, t)
    for omega, (iterations, seconds) in _FINE.items()
    for r, k, t in zip(_R, iterations, seconds, strict=True)
)
"""Table II."""

MISPRINT = MAM_FINE[-1]
"""Its time is its number of iterations, copied."""

REDUCTIONS = {
    "AM against GS": ((64.99, 96.64), (10.59, 91.31)),
    "MAM against AM": ((6.60, 31.96), (1.65, 32.51)),
}
"""Table III: least and greatest reduction in %, of iterations and of time."""
