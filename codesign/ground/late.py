"""Modules that are imported when they are first used.

A short command needs none of SciPy, matplotlib or the compiled kernels: ``ndimage = late("scipy.ndimage")`` stands at
the head of a module and loads nothing. Rejected: ``lazy_loader.load``. It puts an empty module into ``sys.modules``,
and two threads that use it at once may find it half filled.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


class _Late:
    """A module that is not imported yet."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        return getattr(import_module(self._name), attribute)


def late(module: str) -> Any:
    """The module of that name, which is imported when one of its names is first asked for.

    >>> late("math").floor(2.5)
    2
    """
    return _Late(module)
