"""Tables of keys in the docs, and the keys and defaults of the models that they are of."""

from __future__ import annotations

import re
from enum import StrEnum
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from codesign.ground.figures import Figure
from codesign.ground.units import Dimension, format_quantity, parse_quantity
from codesign.inputs.fields import Duration

LEADING = re.compile(r"^\| (`[^|]*`) \| ([^|]*) \| (.*) \|$", re.MULTILINE)
"""A row that begins with names of keys: the names, their defaults, the meaning."""


def rows(text: str) -> dict[str, tuple[str, str]]:
    """By key, its default as written and what it means; a row may be of several keys, with a default for each."""
    found: dict[str, tuple[str, str]] = {}
    for names, defaults, meaning in LEADING.findall(text):
        keys = re.findall(r"`([^`]+)`", names)
        each = defaults.split(", ")
        each = each if len(each) == len(keys) else [defaults] * len(keys)
        for key, default in zip(keys, each, strict=True):
            assert key not in found, f"{key} stands there twice"
            found[key] = default, meaning
    return found


def says_default(info: FieldInfo, written: str) -> bool:
    """Whether what the table has as a default is the field's."""
    default = info.default
    if info.is_required():
        return written == "-"
    if default is None or default in ((), {}) or isinstance(default, BaseModel):
        return written not in {"-", ""}
    if isinstance(default, StrEnum | str):
        return written == f"`{default}`"
    if isinstance(default, Figure):
        return written == f"{default.value:g} {default.unit}"
    if is_duration(info):
        return parse_quantity(written, Dimension.TIME) == default
    return written == f"{default:,g}" if isinstance(default, float) else written == f"{default:,}"


def is_duration(info: FieldInfo) -> bool:
    """Whether a field holds a time, in ps."""
    return all(any(part is held for held in info.metadata) for part in get_args(Duration)[1:])


def in_flow(info: FieldInfo, name: str) -> str:
    """A key as examples have it: ``begin: 0 s``, where it has a default; else the name alone."""
    default: Any = info.default
    if info.is_required() or default is None:
        return name
    if is_duration(info):
        return f"{name}: {format_quantity(default, Dimension.TIME) if default else '0 s'}"
    return f"{name}: {list(default) if isinstance(default, tuple) else default}"
