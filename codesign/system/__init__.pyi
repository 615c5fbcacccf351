from .bind import System
from .headlines import at_hand
from .inspect import (
    PlannerFacts,
    applicable,
    planner_facts,
    point_of,
    problem_from_map,
    problem_of,
    schema_of,
    with_problem,
)
from .results.result import Result
from .scenario import MissionProgress

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
