"""The named figures of a run, with their units: of a design, of a mission and of a fleet.

A result is a record without behaviour. The modules that compute it and report it stand above.
"""

from codesign.system.results.result import Result

__all__ = ["Result"]
