"""Measure what this machine needs for the planners' kernels."""
