"""The values of an axis as a command line gives them: lists and ranges, in the values of YAML."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from codesign.errors import InputError, show
from codesign.inputs.exploration import MAX_VALUES
from codesign.inputs.files import parse_value
from codesign.units import Dimension, format_exact, parse_quantity

_MAX_TEXT = 20_000
_NUMBER = r"[+-]?[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]{1,2})?"
_PLAIN = re.compile(_NUMBER)
_RANGE = re.compile(rf" *({_NUMBER}[^.:*]*?) *\.\. *({_NUMBER}[^:*]*?) *(?:([:*])(.*))?", re.S)
_OPENING, _CLOSING = "[{", "]}"
_FORMS = (
    "write FIRST..LAST, FIRST..LAST:STEP or FIRST..LAST*FACTOR, as in 1..8, 10MHz..100MHz:10MHz or 1..1024*2"
)


def axis_values(text: str, place: str) -> list[Any]:
    """The values of a list such as ``a,b,c``, where each entry is a value as in YAML, or a range.

    >>> axis_values("1..4", ""), axis_values("10MHz..30MHz:10MHz", ""), axis_values("1..16*4,[24, 44]", "")
    ([1, 2, 3, 4], ['10 MHz', '20 MHz', '30 MHz'], [1, 4, 16, [24, 44]])

    Args:
        text: of the command line.
        place: what stands before a fault.

    Raises:
        InputError: an entry that is no value, or a range that is none or has too many values.
    """
    if len(text) > _MAX_TEXT:
        raise InputError(f"a list of {len(text):,} characters is too long", place, f"at most {_MAX_TEXT:,}")
    values: list[Any] = []
    for entry in _entries(text, place):
        match = _RANGE.fullmatch(entry)
        values += [parse_value(entry, place)] if match is None else _range(entry, match, place)
        if len(values) > MAX_VALUES:
            raise _too_many(place)
    return values


def _entries(text: str, place: str) -> Iterator[str]:
    """The entries of a list, parted at the commas that stand outside of brackets, braces and quotes."""
    begin, open_brackets, quote = 0, 0, ""
    for position, mark in enumerate(text):
        if quote:
            quote = "" if mark == quote else quote
        elif mark in "\"'":
            quote = mark
        elif mark in _OPENING:
            open_brackets += 1
        elif mark in _CLOSING:
            open_brackets -= 1
        elif mark == "," and open_brackets <= 0:
            yield _entry(text[begin:position], place)
            begin = position + 1
    yield _entry(text[begin:], place)


def _entry(text: str, place: str) -> str:
    if not text.strip():
        raise InputError("a value is missing", place, "write AXIS=FIRST,SECOND, or '' for an empty text")
    return text.strip()


def _range(text: str, match: re.Match[str], place: str) -> list[Any]:
    """The values of a range, exactly: whole numbers, decimal numbers, or quantities with their unit."""
    first, last, kind, by = match.groups()
    dimension = _dimension(first)
    try:
        begin, end = (_exact(each, dimension) for each in (first, last))
        change = Fraction(1) if by is None else _exact(by.strip(), None if kind == "*" else dimension)
    except InputError as fault:
        raise InputError(f"{show(text)} is no range: {fault.what}", place, fault.hint or _FORMS) from None
    if kind is None and not (dimension is None and begin.denominator == end.denominator == 1):
        raise InputError(f"{show(text)} has no step", place, f"write {first}..{last}:STEP")
    if begin > end:
        raise InputError(f"{show(text)} has no value: the first is above the last", place, _FORMS)
    if (kind == "*" and (change <= 1 or begin <= 0)) or change <= 0:
        what = "a factor is above 1, of values above 0" if kind == "*" else "a step is above 0"
        raise InputError(f"{show(text)} does not end: {what}", place, _FORMS)
    if kind != "*" and (end - begin) / change >= MAX_VALUES:
        raise _too_many(place)
    values: list[Any] = []
    whole = not any("." in each for each in (first, last, by or ""))
    while begin <= end:
        if len(values) == MAX_VALUES:
            raise _too_many(place)
        values.append(_written(begin, dimension, whole, place))
        begin = begin * change if kind == "*" else begin + change
    return values


def _dimension(text: str) -> Dimension | None:
    """The dimension of a quantity; None of a plain number.

    A text of no dimension is one of time, so that its fault says how a quantity is written.
    """
    if _PLAIN.fullmatch(text):
        return None
    for dimension in Dimension:
        with contextlib.suppress(InputError):
            parse_quantity(text, dimension)
            return dimension
    return Dimension.TIME


def _exact(text: str, dimension: Dimension | None) -> Fraction:
    """The number of a text.

    Raises:
        InputError: it is none of this dimension.
    """
    if dimension is not None:
        return Fraction(parse_quantity(text, dimension))
    if not _PLAIN.fullmatch(text):
        raise InputError(f"{show(text)} is not a number", hint=_FORMS)
    return Fraction(text)


def _written(value: Fraction, dimension: Dimension | None, whole: bool, place: str) -> Any:
    """A value of a range as a file would have it."""
    if dimension is None:
        return int(value) if value.denominator == 1 and whole else float(value)
    try:
        return format_exact(value, dimension)
    except InputError as fault:
        raise InputError(fault.what, place, "choose a step or factor with few decimals") from None


def _too_many(place: str) -> InputError:
    return InputError("too many values", place, f"at most {MAX_VALUES:,}")
