"""The circuits of harmonic control: Verilog, and what the model expects a run of them to report."""

from codesign.planners.harmonic.rtl.alone import DecisionCircuit
from codesign.planners.harmonic.rtl.circuit import BitSerialCircuit

CIRCUITS = (BitSerialCircuit(), DecisionCircuit())

__all__ = ["CIRCUITS"]
