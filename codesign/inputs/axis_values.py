"""The values of an axis as a command line gives them: lists and ranges, in the values of YAML."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from codesign.errors import InputError, show
from codesign.inputs.files import parse_value
from codesign.inputs.ranges import MAX_VALUES, NUMBER, By, Range, too_many

_MAX_TEXT = 20_000
_RANGE = re.compile(
    rf" *({NUMBER}[^.:*]*?) *\.\. *({NUMBER}[^:*]*?) *(?:([:*])(.*)| in +([^ ]+)( +log)? *)?", re.S
)
_SIGNS: dict[str, By] = {":": "step", "*": "factor"}
_OPENING, _CLOSING = "[{", "]}"
_FORMS = (
    "write FIRST..LAST, FIRST..LAST:STEP, FIRST..LAST*FACTOR or FIRST..LAST in COUNT, as in 1..8,"
    " 10MHz..100MHz:10MHz, 1..1024*2 or '10MHz..1GHz in 12 log'"
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
            fault = too_many()
            raise InputError(fault.what, place, fault.hint)
    return values


_WHEN = re.compile(r" when +(?=[A-Za-z_][A-Za-z0-9_.-]*=)")
_AND = re.compile(r" and +(?=[A-Za-z_][A-Za-z0-9_.-]*=)")


def axis_form(text: str, place: str) -> dict[str, Any]:
    """An axis with its values, as a file has it: with what it depends on, where that follows behind ``when``.

    >>> axis_form("4,6 when workload.variant=base and relax.block=[8,12]", "")
    {'values': [4, 6], 'when': {'workload.variant': ['base'], 'relax.block': [[8, 12]]}}

    Raises:
        InputError: see ``axis_values``.
    """
    values, *conditions = _WHEN.split(text, maxsplit=1)
    form: dict[str, Any] = {"values": axis_values(values, place)}
    for condition in _AND.split(conditions[0]) if conditions else ():
        axis, _, chosen = condition.partition("=")
        form.setdefault("when", {})[axis] = axis_values(chosen, f"{place} when {axis}")
    return form


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
    """The values of a range."""
    first, last, sign, change, count, log = match.groups()
    by: By = _SIGNS[sign] if sign else "" if count is None else "log" if log else "linear"
    written = Range(first, last, by, (change or count or "").strip(), show(text))
    try:
        return written.values(_FORMS)
    except InputError as fault:
        raise InputError(fault.what, place, fault.hint) from None
