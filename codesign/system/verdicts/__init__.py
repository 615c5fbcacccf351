"""The certainty of a result: whether a need holds, a design wins, or fits, at every value inside the intervals.

All are pure functions of results. ``need_verdict`` holds a figure against a limit, ``constraint_verdict`` against the
limits of a constraint, ``winner_verdict`` compares designs by one figure, ``fit_verdict`` says whether a design fits.
A verdict is ``proved`` for the intervals that are declared: the form of the laws is taken as right.
"""

from codesign.system.verdicts.fits import Fit, RunDocument, fit_verdict, run_document
from codesign.system.verdicts.verdict import (
    Decider,
    Swing,
    Verdict,
    constraint_verdict,
    need_verdict,
    sensitivity,
    together,
    winner_verdict,
)

__all__ = [
    "Decider",
    "Fit",
    "RunDocument",
    "Swing",
    "Verdict",
    "constraint_verdict",
    "fit_verdict",
    "need_verdict",
    "run_document",
    "sensitivity",
    "together",
    "winner_verdict",
]
