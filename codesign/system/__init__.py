"""From a design point to its machine: bind joins the specs, fit holds them against the part, build makes the machine.

``bind`` joins platform, workload and map into a frozen ``System``; ``fit`` holds its demand against the part; ``build``
makes the SimPy components. A ``Scenario`` runs them: see ``codesign.system.scenarios``. Simulated time is a whole
number of picoseconds.
"""

from __future__ import annotations

from codesign.ground.late import by_name

__getattr__, __dir__, __all__ = by_name(__name__, __file__)
