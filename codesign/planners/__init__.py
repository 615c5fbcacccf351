"""Planners: exact computation without a clock, and what it costs. One package, a *room*, for each paper.

- ``plan``: the arithmetic, exact and without a clock.
- ``styles``: its layout on a component, with its laws.
- ``rtl``: its circuits in Verilog.
- ``published``: the rows of the paper that laws are fitted to and compared with.
- ``paper``: the reproduction of the paper.

``paper`` imports ``styles``, and ``styles`` imports ``plan``; never the reverse.
"""
