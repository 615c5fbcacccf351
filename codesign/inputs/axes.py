"""The axes of a space: values or ranges, for which values of other axes an axis exists, and how all of this is written.

A file writes lists, ranges, and axes that exist for some points only::

    relax.iterations: [1, 2, 4]
    fabric.clock: {from: 50 MHz, to: 200 MHz, step: 10 MHz}
    relax.lanes: {values: [1, 2], when: {relax.style: systolic}}
    relax.depth: {from: 1, to: 64, factor: 2, when: {workload.variant: [base, deep]}}

The command line writes ``10MHz..100MHz:10MHz``. Ranges are exact in decimals: steps, factors, and counts on a linear
or logarithmic scale. Every other module reads lists under ``explore.axes``, and what axes depend on under
``explore.when``. A document is brought into that form once, when it is read. Faults stay at the places of the file.

Where an axis exists for some values of other axes only, a part of the space is where the same axes exist.
"""

from __future__ import annotations

import contextlib
import json
import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from typing import Any, Literal

from more_itertools import map_reduce

from codesign.ground.errors import Fault, InputError, WrittenFloat, choose_hint, clip, show
from codesign.ground.models import RefusalError
from codesign.ground.units import SCALES, Dimension, format_exact, parse_quantity
from codesign.inputs.document import REMOVED, Document, KeyPath, Origin, put
from codesign.inputs.files import parse_value

MAX_VALUES = 1000

NUMBER = r"[+-]?[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]{1,2})?"
_PLAIN = re.compile(NUMBER)
_QUANTITY = re.compile(rf"{NUMBER} *(.*)", re.S)

By = Literal["", "step", "factor", "linear", "log"]
"""The step of a range: 1, a step, a factor, or a count of values on a linear or logarithmic scale."""

DIGITS = 6
"""Significant digits of the values between the ends of a range of a count."""

MAX_TEXT = 100
_TOO_LARGE = 10**MAX_TEXT
_NINES = "9" * (MAX_TEXT + 1)

KEYS = ("from", "to", "step", "factor", "count", "scale")
_FORMS = "write {from: 10 MHz, to: 100 MHz, step: 10 MHz}, or factor: 2, or count: 12 with scale: linear or log"


@dataclass(frozen=True)
class Range:
    """A range as it is written: its ends, how it goes on, and by how much. ``text``: what faults call it."""

    first: str
    last: str
    by: By
    change: str
    text: str

    def values(self, forms: str) -> list[Any]:
        """The values as a file would list them: whole numbers, decimal numbers, or quantities with a unit.

        Raises:
            InputError: it is no range, does not end, or has too many values. ``forms``: how ranges are written.
        """
        dimension = _dimension(self.first)
        try:
            begin, end = (_exact(each, dimension, forms) for each in (self.first, self.last))
            change = self._change(dimension, forms)
        except InputError as fault:
            raise InputError(f"{self.text} is no range: {fault.what}", hint=fault.hint or forms) from None
        self._check(begin, end, change, dimension, forms)
        if self.by in ("linear", "log"):
            return self._spread(begin, end, int(change), dimension)
        whole = not any("." in each for each in (self.first, self.last, self.change))
        values: list[Any] = []
        while begin <= end:
            if len(values) == MAX_VALUES:
                raise too_many(self.text)
            values.append(_written(begin, dimension, whole))
            begin = begin * change if self.by == "factor" else begin + change
        return values

    def _change(self, dimension: Dimension | None, forms: str) -> Fraction:
        if not self.by:
            return Fraction(1)
        if self.by in ("linear", "log") and not self.change.isdecimal():
            raise InputError(f"{show(self.change)} is no number of values", hint=forms)
        return _exact(self.change, dimension if self.by == "step" else None, forms)

    def _check(self, begin: Fraction, end: Fraction, change: Fraction, dimension: Dimension | None, forms: str) -> None:
        if not self.by and not (dimension is None and begin.denominator == end.denominator == 1):
            hint = f"write {self.first}..{self.last}:STEP" if ".." in forms else forms
            raise InputError(f"{self.text} has no step", hint=hint)
        if begin > end:
            raise InputError(f"{self.text} has no value: the first is above the last", hint=forms)
        if self.by in ("linear", "log"):
            if not (change >= 2 and begin < end) or (self.by == "log" and begin <= 0):
                what = "two different ends above 0" if self.by == "log" else "two different ends"
                raise InputError(f"{self.text} is no range: a count of at least 2 needs {what}", hint=forms)
            if change > MAX_VALUES:
                raise too_many(self.text, int(change))
            return
        if (self.by == "factor" and (change <= 1 or begin <= 0)) or change <= 0:
            what = "a factor is above 1, of values above 0" if self.by == "factor" else "a step is above 0"
            raise InputError(f"{self.text} does not end: {what}", hint=forms)
        if self.by != "factor" and (end - begin) / change >= MAX_VALUES:
            raise too_many(self.text, int((end - begin) / change) + 1)

    def _spread(self, begin: Fraction, end: Fraction, count: int, dimension: Dimension | None) -> list[Any]:
        """``count`` values from end to end, rounded between them; those that are rounded to the same stand once."""
        whole = dimension is None and begin.denominator == end.denominator == 1 and "." not in self.first
        unit, grain = Fraction(1), Fraction(1) if whole else None
        if dimension is not None:
            scale = SCALES[dimension]
            match = _QUANTITY.fullmatch(self.first)
            unit = scale.units.get(match[1] if match else "", Fraction(1))
            grain = Fraction(1) if scale.whole else None
        inner = []
        for number in range(1, count - 1):
            value = _between(begin, end, Fraction(number, count - 1), log=self.by == "log")
            value = _rounded(value / unit) * unit
            inner.append(value if grain is None else Fraction(round(value)))
        values = dict.fromkeys([begin, *(value for value in inner if begin < value < end), end])
        return [_written(value, dimension, whole) for value in values]


