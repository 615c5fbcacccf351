"""From a design point to its machine: bind joins the specs, fit holds them against the part, build makes the machine.

``bind`` joins platform, workload and map into a frozen ``System``; ``fit`` holds its demand against the part; ``build``
makes the SimPy components. A ``Scenario`` runs them: see ``codesign.system.scenarios``. Simulated time is a whole
number of picoseconds.
"""

from codesign.system.bind import System
from codesign.system.inspect import (
    PlannerFacts,
    applicable,
    at_hand,
    planner_facts,
    point_of,
    problem_from_map,
    problem_of,
    schema_of,
    with_problem,
)
from codesign.system.results.result import Result
from codesign.system.scenario import MissionProgress

__all__ = [
    "MissionProgress",
    "PlannerFacts",
    "Result",
    "System",
    "applicable",
    "at_hand",
    "planner_facts",
    "point_of",
    "problem_from_map",
    "problem_of",
    "schema_of",
    "with_problem",
]
