"""The files of a circuit, its digest, and the top module that carries it.

The top of a design point is a module ``hwsw_`` and 12 hexadecimal digits. It has no parameters, so every tool takes it,
and its name recognises the design in the report of any tool.
"""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import sha256
from pathlib import Path

from codesign.ground.files import kept_folder, part_of, passing, put, scratch
from codesign.planners.circuits import Bits, Circuit, Expected

# What tools made is kept in the user's cache folder, each under the digest of all that it depends on.

MOST_BYTES = 512 * 2**20
"""Above it the entries that were unused for the longest time are removed."""

_YOUNG_S = 3600.0
"""An entry that was used within this time is never removed: another process may read it."""


def digest_of(*parts: str | bytes) -> str:
    """The digest of a sequence of texts."""
    whole = sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        whole.update(len(data).to_bytes(8, "little") + data)
    return whole.hexdigest()


@contextmanager
def kept(kind: str, digest: str, make: Callable[[Path], None]) -> Iterator[Path]:
    """The folder of an entry until the end of the block; ``make`` fills it where there is none.

    Where the cache cannot be written to, the folder is a temporary one.
    """
    folder = _folder(kind)
    if folder is not None and (folder / digest).is_dir():
        with suppress(OSError):
            os.utime(folder / digest)
        yield folder / digest
        return
    if folder is None:
        with scratch() as part:
            make(part)
            yield part
        return
    with passing(part_of(folder / digest)) as part:
        part.mkdir(mode=0o700)
        make(part)
        _prune(folder)
        with suppress(OSError):
            put(part, folder / digest)
        # Another process may have made the same entry at the same time.
        yield folder / digest if (folder / digest).is_dir() else part


def _folder(kind: str) -> Path | None:
    """The folder of all entries of a kind, or None where it cannot be used."""
    try:
        return kept_folder("rtl", kind)
    except OSError:
        return None


def _prune(folder: Path) -> None:
    """Remove the entries that were unused for the longest time, until the others are small enough."""
    with suppress(OSError):
        entries = sorted(folder.iterdir(), key=lambda entry: -entry.stat().st_mtime)
        total = 0
        for entry in entries:
            total += sum(file.stat().st_size for file in entry.rglob("*"))
            if total > MOST_BYTES and time.time() - entry.stat().st_mtime > _YOUNG_S:
                shutil.rmtree(entry, ignore_errors=True)


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
