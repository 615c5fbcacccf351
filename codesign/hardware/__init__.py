"""Real hardware and papers beside the model: Verilog and tools, calibration, fidelity, reproduced papers."""
