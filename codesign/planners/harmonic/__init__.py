"""Block-synchronous harmonic control, the planner of Girau, Boumaza, Scherrer and Torres-Huitzil (2008).

- ``plan``: the arithmetic, exact and without a clock.
- ``styles``: its layout on a component, with its laws.
- ``published``: the rows of the paper that laws are fitted to and compared with.
- ``paper``: the reproduction of the paper.

``paper`` imports ``styles``, and ``styles`` imports ``plan``; never the reverse.
"""
