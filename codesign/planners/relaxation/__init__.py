"""Relaxation on a host, the planner of Saudi and Sulaiman (2016)."""