def _between(begin: Fraction, end: Fraction, share: Fraction, *, log: bool) -> Fraction:
    """The value at a share of the way. On a logarithmic scale, to 40 digits, the same on every machine."""
    if not log:
        return begin + (end - begin) * share
    with localcontext(Context(prec=40)):
        way = _decimal(end / begin).ln() * _decimal(share)
        return Fraction((_decimal(begin).ln() + way).exp())


def _decimal(value: Fraction) -> Decimal:
    return Decimal(value.numerator) / Decimal(value.denominator)


def _rounded(value: Fraction) -> Fraction:
    with localcontext(Context(prec=DIGITS)):
        return Fraction(_decimal(value))


def range_of(raw: Mapping[str, Any]) -> Range:
    """The range of a mapping in a file.

    Raises:
        InputError: it is none.
    """
    strange = next((key for key in raw if key not in KEYS), None)
    if strange is not None:
        raise InputError(f"unknown key {clip(str(strange))!r}", hint=choose_hint(clip(str(strange), 60), KEYS))
    missing = next((key for key in ("from", "to") if key not in raw), None)
    changes: list[By] = [key for key in ("step", "factor", "count") if key in raw]  # type: ignore[misc]
    if missing or len(changes) > 1:
        what = f"{missing} is missing" if missing else f"{' and '.join(changes)} together"
        raise InputError(what, hint=_FORMS)
    scale = raw.get("scale", "linear")
    if scale not in ("linear", "log") or ("scale" in raw and changes != ["count"]):
        what = "scale without count" if scale in ("linear", "log") else f"there is no scale {show(scale)}"
        raise InputError(what, hint=_FORMS)
    first, last = _number_text(raw["from"]), _number_text(raw["to"])
    by: By = "" if not changes else scale if "count" in raw else changes[0]
    change = _number_text(raw[changes[0]]) if changes else ""
    return Range(first, last, by, change, f"from {clip(first, 40)} to {clip(last, 40)}")


def range_values(raw: Mapping[str, Any]) -> list[Any]:
    """The values of a range as a mapping in a file.

    >>> range_values({"from": "10 MHz", "to": "1 GHz", "count": 3, "scale": "log"}), range_values({"from": 1, "to": 3})
    (['10 MHz', '100 MHz', '1 GHz'], [1, 2, 3])

    Raises:
        InputError: it is no range, does not end, or has too many values.
    """
    return range_of(raw).values(_FORMS)


def _number_text(value: Any) -> str:
    if isinstance(value, WrittenFloat) and value.text:
        text = value.text.replace("_", "")
    elif isinstance(value, int) and not isinstance(value, bool):
        text = str(value) if abs(value) < _TOO_LARGE else _NINES
    elif isinstance(value, str | float):
        text = str(value).strip(" ")
    else:
        raise InputError(f"{show(value)} is no number and no quantity", hint=_FORMS)
    if len(text) > MAX_TEXT:
        raise InputError(f"{clip(text, 20)} is too long", hint=f"at most {MAX_TEXT} characters")
    return text


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
    # The number may be at fault, such as a frequency of 0.
    match = _QUANTITY.fullmatch(text)
    units = (each for each in Dimension if match and match[1] in SCALES[each].units)
    return next(units, Dimension.TIME)


