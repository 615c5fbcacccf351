"""n robots in the closed loop, without a clock: the planner's answer."""

from __future__ import annotations

from codesign.ground.errors import InputError
from codesign.ground.late import late
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.faults import fault_of
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem

loop = late("codesign.planners.velocity_obstacle.plan.loop")


def avoid(problem: RobotsProblem, parameters: AvoidParameters) -> Avoidance:
    """Run all robots until they stand at their targets, or ``parameters.updates`` are done, or a value leaves its word.

    All decide at the same time from the same state, each on its own FPGA. Every decision takes effect within its time
    step. The run ends in the same bits as ``reference.run`` with ``arithmetic.fixed``.

    Raises:
        InputError: the parameters do not suit this problem (``fault_of``).
    """
    fault = fault_of(problem, parameters)
    if fault is not None:
        raise InputError(fault[1], fault[0])
    run = loop.Loop(problem, parameters)
    run.run()
    plan: Avoidance = run.plan()
    return plan
