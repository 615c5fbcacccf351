"""Toggles counted in a waveform, and in that of the netlist of a circuit."""

from __future__ import annotations

import numpy as np
import pytest
from rtl_tools import needs
from toy_circuit import ToyCircuit, ToyParameters

from benchmarks.activity import activity, count_toggles, without_unknowns
from codesign.ground.errors import RunError
from codesign.planners.job import Job

WAVES = """
$scope module top $end
$var wire 1 ! clk $end
$var wire 4 " sum $end
$scope module node $end
$var wire 1 # clk $end
$var wire 1 $ changed $end
$upscope $end
$enddefinitions $end
#0
1!
1#
b0000 "
x$
#5
0!
0#
#10
1!
1#
b0110 "
1$
#20
0!
0#
#30
1!
1#
b0111 "
0$
"""


def test_toggles_are_counted_a_bit_and_edge_without_the_clock() -> None:
    counted = count_toggles(WAVES.splitlines())
    assert counted.bits == 5
    assert counted.cycles == 3
    # sum: two bits, then one; changed: from 1 to 0. From unknown to 1 is no toggle.
    assert counted.toggles == 4
    assert counted.rate == pytest.approx(4 / 15)


def test_parameters_are_no_nets() -> None:
    lines = ["$var parameter 8 ! WIDTH $end", "$var integer 32 i row $end", *WAVES.splitlines()]
    assert count_toggles(lines) == count_toggles(WAVES.splitlines())


def test_the_toggles_of_a_netlist_are_counted_on_a_run_that_reports_what_the_model_expects() -> None:
    needs("cxxrtl")
    needs("icarus")
    toy = ToyCircuit()
    job = Job(np.array([3, 250, 7, 129, 64, 1]), ToyParameters())
    counted = activity(toy.circuit(job), toy.expected(job))
    assert counted.cycles == sum(toy.expected(job).cycles.values())
    assert 0.02 < counted.rate < 0.5
    # The same words again and again: the sum goes on, the memory shows one word.
    still = Job(np.zeros(6, np.int64), ToyParameters())
    assert activity(toy.circuit(still), toy.expected(still)).rate < counted.rate


def test_a_netlist_that_reports_something_else_is_refused() -> None:
    needs("cxxrtl")
    needs("icarus")
    toy = ToyCircuit()
    job, other = (Job(np.array(words), ToyParameters()) for words in ([3, 250, 7], [3, 251, 7]))
    with pytest.raises(RunError, match="the netlist of toy_sum reports other values than the model"):
        activity(toy.circuit(job), toy.expected(other))


def test_what_is_unknown_at_power_up_is_zero() -> None:
    verilog = "  reg [3:0] a  = 4'hx;\n  reg b ;\n  reg [1:0] \\ram.words  [15:0];\n  assign c = 3'b0x1;\n"
    known = without_unknowns(verilog)
    assert "reg [3:0] a  = 4'h0;" in known
    assert "reg b = 0;" in known
    assert "for (word_0 = 0; word_0 <= 15; word_0 = word_0 + 1) \\ram.words [word_0] = 0;" in known
    assert "assign c = 3'b001;" in known
