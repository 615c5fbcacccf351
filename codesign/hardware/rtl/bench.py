"""The test bench of a design point: Verilog-2005 that feeds the stream, and compares every event with the model.

It runs unchanged in Icarus and Verilator. ``hwsw verify`` runs the same bench there, with ``+log``.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

import jinja2

from codesign.hardware.rtl.design import bound_of, range_of, top_name
from codesign.planners.circuits import Circuit, Expected, Pins

BENCH = "hwsw_bench"
"""The module of the bench."""

_CYCLE_DIGITS = 12


@cache
def template(name: str) -> Any:
    """A template of this package."""
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, keep_trailing_newline=True, autoescape=False)
    folder = files("codesign.hardware.rtl") / "templates"
    return environment.from_string((folder / f"{name}.jinja").read_text(encoding="utf-8"))


def bench_files(circuit: Circuit, expected: Expected) -> dict[str, str]:
    """The bench, and the files that it reads from the current folder."""
    return {
        f"{BENCH}.v": _bench_text(circuit, expected),
        "stream.hex": circuit.stream.hex_text() or "0\n",
        "expected.hex": _expected_text(circuit, expected),
        **({"pins.hex": _pins_text(circuit, expected.pins)} if circuit.pins and expected.pins else {}),
    }


def _expected_text(circuit: Circuit, expected: Expected) -> str:
    """The expected events for ``$readmemh``: cycle, kind and value in hexadecimal, joined by ``_``."""
    digits = _digits(circuit)
    events = expected.events
    rows = zip(events.cycle.tolist(), events.kind.tolist(), events.value.tolist(), strict=True)
    lines = [f"{cycle:0{_CYCLE_DIGITS}x}_{kind:x}_{value:0{digits}x}\n" for cycle, kind, value in rows]
    return "".join(lines) or "0\n"


def _pins_text(circuit: Circuit, pins: Pins) -> str:
    """The changes of the further outputs for ``$readmemh``: cycle, value and the bits that count, joined by ``_``."""
    digits = _pin_digits(circuit)
    rows = zip(pins.cycle.tolist(), pins.value.tolist(), pins.known.tolist(), strict=True)
    lines = (f"{cycle:0{_CYCLE_DIGITS}x}_{value:0{digits}x}_{known:0{digits}x}\n" for cycle, value, known in rows)
    return "".join(lines)


def _pin_digits(circuit: Circuit) -> int:
    return -(-sum(circuit.pins.values()) // 4)


def _digits(circuit: Circuit) -> int:
    """Hexadecimal digits of the value of an event."""
    return -(-circuit.event_bits // 4)


def _bench_text(circuit: Circuit, expected: Expected) -> str:
    text: str = template("hwsw_bench.v").render(
        top=top_name(circuit),
        words=len(circuit.stream.words),
        events=len(expected.events.cycle),
        event_bits=circuit.event_bits,
        value_bits=4 * _digits(circuit),
        bound=bound_of(expected),
        contention=expected.contention,
        in_range=range_of(circuit.stream.width),
        event_range=range_of(circuit.event_bits),
        pins={name: range_of(width) for name, width in circuit.pins.items()},
        pin_bits=sum(circuit.pins.values()),
        pin_width=4 * _pin_digits(circuit),
        changes=len(expected.pins.cycle) if expected.pins else 0,
        watched=expected.pins.end if expected.pins else 0,
        kinds=circuit.kinds,
        phases=circuit.phases,
        cycles_by_phase=[expected.cycles.get(phase, 0) for phase in circuit.phases],
    )
    return text
