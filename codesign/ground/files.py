"""Files are written completely or not at all. Devices, pipes and folders are never replaced.

What is written has a temporary name beside its own, with the machine and the process in it. So the next process that
writes there removes what a killed one left. It is renamed once it is on the disk: after a loss of power there is the
old file or the new one, and no empty one.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import secrets
import shutil
import stat
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Self

from codesign.ground.errors import RunError

CACHE_VARIABLE = "CODESIGN_CACHE_DIR"
"""The environment variable that names another folder than ``cache_folder``."""

_passing: set[Path] = set()


def cache_folder() -> Path:
    """The folder of all caches: ``CODESIGN_CACHE_DIR`` if set, else ``hwsw-codesign`` in the user's cache folder."""
    named = os.environ.get(CACHE_VARIABLE)
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "hwsw-codesign"


def kept_folder(*names: str) -> Path:
    """A folder of ``cache_folder`` by its names, made where it is missing.

    What is kept is executed or believed, so a folder that another user owns or may write to is refused.

    Raises:
        OSError: it cannot be made, written to or trusted; ``strerror`` says why.
    """
    folder = cache_folder()
    for name in ("", *names):
        folder /= name
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.stat()
        if os.name == "posix" and (status.st_uid != os.getuid() or stat.S_IMODE(status.st_mode) & 0o022):
            raise PermissionError(0, "another user owns the folder or may write to it", str(folder))
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(0, "the folder cannot be written to", str(folder))
    return folder


def _sign() -> str:
    """The machine in a temporary name: several may share a disk."""
    return hashlib.sha256(platform.node().encode()).hexdigest()[:6]


def part_of(target: Path) -> Path:
    """A new temporary name beside ``target``. Parts that dead processes left there are removed."""
    sweep(target.parent)
    # The name is cut, so that the longer temporary name is not too long for any file system.
    return target.with_name(f".{target.name[:16]}.{_sign()}-{os.getpid()}-{secrets.token_hex(4)}.part")


def sweep(folder: Path) -> None:
    """Remove from a folder the parts of processes of this machine and user that ended without removing them."""
    if os.name != "posix":
        return
    part = re.compile(rf"\..*\.{_sign()}-(\d+)-[0-9a-f]{{8}}\.part", re.DOTALL)
    with suppress(OSError):
        for name in os.listdir(folder):
            found = part.fullmatch(name)
            path = Path(folder, name)
            if found and not _is_alive(int(found[1])) and path.lstat().st_uid == os.getuid():
                _remove(path)


def _is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return True


@contextmanager
def scratch() -> Iterator[Path]:
    """A temporary folder of the system, removed at the end of the block."""
    with passing(part_of(Path(tempfile.gettempdir(), "hwsw"))) as folder:
        folder.mkdir(mode=0o700)
        yield folder


def put(part: Path, target: Path) -> None:
    """Rename a finished file or folder to ``target``, once it is on the disk."""
    for folder, _, names in os.walk(part):
        for name in names:
            _to_disk(Path(folder, name))
    _to_disk(part)
    part.replace(target)
    _to_disk(target.parent)


def _to_disk(path: Path) -> None:
    folder = path.is_dir()
    if folder and os.name != "posix":
        return
    descriptor = os.open(path, os.O_RDONLY if folder or os.name == "posix" else os.O_RDWR)
    try:
        os.fsync(descriptor)
    except OSError:
        # Some file systems cannot do it for a folder.
        if not folder:
            raise
    finally:
        os.close(descriptor)


@contextmanager
def passing(path: Path) -> Iterator[Path]:
    """A temporary file or folder of this process. It is removed at the end of the block if it still exists."""
    _passing.add(path)
    try:
        yield path
    finally:
        _remove(path)
        _passing.discard(path)


def remove_passing() -> None:
    """Remove all files that are ``passing`` now, for a process that must end without unwinding."""
    for path in list(_passing):
        _remove(path)


def _remove(path: Path) -> None:
    # No file has a name with a null byte: ValueError.
    with suppress(OSError, ValueError):
        path.unlink()
    with suppress(ValueError):
        shutil.rmtree(path, ignore_errors=True)


def landing(path: Path) -> Path:
    """The target of a write to ``path``: the end of its symbolic links, which need not exist yet."""
    return Path(os.path.realpath(path))


