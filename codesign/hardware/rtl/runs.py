"""One run of a circuit, whichever simulator runs it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codesign.planners.circuits import Circuit, Events, Pins

Progress = Callable[[str, int, int], None]
"""Called with what a simulator does, the cycles that it has simulated, and those expected: 0 while it builds."""


def silent(_words: str, _done: int, _expected: int) -> None:
    """Report no progress."""


HINT = "verify a smaller design, such as one with smaller blocks or a smaller map, or try another --backend"
"""The remedy where a simulator does not end in time."""


@dataclass(frozen=True)
class Waves:
    """A waveform that is wanted: the VCD file, and its first and last cycle."""

    file: Path
    first: int
    last: int


@dataclass(frozen=True, eq=False)
class Run:
    """One run of a circuit.

    - ``events``: what it reported. ``cycles``: by phase, and under "" those outside of all phases.
    - ``taken``: words of the stream that it took. ``ended``: whether ``done`` was seen within the bound.
    - ``pins``: what its further outputs showed, up to the cycle that was simulated last; None where it has none.
    """

    events: Events
    cycles: Mapping[str, int]
    taken: int
    ended: bool
    pins: Pins | None = None


def phases_of(circuit: Circuit, counts: Mapping[int, int]) -> dict[str, int]:
    """The cycles by the name of the phase, from those by its number. A number without a name keeps it as its name."""
    names = ("", *circuit.phases)
    return {names[i] if i < len(names) else f"phase {i}": count for i, count in counts.items() if count}


def stream_chunks(circuit: Circuit) -> bytes:
    """The words of the stream in chunks of 32 bits, the lowest first, as the native simulator reads them."""
    width = -(-circuit.stream.width // 32) * 4
    return b"".join(int(word).to_bytes(width, "little") for word in circuit.stream.words)


def events_of(records: NDArray[np.uint64]) -> Events:
    """Events from rows of (cycle, kind, value) as uint64."""
    return Events(records[:, 0].astype(np.int64), records[:, 1].astype(np.uint8), records[:, 2].copy())


def pins_of(circuit: Circuit, changes: NDArray[np.uint64], end: int, known: NDArray[np.uint64] | None = None) -> Pins:
    """Pins from rows of (cycle, anything, value) as uint64; ``known``: the bits that are 0 or 1, by default all."""
    every = np.uint64((1 << sum(circuit.pins.values())) - 1)
    known = np.full(len(changes), every) if known is None else known
    return Pins(changes[:, 0].astype(np.int64), changes[:, 2].copy(), known, end)
