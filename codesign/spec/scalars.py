"""What a plain (unquoted) YAML scalar means: the YAML 1.2 core schema without its traps."""

from __future__ import annotations

import math
import re
from typing import Self

MAX_NUMBER = 40
"""Characters of a number: enough for any exact quantity, too few to choke on."""

Scalar = str | int | float | bool | None


class WrittenFloat(float):
    """A number that keeps its ``text``, so that ``1e6`` is not told to have been 1000000.0."""

    text: str

    def __new__(cls, value: float, text: str = "") -> Self:
        """The number ``value``, written as ``text``."""
        made = super().__new__(cls, value)
        made.text = text
        return made


_INTEGER = re.compile(r"[-+]?(?:0|[1-9][0-9]*)")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|(?:0|[1-9][0-9]*)(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_LEADING_ZERO = re.compile(r"[-+]?0[0-9]+(?:\.[0-9]*)?(?:[eE][-+]?[0-9]+)?")
_OTHER_BASE = re.compile(r"[-+]?0(?:x[0-9a-fA-F]+|o[0-7]+|b[01]+)")
_NON_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_CONSTANTS: dict[str, bool | None] = {
    "": None,
    "~": None,
    "null": None,
    "Null": None,
    "NULL": None,
    "true": True,
    "false": False,
}


def refusal(text: str) -> tuple[str, str] | None:
    """What is wrong with a plain scalar, and the remedy; None where nothing is.

    >>> refusal("010")
    ('010 has a leading zero', "write 10, or '010' if text is meant")
    """
    shown = clip(text, MAX_NUMBER)
    if _LEADING_ZERO.fullmatch(text):
        plain = re.sub(r"^([-+]?)0+(?=[0-9])", r"\1", shown)
        return f"{shown} has a leading zero", f"write {plain}, or '{shown}' if text is meant"
    if _OTHER_BASE.fullmatch(text):
        return f"{shown} is not a decimal number", "write it in decimal, or quote it as text"
    if _NON_FINITE.fullmatch(text):
        return f"{shown} is not a finite number", "write a finite number"
    if _is_number(text) and (len(text) > MAX_NUMBER or math.isinf(float(text))):
        return f"{shown} is too long or too large for a number", "write a smaller one, or quote it as text"
    return None


def resolve(text: str) -> Scalar:
    """The value of a plain scalar that has no refusal: text, int, float, bool or None.

    >>> [resolve(text) for text in ("on", "12:30:00", "1e6", "true", "True", "-3", "~")]
    ['on', '12:30:00', 1000000.0, True, 'True', -3, None]
    """
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    if not _is_number(text):
        return text
    return int(text) if _INTEGER.fullmatch(text) else WrittenFloat(float(text), text)


def _is_number(text: str) -> bool:
    return _FLOAT.fullmatch(text) is not None


def clip(text: str, most: int = 80) -> str:
    """Text cut to what fits on a line."""
    return text if len(text) <= most else f"{text[:most]}..."


def show(value: object) -> str:
    """A value of a tree as the user wrote it, as far as that can be told, cut to what fits on a line.

    >>> [show(resolve(text)) for text in ("1e6", "7", "true", "seven", "")]
    ['1e6', '7', 'true', "'seven'", 'an empty value']
    """
    if value is None:
        return "an empty value"
    if isinstance(value, WrittenFloat):
        return value.text
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return "a list"
    return clip(repr(value), 60)