def is_stream(path: Path) -> bool:
    """True if ``path`` is a FIFO or a character device: both are written to and never replaced."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False
    return stat.S_ISFIFO(mode) or stat.S_ISCHR(mode)


def is_special(path: Path) -> bool:
    """True if ``path`` exists and is no regular file but a folder, device, FIFO or socket."""
    try:
        return not stat.S_ISREG(path.stat().st_mode)
    except (OSError, ValueError):
        return False


def write_atomically(path: Path, content: bytes) -> None:
    """Write ``content`` to a temporary file, then rename it to ``path``. Until then the old file remains.

    A symbolic link is followed and kept. The content is written directly into a FIFO or a character device.

    Raises:
        RunError: the folder is missing or cannot be written to, the disk is full, or ``path`` is a folder, a
            socket or a disk.
    """
    if is_stream(path):
        _write_through(path, content)
        return
    with written_atomically(path) as part:
        part.write_bytes(content)


class WholeOrAbsent(ABC):
    """A writer of something that is whole at ``path`` after ``close``, and absent after ``abort``.

    It is written at a temporary path, to be handed to ``_hold``, which removes it if it is still there at the end. As a
    context manager it is closed at the end of the block, or aborted by an error.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._target = landing(self.path)
        self._finished = False
        self._held = ExitStack()

    def _hold(self, part: Path) -> None:
        self._held.enter_context(passing(part))

    @abstractmethod
    def _finish(self) -> None:
        """Complete what was written, and rename it to ``_target``."""

    @abstractmethod
    def _drop(self) -> None:
        """Close what is open. It is removed next, so an OSError is ignored."""

    def close(self) -> None:
        """Finish, and rename to ``path``. A second call does nothing."""
        if self._finished:
            return
        try:
            self._finish()
        except BaseException:
            self.abort()
            raise
        self._finished = True
        self._held.close()

    def abort(self) -> None:
        """Remove what was written. After ``close`` it does nothing."""
        if self._finished:
            return
        self._finished = True
        with suppress(OSError):
            self._drop()
        self._held.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self.abort()


@contextmanager
def written_atomically(path: Path) -> Iterator[Path]:
    """A temporary file to write to. It is renamed to ``path`` at the end. Until then the old file remains.

    Raises:
        RunError: see ``write_atomically``; or ``path`` is a stream.
    """
    if is_special(path):
        raise RunError("cannot write: is no regular file", str(path), "name a file")
    try:
        target = landing(path)
        name = part_of(target)
        os.close(os.open(name, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
    except (OSError, ValueError) as error:
        raise RunError(
            f"cannot write: {_reason(error)}", str(path), "name a file in a folder that exists and can be written to"
        ) from error
    with passing(name) as part:
        try:
            yield part
            part.chmod(_mode_of(target))
            put(part, target)
        except OSError as error:
            raise RunError(
                f"cannot write: {_reason(error)}", str(path), "free some space, or name another file"
            ) from error


def write_folder(folder: Path, files: Mapping[str, bytes], stale: Iterable[str] = ()) -> None:
    """Write all files into a folder, or none: they are written beside it, and the folder takes its place at once.

    Other files of the folder remain. ``stale``: names of files that do not.

    Raises:
        RunError: the folder cannot be made or written to, or the disk is full.
    """
    try:
        target = landing(folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        part = part_of(target)
        part.mkdir(mode=0o700)
    except (OSError, ValueError) as error:
        hint = "name a folder that can be made and written to"
        raise RunError(f"cannot write: {_reason(error)}", str(folder), hint) from error
    old = part.with_suffix(".old")
    with passing(part):
        try:
            for name, content in files.items():
                (part / name).write_bytes(content)
            part.chmod(_by_default(0o777))
            replaced = {*files, *stale}
            kept = [each for each in target.iterdir() if each.name not in replaced] if target.is_dir() else []
            for each in kept:
                _copy(each, part / each.name)
            if target.is_dir():
                target.rename(old)
            put(part, target)
        except OSError as error:
            hint = "free some space, or name another folder"
            raise RunError(f"cannot write: {_reason(error)}", str(folder), hint) from error
        finally:
            # It is no passing file: an end at this place would lose what was there before.
            if old.exists() and not target.exists():
                old.rename(target)
            _remove(old)


def _copy(source: Path, target: Path) -> None:
    if source.is_dir() and not source.is_symlink():
        shutil.copytree(source, target, symlinks=True)
    else:
        shutil.copy2(source, target, follow_symlinks=False)


def _by_default(mode: int) -> int:
    """A mode without what the user's mask takes away."""
    mask = os.umask(0)
    os.umask(mask)
    return mode & ~mask


def _write_through(path: Path, content: bytes) -> None:
    try:
        with path.open("wb") as file:
            file.write(content)
    except OSError as error:
        raise RunError(f"cannot write: {_reason(error)}", str(path), "name a file") from error


def _reason(error: Exception) -> str:
    number = getattr(error, "errno", None)
    return os.strerror(number) if number else str(error)


def _mode_of(target: Path) -> int:
    # A part has 0o600. A file should have the mode of the file that it replaces, or the default mode of its user.
    try:
        return stat.S_IMODE(target.stat().st_mode)
    except OSError:
        return _by_default(0o666)


_LAST = 253402300799
"""The last second of the year 9999."""


def date_of_writing() -> str:
    """The day, UTC: of the environment variable SOURCE_DATE_EPOCH (seconds since 1970) where it has one, else today."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    fixed = int(epoch) if epoch.isdecimal() and len(epoch) <= 12 and int(epoch) <= _LAST else None
    now = datetime.now(UTC) if fixed is None else datetime.fromtimestamp(fixed, UTC)
    return now.date().isoformat()
