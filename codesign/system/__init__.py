"""From specs to a result: bind, fit, build, run.

``simulate(platform, workload)`` does all four. ``bind`` joins the specs and the map into a frozen ``System``; ``fit``
holds its demand against the part; ``build`` makes the SimPy components; ``run`` lets the host ask and the planner
answer. Simulated time is integer picoseconds. Watching is separate: a listener takes records and changes nothing.
"""

from codesign.results.result import Result
from codesign.system.bind import System, bind
from codesign.system.comparison import applicable, problem_from_map, problem_of, with_problem
from codesign.system.inspect import at_hand, check_files, point_of, schema_of
from codesign.system.progress import MissionProgress, outlook
from codesign.system.run import simulate, simulate_system

__all__ = [
    "MissionProgress",
    "Result",
    "System",
    "applicable",
    "at_hand",
    "bind",
    "check_files",
    "outlook",
    "point_of",
    "problem_from_map",
    "problem_of",
    "schema_of",
    "simulate",
    "simulate_system",
    "with_problem",
]
