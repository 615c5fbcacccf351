"""Breadth-first search, the planner of Vacariu, Roman, Timar, Stanciu, Banabic and Cret (2008)."""
