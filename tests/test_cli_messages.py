"""Where the command line says a mistake is: in the file that holds it, or in the option that brought it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

Run = Callable[..., Result]


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("fpga.clock=600 MHz", "--set fpga.clock: 600 MHz is above the 300 MHz limit of part XC2V6000-4\n"),
        ("relax.block=12x18", "--set relax.block: '12x18' is not a list\n  hint: write [12, 18]\n"),
        ("relax.block=[12, 180]", "--set relax.block: a block of 12 × 180 nodes on a map of 24 × 36 cells\n"),
        ("relax.component=hots", "--set relax.component: platform small-board has no component 'hots'\n"),
        ("relax.itrations=1", "--set relax.itrations: unknown key\n  hint: did you mean iterations?"),
        ("relax.iterations=010", "--set relax.iterations: 010 has a leading zero\n"),
    ],
)
def test_faults_of_a_setting_are_not_blamed_on_a_file(
    hwsw: Run, specs: tuple[Path, Path], setting: str, told: str
) -> None:
    result = hwsw("run", *specs, "--set", setting)
    assert result.exit_code == 2
    assert result.stderr.startswith(told)
    assert "rooms.yaml" not in result.stderr
