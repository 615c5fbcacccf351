"""A rosbag2 folder with MCAP storage, written message by message: whole or absent, the same bytes each time."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from codesign.ground.errors import InputError, RunError, reason_of
from codesign.ground.files import WholeOrAbsent, landing, part_of, put
from codesign.views.bags.library import load, typestore

VERSION: Any = 9
"""Of the format of rosbag2: the version of ROS 2 Jazzy."""


def check_new(folder: Path, option: str) -> None:
    """Check, before any work, that a bag can be written to ``folder``, which does not exist or is empty.

    Raises:
        InputError: it cannot. RunError: the library is missing.
    """
    load("rosbag2")
    where = f"{option} {folder}"
    try:
        target = landing(folder)
        if target.exists() and not target.is_dir():
            raise InputError("is a file, and a bag is a folder", where, "name a folder that does not exist")
        if target.exists() and any(target.iterdir()):
            hint = "name a folder that does not exist, or remove this one"
            raise InputError("exists already, and is not empty", where, hint)
        if not target.parent.is_dir():
            raise InputError(f"folder {target.parent} does not exist", where, "make it first")
        with tempfile.TemporaryDirectory(dir=target.parent):
            pass
    except (OSError, ValueError) as fault:
        hint = "name a folder in one that exists and can be written to"
        raise InputError(reason_of(fault), where, hint) from fault


class BagFolder(WholeOrAbsent):
    """Writes messages to a bag. As a context manager it is closed at the end of the block, or removed by an error.

    The bag is written to a temporary folder beside ``path``, and renamed by ``close``.

    Raises:
        RunError: the library is missing, or the bag cannot be written. The temporary folder is removed.
    """

    def __init__(self, path: Path) -> None:
        library = load("rosbag2")
        super().__init__(path)
        self._open: dict[str, Any] = {}
        self._writer: Any = None
        with self._guard():
            part = part_of(self._target)
            self._hold(part)
            part.mkdir()
            # The library names the file of messages after the folder.
            self._part = part / self._target.name
            self._writer = library.Writer(self._part, version=VERSION, storage_plugin=library.StoragePlugin.MCAP)
            # The chunks of the file, which every reader of MCAP unpacks.
            self._writer.set_compression(library.CompressionMode.STORAGE, library.CompressionFormat.ZSTD)
            self._writer.open()

    def write(self, topic: str, time: int, message: Any, latched: bool = False) -> None:
        """Write a message at ``time``, ns. ``latched``: a reader that comes later gets the last one."""
        with self._guard():
            kind = message.__msgtype__
            connection = self._open.get(topic)
            if connection is None:
                qos = [_qos(latched)]
                connection = self._writer.add_connection(topic, kind, typestore=typestore(), offered_qos_profiles=qos)
                self._open[topic] = connection
            self._writer.write(connection, time, typestore().serialize_cdr(message, kind))

    def _finish(self) -> None:
        with self._guard():
            self._writer.close()
            if self._target.is_dir():
                self._target.rmdir()
            put(self._part, self._target)

    def _drop(self) -> None:
        if self._writer is not None:
            with suppress(AttributeError):
                self._writer.abort()

    @contextmanager
    def _guard(self) -> Iterator[None]:
        if self._finished:
            raise RunError("is closed", str(self.path), "write no message after the end of the run")
        try:
            yield
        except (OSError, ValueError) as fault:
            self.abort()
            hint = "name a new folder in one that exists, can be written to and has free space"
            raise RunError(f"the bag cannot be written: {reason_of(fault)}", str(self.path), hint) from fault


def _qos(latched: bool) -> Any:
    ros = load("interfaces")
    durability = getattr(ros.QosDurability, "TRANSIENT_LOCAL" if latched else "VOLATILE")
    forever = ros.QosTime(0, 0)
    return ros.Qos(
        ros.QosHistory.KEEP_LAST, 1 if latched else 10, ros.QosReliability.RELIABLE, durability, forever, forever,
        ros.QosLiveliness.AUTOMATIC, forever, False,
    )  # fmt: skip
