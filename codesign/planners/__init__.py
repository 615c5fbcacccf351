"""Planners: exact computation without a clock. One package for each paper."""
