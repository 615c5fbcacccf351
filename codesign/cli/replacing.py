"""The files that a command may replace: files of the kind that it writes, by what they hold.

A name typed in haste must not cost a file that took hours. So an output takes the place of a file only if that is
empty, or of the same kind: a page of hwsw, a table of hwsw, a picture. Anything else needs another name, or
``--force``. Rejected: to refuse every file that is there, since pages and tables are made again and again. Rejected: to
go by the ending of the name, which a result and a layout share.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import click

from codesign.ground.errors import InputError
from codesign.ground.files import is_special

FORCE = "codesign.force"
_END = 2**20


@dataclass(frozen=True)
class Kind:
    """A kind of output: what it is called, with what it begins (any of these), and what stands in it.

    ``holds`` stands in the first or the last MiB.
    """

    words: str
    begins: tuple[bytes, ...]
    holds: bytes = b""


_PICTURE = Kind("a picture", (b"\x89PNG\r\n", b"<?xml", b"<svg", b"%PDF-"))
_WAVEFORM = Kind("a waveform", (b"$",), b"$enddefinitions")
KINDS = {
    "--html": Kind("a page of hwsw", (b"<!DOCTYPE html>",), b'name="generator" content="hwsw-codesign"'),
    "--csv": Kind("a table of hwsw", (b"index,", b"paper,")),
    "--poses": Kind("a table of poses", (b"time_ps,source,robot,",)),
    "--parquet": Kind("a table of hwsw", (b"PAR1",), b"hwsw."),
    "--certify": Kind("a certificate", (b"PK\x03\x04",), b"definition.json"),
    "advise --certify": Kind("a certificate of an answer", (b"{",), b'"kind": "advice certificate"'),
    "--trace": Kind("a trace of hwsw", (b"\x89MCAP0",), b"codesign."),
    "--perfetto": Kind("a trace of Perfetto by hwsw", (b"\n",), b"\x12\x08platform"),
    "--vcd": _WAVEFORM,
    "--waves": _WAVEFORM,
    ".gtkw": Kind("a save file of GTKWave", (b"[", b"@"), b"[dumpfile]"),
    "--picture": _PICTURE,
    "--png": _PICTURE,
    "--plots": _PICTURE,
    "plot": _PICTURE,
    "layout": Kind("a layout", (b"{",), b'"configById"'),
    "blueprint": Kind("a blueprint", (b"RRF",)),
    "calibration": Kind("a calibration", (b"# Written by hwsw calibrate",)),
    "host": Kind("a host of hwsw calibrate", (b"# Written by hwsw calibrate host",)),
    "measured": Kind("a platform of hwsw measured", (b"# Written by hwsw measured",)),
    "-o": Kind("a page of hwsw fidelity", (b"# How far the model carries",)),
    "--write": Kind("a workload of hwsw advise", (b"# The design that hwsw advise chose",)),
}
"""By option; by the word of the command where several have the option."""


def check_replaceable(option: str, path: Path, kind: str = "") -> None:
    """Refuse an output that would take the place of a file of another kind, unless ``--force`` was given.

    ``kind``: a key of ``KINDS``, or the word of the command that one begins with; by default ``option``.

    Raises:
        InputError: there is such a file.
    """
    context = click.get_current_context(silent=True)
    wanted = next(KINDS[key] for key in (f"{kind} {option}", kind, option) if key in KINDS)
    if (context is not None and FORCE in context.meta) or _is_of(path, wanted):
        return
    what = f"would replace a file that is not {wanted.words}"
    raise InputError(what, f"{option} {path}", "name another file, or add --force")


def _is_of(path: Path, kind: Kind) -> bool:
    """True if nothing is lost: no file is there, an empty one, none that can be replaced, or one of the kind."""
    if not path.exists() or is_special(path):
        return True
    try:
        with path.open("rb") as file:
            head = file.read(_END)
            file.seek(-min(_END, file.seek(0, os.SEEK_END)), os.SEEK_END)
            ends = head, file.read(_END)
    except OSError:
        return False
    return not head or (head.startswith(kind.begins) and any(kind.holds in end for end in ends))
