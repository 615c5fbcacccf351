"""What a run comes to, as named figures with units: of a design, of a mission and of a fleet.

A result is a record without behaviour. What computes it stands above, and so does what reports it.
"""

from codesign.results.result import Result

__all__ = ["Result"]
