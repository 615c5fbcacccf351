"""Checks of outputs before any work: all can be written, and a file is replaced by one of its kind alone.

A name typed in haste must not cost a file that took hours. So an output takes the place of a file only if that is
empty, or of the same kind by what it holds: a page, a table, a picture. Anything else needs another name, or
``--force``. Rejected: to refuse every file that is there, since pages and tables are made again and again. Rejected: to
go by the ending of the name, which a result and a layout share.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import click

from codesign.ground.errors import InputError, reason_of
from codesign.ground.files import is_special, is_stream, landing

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
    "robot --write": Kind("a platform of hwsw advise", (b"# A robot that hwsw advise put on",)),
    "commands --write": Kind("the commands of hwsw advise", (b"# The commands of an answer of hwsw advise",)),
    "answer --write": Kind("an answer of hwsw advise", (b"{",), b'"question": "Asked: '),
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


_SQLITE = ("-wal", "-shm", "-journal")
_ROOM = "name a file in a folder that exists and can be written to"


def check_outputs(
    outputs: Mapping[str, Path | None],
    inputs: Iterable[str | Path | None] = (),
    *,
    store: tuple[str, Path] | None = None,
    plain: Iterable[str] = (),
    kind: str = "",
) -> None:
    """Check the files that a command will write.

    Args:
        outputs: by option; None where the option was not given.
        inputs: the files that the command reads. A name that is no file (of a shipped spec) is ignored.
        store: option and SQLite file of explored points, which is read and written.
        plain: the options of ``outputs`` that need a regular file, and accept no FIFO or device.
        kind: what kind of file the outputs are, a key of ``KINDS``; by default the kind of each option.

    Raises:
        InputError: an output cannot be written, is an input, another output, or standard output, or would replace a
            file of another kind.
    """
    taken: dict[object, str] = {}
    for path in inputs:
        if path is not None and os.path.isfile(path):
            taken[_identity(Path(path))] = f"{path}, which is read"
    requested = [(option, path) for option, path in outputs.items() if path is not None]
    if store is not None:
        option, path = store
        _check_file(option, path, regular=True)
        _claim(taken, option, path)
        for suffix in _SQLITE:
            taken[_identity(path.with_name(path.name + suffix))] = f"a part of {option}"
    for descriptor in _standard_streams():
        taken.setdefault(descriptor, "standard output")
    for option, path in requested:
        _check_file(option, path, regular=option in set(plain))
        if not is_stream(path):
            _claim(taken, option, path)
        check_replaceable(option, path, kind)
        if option in ("--vcd", "--waves"):
            check_replaceable(option, path.with_suffix(".gtkw"), ".gtkw")


def check_folder(option: str, folder: Path | None, files: Mapping[str, Path | None]) -> None:
    """Check a folder for plots, which is made if missing. No plot may overwrite one of ``files``, or another file.

    Raises:
        InputError: the folder can neither be made nor written to, or a file may be overwritten by a plot.
    """
    if folder is None:
        return
    try:
        nearest = next(each for each in (folder.absolute(), *folder.absolute().parents) if each.exists())
    except (OSError, ValueError) as fault:
        raise InputError(reason_of(fault), f"{option} {folder}", "choose another folder") from fault
    if not nearest.is_dir() or not os.access(nearest, os.W_OK | os.X_OK):
        raise InputError("the folder cannot be made or written to", f"{option} {folder}", "choose another")
    for present in sorted(folder.glob("*.svg")):
        check_replaceable(option, present)
    for other, path in files.items():
        if path is not None and path.suffix == ".svg" and landing(path).parent == landing(folder):
            raise InputError(f"a plot may overwrite {path}", option, f"name another file for {other}")


def _claim(taken: dict[object, str], option: str, path: Path) -> None:
    owner = taken.setdefault(_identity(path), option)
    if owner != option:
        raise InputError(f"{path} is the file of {owner}", option, "give every output a file of its own")


def _check_file(option: str, path: Path, *, regular: bool) -> None:
    where = f"{option} {path}"
    if not path.name:
        raise InputError("an empty name is no file", option, "name a file")
    try:
        path.lstat()
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as fault:
        raise InputError(reason_of(fault), where, _ROOM) from fault
    if is_special(path) and (regular or not is_stream(path)):
        raise InputError("is no regular file", where, "name a file")
    target = landing(path)
    if not target.parent.is_dir():
        raise InputError(f"folder {target.parent} does not exist", where, "make it first")
    if target.is_symlink():
        raise InputError("is a symbolic link to itself", where, "name a file")
    if not is_stream(path) and not os.access(target.parent, os.W_OK | os.X_OK):
        raise InputError(f"folder {target.parent} cannot be written to", where, _ROOM)


def _identity(path: Path) -> object:
    """Equal for two names of one file: links of either kind, and files that do not exist yet."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return landing(path)
    return status.st_dev, status.st_ino


def _standard_streams() -> Iterable[object]:
    for stream in (sys.stdout, sys.stderr):
        # Streams of a test or a notebook have no descriptor.
        with suppress(OSError, ValueError, AttributeError):
            status = os.fstat(stream.fileno())
            yield status.st_dev, status.st_ino
