"""Velocity obstacles of several robots, the planner of Dubey, Pradhan, Krishna and Roy Chowdhury (2013).

- ``plan``: the arithmetic, exact and without a clock.
- ``styles``: how it is laid out on a component, with its laws.
- ``published``: the paper's rows that laws are fitted to and held against.
- ``paper``: the run that holds the model against the paper.

``paper`` imports ``styles``, ``styles`` imports ``plan``, and never in the other direction.
"""