def _exact(text: str, dimension: Dimension | None, forms: str) -> Fraction:
    """The number of a text.

    Raises:
        InputError: it is none of this dimension.
    """
    if dimension is not None:
        return Fraction(parse_quantity(text, dimension))
    if not _PLAIN.fullmatch(text):
        raise InputError(f"{show(text)} is not a number", hint=forms)
    return Fraction(text)


def _written(value: Fraction, dimension: Dimension | None, whole: bool) -> Any:
    """A value of a range as a file would have it."""
    if dimension is None:
        return int(value) if value.denominator == 1 and whole else float(value)
    try:
        return format_exact(value, dimension)
    except InputError as fault:
        raise InputError(fault.what, hint="choose a step or factor with few decimals") from None


def too_many(text: str = "", count: int = 0) -> InputError:
    """The error of an axis with more values than it may have. ``count``: the number of values; 0: not known."""
    number = f"{count:,} values" if 0 < count < 10**15 else "too many values"
    what = f"{text} has {number}" if text else "too many values"
    return InputError(what, hint=f"at most {MAX_VALUES:,}")


MAX_PARTS = 1000

Values = Mapping[str, Sequence[Any]]
"""The values of each axis, in order."""

When = Mapping[str, Mapping[str, Sequence[Any]]]
"""Axis → other axis → the values of the other for which the axis exists. An axis that is not named always exists."""


@dataclass(frozen=True)
class Part:
    """Points with the same axes: every combination of these values, the last axis moving fastest.

    - ``begin``: the place of the first point in the enumeration. ``size``: how many points there are.
    - ``axes``: the numbers of the values, of each axis that exists.
    """

    begin: int
    axes: Mapping[str, tuple[int, ...]]

    @property
    def size(self) -> int:
        """The number of points."""
        return math.prod(map(len, self.axes.values()))


def parts_of(axes: Values, when: When) -> tuple[Part, ...]:
    """The parts, which together hold each point once.

    Args:
        axes: every axis behind those that its existence depends on (``ordered``).
        when: see ``When``; sound (``refusals``).

    Raises:
        RefusalError: there are more than ``MAX_PARTS``.
    """
    allowed = {
        axis: {other: _numbers(axes[other], values) for other, values in conditions.items()}
        for axis, conditions in when.items()
    }
    classes = {axis: _classes(len(values), axis, allowed) for axis, values in axes.items()}
    parts: list[Part] = []
    begin = 0
    for numbers in _combined(classes, allowed, list(axes), {}):
        parts.append(Part(begin, numbers))
        begin += parts[-1].size
        if len(parts) > MAX_PARTS:
            what = f"more than {MAX_PARTS:,} combinations of conditions on axes"
            raise RefusalError(what, "let fewer axes depend on each other")
    return tuple(parts)


_Allowed = Mapping[str, Mapping[str, Collection[int]]]
"""Like ``When``, with the numbers of the values."""


def _combined(
    classes: Mapping[str, list[tuple[int, ...]]],
    allowed: _Allowed,
    names: list[str],
    chosen: dict[str, tuple[int, ...]],
) -> Iterator[dict[str, tuple[int, ...]]]:
    """The numbers of the values in each part, the first axis moving slowest."""
    if not names:
        yield dict(chosen)
        return
    axis, *rest = names
    conditions = allowed.get(axis, {})
    # All values of a class are alike to every condition.
    if not all(other in chosen and chosen[other][0] in numbers for other, numbers in conditions.items()):
        yield from _combined(classes, allowed, rest, chosen)
        return
    for numbers in classes[axis]:
        yield from _combined(classes, allowed, rest, {**chosen, axis: numbers})


def _classes(count: int, axis: str, allowed: _Allowed) -> list[tuple[int, ...]]:
    """The numbers of the values of an axis, parted by the axes that exist for them."""
    of_axis = [conditions[axis] for conditions in allowed.values() if axis in conditions]
    classes = map_reduce(range(count), lambda number: tuple(number in numbers for numbers in of_axis), None, tuple)
    return list(classes.values())


def _numbers(values: Sequence[Any], chosen: Sequence[Any]) -> set[int]:
    texts = set(map(value_text, chosen))
    return {number for number, value in enumerate(values) if value_text(value) in texts}


