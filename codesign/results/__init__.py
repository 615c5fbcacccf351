"""The named figures of a run, with their units: of a design, of a mission and of a fleet.

A result is a record without behaviour. What computes it stands above, and so does what reports it.
"""

from codesign.results.result import Result

__all__ = ["Result"]
