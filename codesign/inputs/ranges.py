"""Ranges of numbers and quantities, exact in decimals: steps, factors, and counts on a linear or logarithmic scale.

The command line writes ``10MHz..100MHz:10MHz``, a file ``{from: 10 MHz, to: 100 MHz, step: 10 MHz}``. Both are read
here.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from typing import Any, Literal

from codesign.errors import InputError, WrittenFloat, choose_hint, clip, show
from codesign.units import SCALES, Dimension, format_exact, parse_quantity

MAX_VALUES = 1000

NUMBER = r"[+-]?[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]{1,2})?"
_PLAIN = re.compile(NUMBER)
_QUANTITY = re.compile(rf"{NUMBER} *(.*)", re.S)

By = Literal["", "step", "factor", "linear", "log"]
"""How a range goes on: by 1, by a step, by a factor, or to a count of values on a linear or logarithmic scale."""

DIGITS = 6
"""Significant digits of the values between the ends of a range of a count."""

MAX_TEXT = 100
_TOO_LARGE = 10**MAX_TEXT
_NINES = "9" * (MAX_TEXT + 1)

KEYS = ("from", "to", "step", "factor", "count", "scale")
_FORMS = (
    "write {from: 10 MHz, to: 100 MHz, step: 10 MHz}, or factor: 2, or count: 12 with scale: linear or log"
)


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

    def _check(
        self, begin: Fraction, end: Fraction, change: Fraction, dimension: Dimension | None, forms: str
    ) -> None:
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
        raise InputError(
            f"unknown key {clip(str(strange))!r}", hint=choose_hint(clip(str(strange), 60), KEYS)
        )
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
    """What is wrong with more values than an axis may have. ``count``: how many they are; 0: not known."""
    number = f"{count:,} values" if 0 < count < 10**15 else "too many values"
    what = f"{text} has {number}" if text else "too many values"
    return InputError(what, hint=f"at most {MAX_VALUES:,}")