def value_text(value: Any) -> str:
    """The text by which values of an axis are compared."""
    return json.dumps(value, sort_keys=True)


def ordered(axes: Collection[str], when: Mapping[str, Collection[str]]) -> list[str]:
    """The axes in their order, but each behind those that its existence depends on; of a circle, as they are."""
    order: list[str] = []
    waiting = list(axes)
    while waiting:
        free = [axis for axis in waiting if not set(when.get(axis, ())) & set(waiting)]
        order.append(free[0] if free else waiting[0])
        waiting.remove(order[-1])
    return order


def listed(raw: Any, values: Sequence[Any]) -> tuple[Any, ...]:
    """The values that one value, or a list of values, of an axis names: ``base`` or ``[base, on-host]``."""
    one = value_text(raw) in set(map(value_text, values))
    return tuple(raw) if isinstance(raw, list | tuple) and not one else (raw,)


def refusals(axes: Values, when: When) -> list[tuple[str, RefusalError]]:
    """The faults in the conditions that axes depend on, each with its axis."""
    wrong = []
    for axis, conditions in when.items():
        if axis not in axes:
            what = f"when {clip(axis)}: there is no such axis among the decisions"
            wrong.append((axis, RefusalError(what, choose_hint(clip(axis, 60), axes))))
        for other, values in conditions.items():
            refusal = _refusal(axis, other, values, axes)
            if refusal is not None:
                wrong.append((axis, refusal))
    if wrong:
        return wrong
    for axis in in_circle(axes, when):
        what = f"{axis} depends on an axis that depends on it"
        return [(axis, RefusalError(what, "leave one of the conditions out", ("when",)))]
    parts = parts_of({axis: axes[axis] for axis in ordered(axes, when)}, when)
    nowhere = [axis for axis in when if not any(axis in part.axes for part in parts)]
    return [(axis, _never(axis)) for axis in nowhere]


def _refusal(axis: str, other: str, values: Sequence[Any], axes: Values) -> RefusalError | None:
    at = ("when", other)
    if other == axis:
        return RefusalError("an axis does not depend on itself", "name another axis", at)
    if other not in axes:
        hint = choose_hint(clip(other, 60), [name for name in axes if name != axis])
        return RefusalError("there is no such axis among the decisions", hint, at)
    known = set(map(value_text, axes[other]))
    strange = [value for value in values if value_text(value) not in known]
    if values and not strange:
        return None
    what = f"{show(strange[0])} is no value of axis {other}" if values else "names no value"
    word = clip(str(strange[0]), 60) if strange else ""
    return RefusalError(what, choose_hint(word, map(str, axes[other])), at)


def in_circle(axes: Collection[str], when: Mapping[str, Collection[str]]) -> list[str]:
    """The first axis that depends on itself by others; none where no axis does."""
    order = ordered(axes, when)
    place = {axis: number for number, axis in enumerate(order)}
    return [axis for axis in order if any(place.get(other, -1) >= place[axis] for other in when.get(axis, ()))][:1]


def _never(axis: str) -> RefusalError:
    what = f"no point has axis {axis}: its conditions contradict each other"
    return RefusalError(what, "leave one of them out", ("when",))


def settled(axes: Values, when: When, values: Mapping[str, Any]) -> dict[str, dict[str, Sequence[Any]]]:
    """The conditions left of ``when`` for the axes that may still exist, after some axes were given a value each.

    Axes that cannot exist with these values are not in the answer, nor are those that were given one; all others are,
    though with an empty mapping where nothing is left to depend on.
    """
    left: dict[str, dict[str, Sequence[Any]]] = {}
    for axis in ordered(axes, when):
        if axis in values:
            continue
        conditions = when.get(axis, {})
        kept = {other: chosen for other, chosen in conditions.items() if other not in values}
        met = all(
            value_text(values[other]) in set(map(value_text, chosen))
            for other, chosen in conditions.items()
            if other in values
        )
        if met and all(other in left for other in kept):
            left[axis] = kept
    return left


WHEN = "when"
VALUES = "values"


