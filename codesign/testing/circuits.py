"""Rules of circuits: what they declare, and that a run of each reports what the model expects."""

from __future__ import annotations

import numpy as np

from codesign.hardware.rtl import tools
from codesign.hardware.rtl.design import digest_of_circuit
from codesign.hardware.rtl.verify import verify
from codesign.planners.circuits import MOST_KINDS, Circuit, CircuitStyle, Expected
from codesign.testing.case import Case, Rule, names, require, rule

SEED = 0
"""The sample that is checked. ``hwsw verify --all`` checks more."""


def _has_circuits(case: Case) -> bool:
    return case.index == 0 and bool(case.plug_in.circuits)


def _can_simulate(case: Case) -> bool:
    """Simulation needs the extra ``rtl``."""
    return _has_circuits(case) and tools.command_of("pyosys") is not None


def of_circuit(style: CircuitStyle) -> str:
    """A circuit in a sentence."""
    return f"the circuit of style {style.style!r}" + (f" (task {style.task})" if style.task else "")


@rule(_has_circuits)
def circuits_belong_to_styles_on_an_fpga(case: Case) -> None:
    """Each circuit derives from ``CircuitStyle``, is of a style of the planner on an FPGA, and none is there twice."""
    of_planning = {("", style.style) for style in case.styles if style.component_type == "fpga"}
    of_tasks = {(style.task, style.style) for style in case.task_styles if style.component_type == "fpga"}
    seen: set[tuple[str, str]] = set()
    for style in case.plug_in.circuits:
        require(isinstance(style, CircuitStyle), f"{style!r} does not derive from CircuitStyle")
        key = (style.task, style.style)
        require(
            style.planner == case.planner.name and key in of_planning | of_tasks,
            f"{of_circuit(style)} is of no style of planner {case.planner.name} on an FPGA",
        )
        require(key not in seen, f"{of_circuit(style)} is registered twice")
        seen.add(key)


@rule(_has_circuits)
def circuits_and_expectations_are_sound(case: Case) -> None:
    """A sample is the same for a seed. Files are there; phases, kinds and values have room; events are in order."""
    for style in case.plug_in.circuits:
        job, text = style.sample(SEED), of_circuit(style)
        circuit, expected = style.circuit(job), style.expected(job)
        _circuit_is_sound(circuit, text)
        _expectation_is_sound(circuit, expected, text)
        again = style.circuit(style.sample(SEED))
        same = digest_of_circuit(again) == digest_of_circuit(circuit)
        require(
            same and again.stream.hex_text() == circuit.stream.hex_text(),
            f"the sample of {text} differs from run to run",
        )


def _circuit_is_sound(circuit: Circuit, text: str) -> None:
    missing = [source.name for source in circuit.sources if not source.is_file()]
    require(not missing, f"{text} names Verilog that is not there: {names(missing)}")
    require(0 < circuit.event_bits <= 64, f"events of {text} have {circuit.event_bits} bits, not 1 to 64")
    for what, listed, most in (("phases", circuit.phases, MOST_KINDS - 1), ("kinds", circuit.kinds, MOST_KINDS)):
        require(
            0 < len(listed) <= most and len(set(listed)) == len(listed),
            f"{text} has {len(listed)} {what}: accepted are 1 to {most}, each with a name of its own",
        )
    images = {value for value in circuit.parameters.values() if isinstance(value, str)}
    require(images == set(circuit.images), f"{text} has images {names(circuit.images)}, its parameters {names(images)}")


def _expectation_is_sound(circuit: Circuit, expected: Expected, text: str) -> None:
    events = expected.events
    lengths = {len(events.cycle), len(events.kind), len(events.value)}
    require(lengths != {0} and len(lengths) == 1, f"the model expects no event of {text}, or arrays of several lengths")
    types = [str(array.dtype) for array in (events.cycle, events.kind, events.value)]
    require(types == ["int64", "uint8", "uint64"], f"events of {text} are {names(types)}, not int64, uint8, uint64")
    require(
        bool((np.diff(events.cycle) > 0).all()) and events.cycle[0] >= 0,
        f"the model expects events of {text} out of order, or two at one cycle",
    )
    require(int(events.kind.max()) < len(circuit.kinds), f"the model expects a kind that {text} has not")
    require(int(events.value.max()) < 2**circuit.event_bits, f"the model expects a value that {text} has no bits for")
    strange = set(expected.cycles) - set(circuit.phases)
    require(not strange, f"the model counts cycles of {names(strange)}, which are no phases of {text}")


@rule(_can_simulate)
def circuits_report_what_the_model_expects(case: Case) -> None:
    """Simulated natively, a sample of each circuit reports every event at its cycle."""
    for style in case.plug_in.circuits:
        verified = verify(style, style.sample(SEED))
        require(verified.first is None, f"{of_circuit(style)} differs from the model: {verified.first}")


RULES: tuple[Rule, ...] = (
    circuits_belong_to_styles_on_an_fpga,
    circuits_and_expectations_are_sound,
    circuits_report_what_the_model_expects,
)
