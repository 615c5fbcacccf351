"""The files of a circuit, its digest, and the top module that carries it.

The top of a design point is a module ``hwsw_`` and 12 hexadecimal digits. It has no parameters, so every tool takes it,
and its name recognises the design in the report of any tool.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

from codesign.hardware.rtl.cache import digest_of
from codesign.planners.circuits import Bits, Circuit, Expected

DIGITS = 12
"""Hexadecimal digits of the digest in the name of a top module."""

PREFIX = "hwsw_"


@cache
def _text_of(source: Path) -> str:
    return source.read_text(encoding="utf-8")


def digest_of_circuit(circuit: Circuit) -> str:
    """The digest of the Verilog and its parameters. The contents of memories and the stream move it not."""
    sources = sorted((source.name, _text_of(source)) for source in circuit.sources)
    parameters = sorted(f"{name}={value!r}" for name, value in circuit.parameters.items())
    parts = (part for source in sources for part in source)
    widths = f"{circuit.stream.width} {circuit.event_bits}"
    return digest_of(circuit.top, widths, *parts, *parameters)


def top_name(circuit: Circuit) -> str:
    """The name of the top module of a design point."""
    return PREFIX + digest_of_circuit(circuit)[:DIGITS]


def sources_of(circuit: Circuit) -> dict[str, str]:
    """Every Verilog file of a design point by its name, the top last.

    Raises:
        ValueError: two sources have one name.
    """
    files = {source.name: _text_of(source) for source in circuit.sources}
    if len(files) != len(circuit.sources):
        raise ValueError(f"two Verilog files of {circuit.top} have one name")
    return {**files, f"{top_name(circuit)}.v": top_text(circuit)}


def ports_of(circuit: Circuit) -> tuple[tuple[str, str, int], ...]:
    """Direction, name and width of every port, in their order."""
    return (
        ("input", "clk", 1),
        ("input", "reset", 1),
        ("input", "start", 1),
        ("input", "in_data", circuit.stream.width),
        ("input", "in_valid", 1),
        ("output", "in_ready", 1),
        ("output", "phase", 4),
        ("output", "event_valid", 1),
        ("output", "event_kind", 4),
        ("output", "event_data", circuit.event_bits),
        ("output", "done", 1),
        *(("output", name, width) for name, width in circuit.pins.items()),
    )


def range_of(width: int) -> str:
    """The range of a port or a net of a width, as Verilog writes it."""
    return f"[{width - 1}:0] " if width > 1 else ""


def top_text(circuit: Circuit) -> str:
    """The Verilog of the top module: the circuit with its parameters."""
    return "\n".join(_top_lines(circuit)) + "\n"


def _top_lines(circuit: Circuit) -> Iterator[str]:
    ports = ports_of(circuit)
    yield f"// The circuit {circuit.top} with the parameters of one design point."
    yield f"module {top_name(circuit)} ("
    yield ",\n".join(f"    {way} wire {range_of(width)}{name}" for way, name, width in ports)
    yield ");"
    parameters = [f".{name}({_value(circuit, value)})" for name, value in circuit.parameters.items()]
    if parameters:
        yield f"    {circuit.top} #("
        yield ",\n".join(f"        {parameter}" for parameter in parameters)
        yield "    ) circuit ("
    else:
        yield f"    {circuit.top} circuit ("
    yield ",\n".join(f"        .{name}({name})" for _, name, _ in ports)
    yield "    );"
    yield "endmodule"


def _value(circuit: Circuit, value: int | str) -> str:
    """A parameter as Verilog writes it. Text names an image."""
    if isinstance(value, str):
        assert value in circuit.images, f"{value} is no image of {circuit.top}"
        return f'"{value}"'
    if isinstance(value, Bits):
        return f"{value.width}'d{value}"
    assert -(2**31) <= value < 2**31, f"{value} has more bits than a number without a width: use Bits"
    return str(value)


def write_design(circuit: Circuit, folder: Path) -> None:
    """Write the Verilog of a design point and its images into a folder, as tools read them."""
    for name, text in sources_of(circuit).items():
        (folder / name).write_text(text, encoding="utf-8")
    for name, image in circuit.images.items():
        (folder / name).write_text(image.hex_text(), encoding="utf-8")


def bound_of(expected: Expected) -> int:
    """The most cycles that a run may take: far more than expected, so that the difference can be seen."""
    cycles, last = sum(expected.cycles.values()), expected.events.cycle.max(initial=0)
    return max(cycles, int(last)) * 9 // 8 + 256


def work_of(circuit: Circuit, expected: Expected) -> int:
    """Elements of the circuit times the cycles of its run: the time of a simulation grows with it."""
    return circuit.elements * sum(expected.cycles.values())
