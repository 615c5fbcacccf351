"""Velocity obstacles of several robots, the planner of Dubey, Pradhan, Krishna and Roy Chowdhury (2013)."""
