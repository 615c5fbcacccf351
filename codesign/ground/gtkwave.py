"""Files beside a waveform (VCD) that GTKWave reads: what is shown in which group, and names for numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Literal

from vcd.gtkw import GTKWSave, make_translation_filter

Form = Literal["hex", "dec", "real"]

NOTHING = "–"
"""The text that a signal of names shows while there is none."""


@dataclass(frozen=True)
class Shown:
    """A signal as it is shown: its full ``name`` in the VCD, its width, and the name of its translate file, or ""."""

    name: str
    bits: int
    form: Form = "dec"
    translate_file: str = ""


def translation(names: Iterable[tuple[int, str]], bits: int) -> str:
    """The text of a translate file: a name for each number of a signal of so many bits."""
    pairs = [(number, ascii_text(name)) for number, name in names]
    return make_translation_filter(pairs, datafmt="hex", size=bits) + "\n"


def save_file(vcd: Path, groups: Mapping[str, Sequence[Shown]]) -> str:
    """The text of a save file that shows these signals in groups.

    Files are named as they lie beside it, so the folder may be moved.
    """
    text = StringIO()
    save = GTKWSave(text)
    save.dumpfile(vcd.name, abspath=False)
    save.size(1600, 900)
    for group, signals in groups.items():
        with save.group(group):
            for signal in signals:
                suffix = f"[{signal.bits - 1}:0]" if signal.bits > 1 and signal.form != "real" else ""
                form = "hex" if signal.translate_file else signal.form
                save.trace(f"{signal.name}{suffix}", datafmt=form, translate_filter_file=signal.translate_file or None)
    return text.getvalue()


def ascii_text(text: str) -> str:
    """Text on one line in ASCII, without what ends a part of a VCD."""
    plain = " ".join(text.replace(NOTHING, "-").encode("ascii", "replace").decode("ascii").split())
    return plain.replace("$", "S")
