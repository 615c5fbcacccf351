"""Fit the model to this machine (costs of kernels) and to the reports of an FPGA tool (calibrations of laws)."""
