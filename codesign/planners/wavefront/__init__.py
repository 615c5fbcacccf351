"""Wavefront propagation, the planner of Möller and Paschke (1998)."""
