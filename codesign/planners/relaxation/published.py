"""The numbers of Saudi and Sulaiman (2016) that laws use, of ``published.json``, and the settings of its runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from codesign.planners.reproduction import Settings, printed_numbers

NUMBERS = printed_numbers(Path(__file__).with_name("published.json"))
PAPER = NUMBERS.cited
CELLS = int(NUMBERS.figures["rows"]) * int(NUMBERS.figures["columns"])


@dataclass(frozen=True)
class Run:
    """One run: ``omega`` and ``r`` (None where the method has none), ``iterations`` k, ``seconds`` t."""

    omega: float | None
    r: float | None
    iterations: int
    seconds: float


(GS,), AM, MAM_COARSE, MAM_FINE = (
    tuple(Run(**row) for row in NUMBERS.tables[name]) for name in ("GS", "AM", "MAM coarse", "MAM fine")
)
"""Table I, and Table II for the last."""

MISPRINT = MAM_FINE[-1]
"""Its time is its number of iterations, copied."""


class RelaxationSettings(Settings):
    """Settings of the runs. Without a value, a run has the setting of the published rows."""

    sor_omegas: tuple[Annotated[float, Field(gt=1, lt=2)], ...] | None = Field(
        default=None,
        min_length=1,
        max_length=50,
        description="relaxation factors of the runs by SOR and red-black; published rows: 1.9 to 1.98, eight of them",
    )
