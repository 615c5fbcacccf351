"""Portable workloads: each shipped one on each platform that fills its roles; roles in mappings and axes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest
from click.testing import Result

import codesign
from codesign.ground.errors import SpecError
from codesign.inputs import Platform, Workload, design_point, list_platforms, list_workloads, pin
from codesign.inputs.roles import ROLES
from codesign.system.scenarios import bind

LACKS = {
    "a drive needs a robot",
    "has no cost of kernel",
    "has no memory",
    "there is no task, component or link 'body'",
}
"""What a platform may lack besides a role: a robot, a time that nobody gives, an external memory, a link to a robot."""


@pytest.mark.parametrize("name", list_workloads())
def test_each_workload_is_bound_on_each_platform_that_fills_its_roles(name: str) -> None:
    workload = codesign.load_workload(name)
    roles = {mapped.component for mapped in workload.mapping.values()}
    assert roles <= set(ROLES), "a shipped workload names no component of one platform"
    bound = 0
    for each in list_platforms():
        platform = codesign.load_platform(each)
        places, faults = placed(platform, workload)
        missing = roles - set(platform.filled)
        lacks = {f"platform {each} has no {role}" for role in missing} | LACKS
        assert [what for what in faults if not any(text in what for text in lacks)] == []
        if not faults:
            bound += 1
            assert missing == set()
            assert all(places[task] == platform.filled[mapped.component] for task, mapped in workload.mapping.items())
    assert bound


def placed(platform: Platform, workload: Workload) -> tuple[Mapping[str, str], list[str]]:
    """The component of each task, or what keeps the workload off the platform."""
    try:
        return bind(platform, workload).placement.places, []
    except SpecError as wrong:
        return {}, [fault.what for fault in wrong.faults]


def test_a_pair_that_no_name_joined_runs(hwsw: Callable[..., Result]) -> None:
    """``zynq`` calls its processor ``arm``, and ``floor-plan`` was written for a ``pc``."""
    ran = hwsw("run", "zynq", "floor-plan", "--set", "relax.max_iterations=10", "--set", "host.clock=600 MHz")
    assert "relax" in ran.stdout, ran.output


def test_an_axis_of_a_role_moves_what_fills_it() -> None:
    specs = codesign.load_platform("zynq"), codesign.load_workload("office-partition")
    platform, workload = design_point(
        *specs, {"fabric.clock": "50 MHz", "link.clock": "1 MHz", "decide.component": "host"}
    )
    assert platform.components["fpga"].clock.value == 50e6
    assert platform.links["axi"].clock.value == 1e6
    assert bind(platform, workload).placement.places["decide"] == "arm"


def test_a_role_and_the_name_that_fills_it_are_one_axis() -> None:
    specs = codesign.load_platform("zynq"), codesign.load_workload("office-partition")
    _, workload = pin(*specs, {"axi.clock": "1 MHz"})
    assert workload.explore is not None
    assert "link.clock" not in workload.explore.axes


def test_a_setting_of_a_role_that_nothing_fills_says_which_platforms_do(hwsw: Callable[..., Result]) -> None:
    ran = hwsw("run", "pc-epyc", "floor-plan", "--set", "fabric.clock=1 MHz")
    assert ran.exit_code == 2
    assert "--set fabric.clock: platform pc-epyc has no fabric\n" in ran.stderr
    assert "or take arty-a7, arty-a7-100t," in ran.stderr
