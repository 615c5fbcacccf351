"""The circuits of the wavefront planner: Verilog of the arrays, and what the model expects of it."""

from codesign.planners.circuits import CircuitStyle
from codesign.planners.wavefront.rtl.circuit import AdderCircuit, DelayLineCircuit, TiledCircuit

CIRCUITS: tuple[CircuitStyle, ...] = (DelayLineCircuit(), AdderCircuit(), TiledCircuit())

__all__ = ["CIRCUITS"]
