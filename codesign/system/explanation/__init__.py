"""Explanations of a design: the parts of its time and energy, what keeps it out, what is better, how sure that is.

The modules hold records, and pure functions of results. Designs of a study, and runs with something moved, are
explained by ``codesign.study``.
"""

from codesign.system.explanation.records import (
    Amount,
    AxisEffect,
    Explanation,
    Moved,
    Sure,
    Why,
    WhyOut,
    Words,
    explanation_schema,
    why_energy,
    why_time,
)

__all__ = [
    "Amount",
    "AxisEffect",
    "Explanation",
    "Moved",
    "Sure",
    "Why",
    "WhyOut",
    "Words",
    "explanation_schema",
    "why_energy",
    "why_time",
]
