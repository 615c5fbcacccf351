"""The code on a worker of a cluster: it reports its versions, takes a function, and computes batches of work.

A worker imports this module before any kernel, so that its kernels are kept in a folder of its node. All else comes as
bytes that are read afterwards. It does not know the kind of work.
"""

from __future__ import annotations

import os
import pickle
import platform
import threading
from collections.abc import Callable
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from codesign.ground.kernel_cache import is_cold, keep_kernels_on_node

COMPARED = ("numba", "llvmlite", "numpy", "scipy")
"""The packages that a figure may depend on, to the last bit."""

_COMPUTING = threading.Lock()


def versions() -> dict[str, str]:
    """The versions of Python and of the packages that a figure depends on; "none": it is not installed."""
    found = {"Python": ".".join(platform.python_version_tuple()[:2])}
    for name in COMPARED:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    return found


def introduced(digest: str) -> dict[str, Any]:
    """Keep the kernels of this worker on its node, and say what it is made of.

    - ``versions``: see there. ``host``, ``process``: where it runs.
    - ``fault``: why it cannot be used; "" where it can. ``cold``: True if its node has no kernel yet.
    """
    try:
        fault = keep_kernels_on_node(digest)
    except OSError as wrong:
        fault = f"it has no folder for its kernels: {wrong}"
    return {"versions": versions(), "host": platform.node(), "process": os.getpid(), "fault": fault, "cold": is_cold()}


class Held:
    """The function of a worker: the bytes that it came as, until it is needed.

    A worker that runs short of memory may write it to its disk and read it again.
    """

    def __init__(self, data: bytes) -> None:
        self._data = data

    @cached_property
    def compute(self) -> Callable[[Any, float], tuple[list[Any], float]]:
        """Computes the first items of a batch: as many as are begun within some seconds, and at least one."""
        compute: Callable[[Any, float], tuple[list[Any], float]] = pickle.loads(self._data)
        return compute

    def __reduce__(self) -> tuple[type[Held], tuple[bytes]]:
        return Held, (self._data,)


def hold(data: bytes, digest: str) -> Held:
    """Take the function of a worker."""
    keep_kernels_on_node(digest)
    return Held(data)


def compute(held: Held, works: bytes, seconds: float) -> tuple[list[Any], float]:
    """The results of the first items of a batch, in order, and the seconds that they took.

    A process computes one batch at a time, whatever number of threads it has: the function is not for several threads,
    and threads of Python do not compute side by side.
    """
    with _COMPUTING:
        return held.compute(pickle.loads(works), seconds)
