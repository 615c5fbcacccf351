"""A*, jump point search, lazy theta*, and the potential of NavFn on a grid."""

from codesign.planners.grid_search.plan.parameters import Heuristic, Method, SearchParameters
from codesign.planners.grid_search.plan.planner import GridPlan, search

__all__ = ["GridPlan", "Heuristic", "Method", "SearchParameters", "search"]
