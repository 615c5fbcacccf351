"""Measure the costs of the planners' kernels on this machine."""
