"""Relaxation on a host: Laplace's equation by sweeps over doubles (Saudi and Sulaiman 2016, and other methods).

The potential is fixed on obstacles and goals, and the mean of its four neighbours everywhere else. The methods are the
paper's two-level arithmetic mean (AM, MAM), the sweeps that it consists of (Gauss-Seidel, SOR), their parallel
relatives (Jacobi, red-black), the paper's outlook (half-sweep AM), and a sparse direct solver, the usual choice today.
"""

from codesign.planners.relaxation.plan.parameters import PUBLISHED_TOLERANCE, Boundary, Method
from codesign.planners.relaxation.plan.planner import Descent, Ending, Search, descend
from codesign.planners.relaxation.plan.solve import End, Solution, solve

__all__ = [
    "PUBLISHED_TOLERANCE",
    "Boundary",
    "Descent",
    "End",
    "Ending",
    "Method",
    "Search",
    "Solution",
    "descend",
    "solve",
]