def with_listed_axes(document: Document) -> Document:
    """The document of a workload with a list in the place of each axis that is written as a mapping."""
    explore = document.tree.get("explore") if isinstance(document.tree, dict) else None
    if not isinstance(explore, dict):
        return document
    edits: dict[KeyPath, Any] = {}
    sources: dict[KeyPath, KeyPath] = {}
    faults: list[Fault] = []
    refused: list[str] = []
    for place, raw in _mappings(explore):
        axis = str(place[-1])
        try:
            edits[place], sources[place] = _values(raw, place)
        except _RefusedError as refusal:
            fault = document.fault(refusal.path, refusal.what, refusal.hint, at_key=refusal.at_key)
            # A value that is none, such as .nan, has its fault already.
            if not any(each.key.startswith(f"{fault.key}.") for each in document.faults):
                faults.append(fault)
            edits[place], sources[place] = REMOVED, place
            refused.append(axis)
            continue
        if WHEN in raw:
            of_axis: KeyPath = ("explore", WHEN, axis)
            edits[of_axis], sources[of_axis] = raw[WHEN], (*place, WHEN)
    # What depends on a refused axis is not at fault.
    for path, when in edits.items():
        if path[1] == WHEN and isinstance(when, dict):
            edits[path] = {other: values for other, values in when.items() if other not in refused}
    if not edits:
        return document
    listed = put(document, edits, lambda path: Origin(sources.get(path, path) if path[1] == WHEN else path, document))
    number = 1 + max(number for number, _ in listed.origins.values())
    values: dict[KeyPath, tuple[int, Origin]] = {
        (*place, index): (number, Origin((*source, index), document))
        for place, source in sources.items()
        if source[-1] == VALUES
        for index in range(len(edits[place]))
    }
    return replace(listed, faults=(*listed.faults, *faults), origins={**listed.origins, **values})


class _RefusedError(Exception):
    """An axis that is written wrongly, and where."""

    def __init__(self, path: KeyPath, what: str, hint: str | None = None, *, at_key: bool = False) -> None:
        super().__init__(what)
        self.path, self.what, self.hint, self.at_key = path, what, hint, at_key


def _mappings(explore: Mapping[str, Any]) -> Iterator[tuple[KeyPath, dict[str, Any]]]:
    """Each axis and condition that is written as a mapping, with its path."""
    for section in ("axes", "conditions"):
        axes = explore.get(section)
        for axis, raw in axes.items() if isinstance(axes, dict) else ():
            if isinstance(raw, dict):
                yield ("explore", section, axis), raw


def _values(raw: Mapping[str, Any], place: KeyPath) -> tuple[list[Any], KeyPath]:
    """The values of an axis, and where they stand.

    Raises:
        _RefusedError: there are none, or it is no range.
    """
    accepted = (VALUES, *KEYS, WHEN)
    for key in raw:
        if key not in accepted:
            raise _RefusedError((*place, key), "unknown key", choose_hint(clip(str(key), 60), accepted), at_key=True)
    if WHEN in raw and place[1] == "conditions":
        what = "a condition is met by every design"
        raise _RefusedError((*place, WHEN), what, "leave when out, or make it a decision", at_key=True)
    if WHEN in raw and not isinstance(raw[WHEN], dict):
        raise _RefusedError((*place, WHEN), "is not a mapping", "write {AXIS: VALUE}, or {AXIS: [VALUE, ...]}")
    if WHEN in raw and not raw[WHEN]:
        raise _RefusedError((*place, WHEN), "names no axis", "write {AXIS: VALUE}, or leave it out")
    of_range = {key: each for key, each in raw.items() if key in KEYS}
    if VALUES in raw and of_range:
        what = f"values and {', '.join(of_range)} together"
        raise _RefusedError(place, what, "keep the list, or the range")
    if VALUES in raw:
        if not isinstance(raw[VALUES], list):
            raise _RefusedError((*place, VALUES), "is not a list", "write the values in brackets: [first, second]")
        return raw[VALUES], (*place, VALUES)
    try:
        return range_values(of_range), place
    except InputError as fault:
        raise _RefusedError(place, fault.what, fault.hint) from None


_MAX_TEXT = 20_000
_RANGE = re.compile(rf" *({NUMBER}[^.:*]*?) *\.\. *({NUMBER}[^:*]*?) *(?:([:*])(.*)| in +([^ ]+)( +log)? *)?", re.S)
_SIGNS: dict[str, By] = {":": "step", "*": "factor"}
_OPENING, _CLOSING = "[{", "]}"
_LINE_FORMS = (
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
    if conditions:
        of_axis = (condition.partition("=") for condition in _AND.split(conditions[0]))
        form["when"] = {axis: axis_values(chosen, f"{place} when {axis}") for axis, _, chosen in of_axis}
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
        return written.values(_LINE_FORMS)
    except InputError as fault:
        raise InputError(fault.what, place, fault.hint) from None
