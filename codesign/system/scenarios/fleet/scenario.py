"""Scenario ``fleet``, as the system asks for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from codesign.ground.errors import Fault
from codesign.ground.memo import Memo
from codesign.inputs import fault
from codesign.inputs.exploration import FLEET_OBJECTIVES
from codesign.inputs.scenario import Fleet
from codesign.planners.interface import COMMAND, Planner
from codesign.planners.task_graph import Flow
from codesign.system.build import Machine
from codesign.system.chain import Answer
from codesign.system.outcome import plan_fields, use_fields
from codesign.system.place import DISPLAY, RENDER_KERNEL
from codesign.system.results.ledger import Ledger
from codesign.system.results.result import Power
from codesign.system.scenario import Draft, ProgressOfMission
from codesign.system.scenarios.fleet.flight import fly
from codesign.system.scenarios.fleet.frames import frame_receiver
from codesign.system.scenarios.scenario import Scenario


class FleetScenario(Scenario):
    """Robots with an FPGA each, update by update."""

    type = "fleet"
    objectives = FLEET_OBJECTIVES

    def instead(self, planner: Planner) -> str | None:
        """Fleets are for planners with a problem of robots."""
        return "drive" if planner.problem_model is None else None

    def faults_on(self, draft: Draft) -> list[Fault]:
        """A style that plans for one robot only."""
        if draft.architecture.updates(draft.job) is not None:
            return []
        text = f"style {draft.architecture.style} does not say what each robot takes for an update"
        hint = "take a style with a method updates, as those of velocity_obstacle have, or scenario plan_once"
        return [fault(draft.workload, ("mapping", draft.planner.planning_task, "style"), text, hint)]

    def flows(self, _draft: Draft, places: Mapping[str, str], planned: Sequence[Flow]) -> Sequence[Flow]:
        """The answers of the planner, which the first robot's board itself sends to the display too."""
        if DISPLAY not in places:
            return ()
        return [replace(flow, receiver=DISPLAY) for flow in planned if flow.receiver == COMMAND]

    def kernels(self, draft: Draft, places: Mapping[str, str]) -> Mapping[str, str]:
        """The frames that are drawn."""
        assert isinstance(draft.workload.scenario, Fleet), "the registry of scenarios goes by the type"
        receiver = frame_receiver(draft.workload.scenario, places, places[draft.planner.planning_task])
        return {} if receiver is None else {receiver: RENDER_KERNEL}

    def run(
        self, machine: Machine, boards: Mapping[str, Power], memo: Memo | None, _progress: ProgressOfMission | None
    ) -> dict[str, Any]:
        """The figures of the plan that the fleet carried out, and of the fleet."""
        flight = fly(machine)
        ended = flight.ends[-1] if flight.ends else flight.loaded
        answer = Answer(machine.system.problem, flight.plan, flight.loaded, ended, ended, Ledger())
        fields = plan_fields(machine, answer, memo) | use_fields(machine, boards, flight.fpgas[1:])
        return {**fields, "fleet": flight.figures}
