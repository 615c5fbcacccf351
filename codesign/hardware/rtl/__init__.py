"""From a design point to hardware: its Verilog is written, simulated against the model, synthesised and placed."""
