"""Why something does not match, and the experiment that would settle it: one table, by what it explains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from codesign.fidelity.mismatches import Mismatch

REPORT = "`hwsw rtl` for such a part, the vendor's tool, and `hwsw calibrate fpga --report` of its reports"


@dataclass(frozen=True)
class Reason:
    """``what``: a pattern of the keys of mismatches. ``why``, and the ``experiment``: sentences."""

    what: str
    why: str
    experiment: str


REASONS: tuple[Reason, ...] = ()


def reason_of(mismatch: Mismatch) -> Reason | None:
    """The first reason that explains a mismatch."""
    return next((reason for reason in REASONS if fnmatchcase(mismatch.key, reason.what)), None)


def idle(mismatches: Sequence[Mismatch]) -> tuple[Reason, ...]:
    """The reasons that explain no mismatch any more."""
    used = {reason_of(mismatch) for mismatch in mismatches}
    return tuple(reason for reason in REASONS if reason not in used)
