"""The tools that tests of circuits need, and skip without."""

from __future__ import annotations

import pytest

from codesign.hardware.rtl import tools

NEEDS = {"cxxrtl": "pyosys", "icarus": "iverilog", "verilator": "verilator"}
"""The tool of each simulator."""


def needs(backend: str) -> None:
    """Skip where the tools of a simulator are not installed."""
    if tools.command_of(NEEDS[backend]) is None:
        pytest.skip(f"{NEEDS[backend]} is not installed")


def quickest() -> str:
    """The simulator that ends first on a small circuit, of those that are installed. Skip where there is none.

    Icarus compiles a sample in a tenth of a second, a compiler of C++ in two.
    """
    if tools.command_of("iverilog") is None:
        needs("cxxrtl")
        return "cxxrtl"
    return "icarus"
