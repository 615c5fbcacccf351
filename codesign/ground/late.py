"""Modules that are imported when they are first used, and packages that import a module when a name of it is asked for.

A short command needs none of SciPy, matplotlib or the compiled kernels: ``ndimage = late("scipy.ndimage")`` stands at
the head of a module and loads nothing. Rejected: ``lazy_loader.load``. It puts an empty module into ``sys.modules``,
and two threads that use it at once may find it half filled.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

import lazy_loader


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


def load(name: str) -> Any:
    """The object ``module:name``; its module is imported now."""
    module, _, attribute = name.partition(":")
    return getattr(import_module(module), attribute)


class _Package(ModuleType):
    """A package. The import of its module ``prepare`` does not take the place of its function of the same name."""

    def __setattr__(self, name: str, value: object) -> None:
        if name not in self.__all__ or not isinstance(value, ModuleType):
            super().__setattr__(name, value)


def by_name(package: str, file: str) -> Any:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a package whose names its stub ``__init__.pyi`` imports."""
    sys.modules[package].__class__ = _Package
    return lazy_loader.attach_stub(package, file)
