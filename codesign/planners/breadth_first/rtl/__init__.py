"""The circuits of breadth-first search: the state machine of Vacariu et al. (2008) in Verilog-2005."""

from codesign.planners.breadth_first.rtl.machine import StateMachineCircuit

CIRCUITS = (StateMachineCircuit(),)

__all__ = ["CIRCUITS", "StateMachineCircuit"]
