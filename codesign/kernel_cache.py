"""The folder of numba's compiled kernels, and when kernels are compiled.

Where neither this package's folder nor the user's cache is writable, kernels get a private temporary folder.
"""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

VARIABLE = "NUMBA_CACHE_DIR"


def provide_kernel_cache() -> None:
    """Set ``NUMBA_CACHE_DIR`` to a private temporary folder, where numba would have no other.

    Without a folder numba refuses to compile. Does nothing where the variable is set.
    """
    if os.environ.get(VARIABLE) or _may_write(_user_cache()):
        return
    # By default numba caches a kernel beside the module that it stands in.
    folders = {module.parent for module in Path(__file__).parent.rglob("*.py")}
    if all(_may_write(folder / "__pycache__") for folder in folders):
        return
    folder = _private_folder()
    if folder is None:
        return
    os.environ[VARIABLE] = folder
    if "numba" in sys.modules:
        sys.modules["numba"].config.reload_config()


def kernel_folders() -> tuple[Path, ...]:
    """The folders where numba looks for compiled kernels of this package."""
    if os.environ.get(VARIABLE):
        return (Path(os.environ[VARIABLE]),)
    return (Path(__file__).parent, _user_cache())


def is_cold() -> bool:
    """Whether no kernel is compiled yet: no folder has an index of numba."""
    return not any(next(folder.rglob("*.nbi"), None) for folder in kernel_folders() if folder.is_dir())


@contextmanager
def compiling_reported(report: Callable[[int], None]) -> Iterator[None]:
    """Call ``report`` with the number of kernels compiled so far: when the first begins, and when each is compiled.

    A kernel that is loaded from the cache is not reported. Only this process is watched.
    """
    from numba.core import event

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


def _user_cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "numba"


def _may_write(folder: Path) -> bool:
    """Whether ``folder`` can be written to, or can be made in its nearest existing parent."""
    path = os.path.abspath(folder)
    while not os.path.lexists(path):
        path = os.path.dirname(path)
    return os.path.isdir(path) and os.access(path, os.W_OK | os.X_OK)


def _private_folder() -> str | None:
    # Imported late: it is slow to import, and seldom needed.
    import tempfile

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
