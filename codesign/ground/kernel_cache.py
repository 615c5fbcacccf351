"""The folder of numba's compiled kernels, and when kernels are compiled.

Where neither this package's folder nor the user's cache is writable, kernels get a private temporary folder.

A worker of a cluster keeps its kernels in a folder of its node, as many nodes may share a home folder. A folder of
kernels bears any number of readers and one writer. So of all workers on a machine, one at a time compiles, and a worker
that waited finds the kernel there (``compiled_once``).
"""

from __future__ import annotations

import os
import platform
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from codesign.ground.late import late

if TYPE_CHECKING:
    from numba.core import event
else:
    event = late("numba.core.event")

try:
    import fcntl
except ImportError:  # on Windows
    fcntl = None  # type: ignore[assignment]

VARIABLE = "NUMBA_CACHE_DIR"
_NODES = "nodes"

_PACKAGE = Path(__file__).resolve().parents[1]
T = TypeVar("T")


def provide_kernel_cache() -> None:
    """Set ``NUMBA_CACHE_DIR`` to a private temporary folder, where numba would have no other.

    Without a folder numba refuses to compile. Does nothing where the variable is set.
    """
    if os.environ.get(VARIABLE) or _may_write(_user_cache()):
        return
    # By default numba caches a kernel beside the module that it stands in.
    folders = {module.parent for module in _PACKAGE.rglob("*.py")}
    if all(_may_write(folder / "__pycache__") for folder in folders):
        return
    folder = _private_folder()
    if folder is None:
        return
    _keep_in(folder)


def _keep_in(folder: str) -> None:
    os.environ[VARIABLE] = folder
    reload_kernel_folder()


def reload_kernel_folder() -> None:
    """Let numba, where it is loaded, read ``NUMBA_CACHE_DIR`` again."""
    if "numba" in sys.modules:
        sys.modules["numba"].config.reload_config()


def kernel_folders() -> tuple[Path, ...]:
    """The folders where numba looks for compiled kernels of this package."""
    if os.environ.get(VARIABLE):
        return (Path(os.environ[VARIABLE]),)
    return (_PACKAGE, _user_cache())


def is_cold() -> bool:
    """True if no kernel is compiled yet: no folder has an index of numba."""
    return not any(next(folder.rglob("*.nbi"), None) for folder in kernel_folders() if folder.is_dir())


@contextmanager
def compiling_reported(report: Callable[[int], None]) -> Iterator[None]:
    """Call ``report`` with the number of kernels compiled so far: when the first begins, and when each is compiled.

    A kernel that is loaded from the cache is not reported. Only this process is watched.
    """

    class Watch(event.Listener):
        """Counts the kernels that numba compiles."""

        begun = False
        compiled = 0

        def on_start(self, _event: Any) -> None:
            if not self.begun:
                self.begun = True
                report(0)

        def on_end(self, _event: Any) -> None:
            self.compiled += 1
            report(self.compiled)

    with event.install_listener("numba:compile", Watch()):
        yield


@contextmanager
def compiling_timed() -> Iterator[Callable[[], float]]:
    """Gives a function that returns the seconds of processor time that compiling kernels has taken in this block."""

    class Watch(event.Listener):
        """Adds up the outermost compilations: a kernel compiles those that it calls."""

        spent = begun = 0.0
        depth = 0

        def on_start(self, _event: Any) -> None:
            if not self.depth:
                self.begun = time.process_time()
            self.depth += 1

        def on_end(self, _event: Any) -> None:
            self.depth -= 1
            if not self.depth:
                self.spent += time.process_time() - self.begun

    watch = Watch()
    with event.install_listener("numba:compile", watch):
        yield lambda: watch.spent


def keep_kernels_on_node(digest: str) -> str:
    """Keep the kernels of this process in a folder of this machine; why that is too late, or "".

    ``digest``: of the code. Each code has a folder of its own, so that a kernel of other code is never taken for one of
    this.

    Raises:
        OSError: the folder cannot be made.
    """
    node = "".join(mark if mark.isalnum() else "-" for mark in platform.node())
    # Without locks between processes each of them keeps its own.
    own = f"{node}-{digest[:16]}" + ("" if fcntl else f"-{os.getpid()}")
    base = os.environ.get(VARIABLE) or _private_folder()
    if base is None:
        raise OSError("there is no folder for temporary files")
    if Path(base).parent.name == _NODES:
        base = str(Path(base).parent.parent)
    folder = Path(base, _NODES, own)
    if os.environ.get(VARIABLE) != str(folder):
        if any(name.startswith("codesign.planners.") for name in sys.modules):
            return "it loaded kernels before: restart it"
        folder.mkdir(parents=True, exist_ok=True)
        _keep_in(str(folder))
    return ""


def compiled_once(compute: Callable[[], T]) -> T:
    """The result of ``compute``. Of all processes that call this, one at a time compiles the kernels that it needs.

    ``compute`` begins again where a kernel is missing. Processes with folders of kernels of their own
    (``NUMBA_CACHE_DIR``) do not wait for each other.
    """
    folder = os.environ.get(VARIABLE) or _private_folder()
    if fcntl is None or folder is None:
        return compute()

    class Refuse(event.Listener):
        """Ends a computation that would compile."""

        def on_start(self, _event: Any) -> None:
            raise _MissingKernel

        def on_end(self, _event: Any) -> None:
            """Nothing was compiled."""

    try:
        with event.install_listener("numba:compile", Refuse()):
            return compute()
    except _MissingKernel:
        Path(folder).mkdir(parents=True, exist_ok=True)
        with open(Path(folder, "lock"), "wb") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            return compute()


class _MissingKernel(BaseException):
    """A kernel is not compiled. No exception that code handles: it passes through all of it."""


def _user_cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "numba"


def _may_write(folder: Path) -> bool:
    """True if ``folder`` can be written to, or can be made in its nearest existing parent."""
    path = os.path.abspath(folder)
    while not os.path.lexists(path):
        path = os.path.dirname(path)
    return os.path.isdir(path) and os.access(path, os.W_OK | os.X_OK)


def _private_folder() -> str | None:
    # Imported late: it is slow to import, and seldom needed.
    try:
        user = os.getuid() if hasattr(os, "getuid") else 0
        folder = os.path.join(tempfile.gettempdir(), f"hwsw-codesign-{user}")
        try:
            os.mkdir(folder, 0o700)
        except FileExistsError:
            # The contents of a cache are executed, so a folder that another user made or may write to is not used.
            status = os.lstat(folder)
            others = stat.S_IMODE(status.st_mode) & 0o077
            if not stat.S_ISDIR(status.st_mode) or status.st_uid != user or others:
                return tempfile.mkdtemp(prefix="hwsw-codesign-")
    except OSError:
        return None
    return folder
