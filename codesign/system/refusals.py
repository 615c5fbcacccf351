"""Faults from what components and laws refuse, at the key of the spec that they name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pydantic import BaseModel

from codesign.errors import CodesignError, Fault
from codesign.inputs import Platform, Workload, fault
from codesign.inputs.components import DisplayComponent

if TYPE_CHECKING:
    from codesign.components import Component


def refused(
    spec: Platform | Workload, path: Sequence[str], section: BaseModel, wrong: CodesignError
) -> Fault:
    """The fault that ``wrong`` stands for.

    Args:
        spec: the file that is at fault.
        path: of the section that was refused.
        section: its model. Where ``wrong.where`` ends in one of its keys, the fault lies at that key.
        wrong: what a component or a law raised.
    """
    key = (wrong.where or "").rpartition(".")[2]
    at_key = key in type(section).model_fields
    return fault(spec, (*path, key) if at_key else tuple(path), wrong.what, wrong.hint)


def platform_faults(platform: Platform) -> list[Fault]:
    """What the components and links of a platform refuse to be built with, whatever the workload.

    Each is built once and thrown away. What a display takes of an FPGA's block RAM depends on the planner and on the
    map, so that ``ready`` finds those faults. A robot is built by its scenario.
    """
    import simpy

    from codesign.system.assemble import component_of, link_of

    environment = simpy.Environment()
    made: dict[str, Component] = {}
    faults: list[Fault] = []
    for name in building_order(platform):
        spec = platform.components[name]
        if isinstance(spec, DisplayComponent) and spec.beside not in made:
            continue
        try:
            component = component_of(environment, name, spec, made, ())
        except CodesignError as wrong:
            faults.append(refused(platform, ("components", name), spec, wrong))
        else:
            made |= {} if component is None else {name: component}
    for name, link in platform.links.items():
        try:
            link_of(environment, name, link, ())
        except CodesignError as wrong:
            faults.append(refused(platform, ("links", name), link, wrong))
    return faults


def building_order(platform: Platform) -> list[str]:
    """The names of the components, those first that others stand beside: FPGAs, then memories, then displays."""
    order = {"memory": 1, "display": 2}
    return sorted(platform.components, key=lambda name: order.get(platform.components[name].type, 0))
