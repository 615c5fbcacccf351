"""A figure with its unit, its interval and where it comes from.

Every number that a report shows is one of four kinds, and says which:

- ``published``: stands in a paper or a datasheet,
- ``calibrated``: fitted to published or measured rows; the fit and its residuals are in the repo,
- ``measured``: counted or timed on our own RTL, synthesis or machine,
- ``assumed``: nobody has shown it; the source says what it was taken from.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Status(StrEnum):
    """Where a figure comes from, strongest first."""

    PUBLISHED = "published"
    CALIBRATED = "calibrated"
    MEASURED = "measured"
    ASSUMED = "assumed"


@dataclass(frozen=True)
class Figure:
    """One number.

    ``low`` and ``high`` bound it where a law was fitted or a value assumed; both are ``value`` for an exact figure.
    """

    value: float
    unit: str
    status: Status
    source: str
    low: float | None = None
    high: float | None = None

    @property
    def interval(self) -> tuple[float, float]:
        """The lowest and the highest value that the source allows."""
        return (
            self.value if self.low is None else self.low,
            self.value if self.high is None else self.high,
        )


_LABELS = {"lut4": "LUT4", "flip_flops": "flip-flops", "block_rams": "block RAMs"}


def label(name: str) -> str:
    """A name of the model (a resource, a figure, a phase), or words with such names among them, in a reader's words.

    >>> label("share_reaching_goal"), label("block_rams"), label("block_rams at most")
    ('share reaching goal', 'block RAMs', 'block RAMs at most')
    """
    return " ".join(_LABELS.get(word, word.replace("_", " ")) for word in name.split(" "))


def weakest(*statuses: Status) -> Status:
    """The status of a figure made from others: that of its weakest ingredient.

    >>> weakest(Status.PUBLISHED, Status.ASSUMED)
    <Status.ASSUMED: 'assumed'>
    """
    order = list(Status)
    return max(statuses, key=order.index)
