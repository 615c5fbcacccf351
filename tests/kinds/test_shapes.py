"""What components say of themselves, on which pricing and placement rest."""

from __future__ import annotations

from typing import Any

import kinds
import pytest

from codesign.inputs import Platform


def host(**changes: Any) -> Any:
    platform: Platform = kinds.platform(kinds.link("ideal"), kinds.HOST | changes)
    return platform.components["host"]


PRICES = [{"clock": "2 GHz"}, {"costs": {"harmonic_node_update": "1 ns"}}, {"power": {"busy": "1 W", "idle": "1 W"}}]
OTHERS = [
    {"cores": 2},
    {"costs": {}},
    {"costs": {"harmonic_node_update": "40 ns", "wavefront_cell": "1 ns"}},
    {"memory": "1 Mb"},
]


@pytest.mark.parametrize("price", PRICES)
def test_hosts_that_differ_in_prices_compute_the_same(price: dict[str, Any]) -> None:
    assert host(**price).shape() == host().shape()


@pytest.mark.parametrize("other", OTHERS)
def test_hosts_with_other_kernels_cores_or_memory_do_not(other: dict[str, Any]) -> None:
    assert host(**other).shape() != host().shape()


def test_every_component_says_what_it_has() -> None:
    fpga, processor = kinds.platform(kinds.link("ideal")).components.values()
    assert (fpga.plans, fpga.kernels, fpga.ram, fpga.neighbour, fpga.drawing) == (True, None, None, None, None)
    assert fpga.chip.full_name == "XC2V6000-4"
    assert (processor.plans, processor.chip, processor.drawing) == (True, None, processor.power)
    assert list(processor.kernels) == ["harmonic_node_update"]
    assert host(memory="1 Mb").ram.value == 125_000
