"""What synthesis counts of the RTL of this package, line by line of the demand, for any size and family.

The count of a line is a sum of terms of the parameters of its top module. Coefficients are fitted to rows of
``planners/harmonic/measured/resources.json`` and held against others: ``HELD_OUT``, ``ALONE_HELD_OUT``. A line of
a circuit with digits of several bits is fitted to the rows of all digits; one of a bit-serial circuit to its own alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache

from codesign.figures import Status
from codesign.planners.demand import Line
from codesign.planners.harmonic.styles.geometry import (
    border_rams,
    cluster_count,
    digits,
    field_plane,
    field_rams_a_memory,
    tree_widths,
)
from codesign.planners.measured import Fit, ResourceRow, family_of, fit_rows, resource_rows

Variables = Mapping[str, int]
Terms = Callable[[Variables], Sequence[float]]

HELD_OUT = {(12, 24), (10, 14), (18, 24)}
"""Blocks that no line of the array with its control is fitted to."""
ALONE_HELD_OUT = {(24, 36), (20, 50), (50, 80)}
"""Maps that no line of the decision module by itself is fitted to."""

DIGITS = 1, 2, 4, 8
"""The bits of a digit."""

SIMILAR = "xc4v"
DIGITS_SIMILAR = ALONE_SIMILAR = "ecp5"
"""The families that stand for one without rows: LUT of four inputs with a carry chain."""
EVENT_BITS = 25
"""Of an event but those of the read-out, which has a bit for each column."""


def held_out(variables: Variables) -> bool:
    """Whether the array of these parameters is held out of the fit."""
    return (variables["ROWS"], variables["COLUMNS"]) in HELD_OUT


def alone_held_out(variables: Variables) -> bool:
    """Whether the decision module of these parameters is held out of the fit."""
    return (variables["ROWS"], variables["COLUMNS"]) in ALONE_HELD_OUT


def _nodes(v: Variables) -> int:
    return v["ROWS"] * v["COLUMNS"]


def _clusters(v: Variables) -> int:
    return cluster_count(v["ROWS"], v["COLUMNS"])


def _border_rams(v: Variables) -> int:
    return border_rams(v["ROWS"], v["COLUMNS"], v["DOWN"], v["ACROSS"])


def _border_nodes(v: Variables) -> int:
    return 2 * (v["COLUMNS"] * (v["DOWN"] > 1) + v["ROWS"] * (v["ACROSS"] > 1))


def _addresses(v: Variables) -> int:
    """Addresses: that of the visited block, and those of the blocks around it."""
    return 1 + 2 * (v["DOWN"] > 1) + 2 * (v["ACROSS"] > 1)


def _digit_bits(v: Variables) -> int:
    return v.get("DIGIT_BITS", 1)


def _each(v: Variables, *terms: float) -> tuple[float, ...]:
    """The terms, with coefficients of their own for each number of bits of a digit."""
    digit_bits = _digit_bits(v)
    return tuple(term * (digit_bits == bits) for bits in DIGITS for term in terms)


def _address_bits(v: Variables) -> int:
    words = digits(v["LAST_PRECISION"], _digit_bits(v)) + 1
    return (v["DOWN"] * v["ACROSS"] * words - 1).bit_length()


def _block_bits(v: Variables) -> int:
    return (v["DOWN"] * v["ACROSS"] - 1).bit_length()


def _row_lines(v: Variables) -> int:
    return v["COLUMNS"] + 2 * (v["ACROSS"] > 1)


def _column_lines(v: Variables) -> int:
    return v["DECISION"] * (v["ROWS"] + 2 * (v["DOWN"] > 1))


def _sides(v: Variables) -> int:
    return v["ROWS"] + v["COLUMNS"]


def _selecting(v: Variables) -> int:
    """LUT of the lines that carry a row and a column out: each an OR over the nodes that are selected."""
    lines = _row_lines(v) * _luts(2 * v["ROWS"]) + _column_lines(v) * _luts(2 * v["COLUMNS"])
    return _digit_bits(v) * lines


def _luts(bits: int) -> int:
    """LUT of four inputs that make one signal of ``bits``: each makes one of four."""
    return -(-(bits - 1) // 3)


def _side_bits(v: Variables) -> int:
    return (v["ROWS"] - 1).bit_length() + (v["COLUMNS"] - 1).bit_length()


def _read_out(v: Variables) -> int:
    """Bits of an event that only the read-out has."""
    return max(0, min(_digit_bits(v) * v["COLUMNS"], 64) - EVENT_BITS)


def _field_bits(v: Variables) -> tuple[int, int, int]:
    """Bits of an address of the field, of one in a plane, and of the number of a plane."""
    plane, last = field_plane(v["ROWS"], v["COLUMNS"]), v["LAST_PRECISION"]
    return (plane * (last + 1) - 1).bit_length(), (plane - 1).bit_length(), (last + 1).bit_length()


def _more_rams(v: Variables) -> int:
    """Block RAMs of a memory of the field, besides its first: a multiplexer chooses among them."""
    return field_rams_a_memory(v["ROWS"], v["COLUMNS"], v["LAST_PRECISION"], ((1 << 14, 1),)) - 1


ARRAY: Mapping[str, tuple[Terms, Terms]] = {
    "nodes": (
        lambda v: _each(v, _nodes(v), _nodes(v) * v["PIPELINE"]),
        lambda v: _each(v, _nodes(v), _nodes(v) * v["PIPELINE"]),
    ),
    "clusters": (
        lambda v: (
            _clusters(v),
            _clusters(v) * v["PIPELINE"],
            (_digit_bits(v) - 1) * (_nodes(v) + _clusters(v)),
        ),
        lambda v: _each(v, _clusters(v), _clusters(v) * v["PIPELINE"]),
    ),
    "array control": (
        lambda v: (_selecting(v), _clusters(v) * v["PIPELINE"]),
        lambda v: (_digit_bits(v) * (_row_lines(v) + _column_lines(v)), _clusters(v) * v["PIPELINE"]),
    ),
    "OR trees": (
        lambda v: (
            2 * _luts(18 * _clusters(v)) * (1 - v["PIPELINE"]),
            1 - v["PIPELINE"],
            2 * _luts(_clusters(v)) * v["PIPELINE"],
        ),
        lambda v: (2 * sum(tree_widths(v["ROWS"], v["COLUMNS"], v["PIPELINE"])) + 2 * v["PIPELINE"],),
    ),
    "borders": (
        lambda v: _each(v, _border_rams(v), _border_nodes(v)),
        lambda v: (_digit_bits(v) * _border_nodes(v) * v["PIPELINE"],),
    ),
    "border addresses": (
        lambda v: (_addresses(v) * _address_bits(v), _addresses(v), _addresses(v) * (_digit_bits(v) > 1)),
        lambda v: (_addresses(v) * _address_bits(v),),
    ),
    "control": (
        lambda v: (
            1,
            min(_digit_bits(v) * v["COLUMNS"], 64),
            v["DECISION"] * _sides(v),
            v["DECISION"] * _sides(v) * (_digit_bits(v) - 1),
            _address_bits(v),
            _clusters(v) + _border_rams(v),
            v["STAGES"],
            _digit_bits(v) > 1,
        ),
        lambda v: (
            1,
            _sides(v) + _clusters(v) + _border_rams(v),
            _side_bits(v),
            v["LAST_PRECISION"].bit_length(),
            _block_bits(v),
            _address_bits(v) * v["PIPELINE"],
            _read_out(v),
            v["DECISION"] * v["PIPELINE"] * _digit_bits(v),
            _digit_bits(v) - 1,
        ),
    ),
    "decision": (lambda v: _each(v, v["DECISION"]), lambda v: _each(v, v["DECISION"])),
}
"""Terms of the LUT and of the flip-flops of each line of the array with its control."""

ALONE: Mapping[str, tuple[Terms, Terms]] = {
    "decision": (
        lambda v: (1, _field_bits(v)[0], _field_bits(v)[1], _more_rams(v)),
        lambda v: (1, *_field_bits(v), _more_rams(v)),
    )
}
"""Those of the decision module by itself."""


def _rows(task: str, of_digits: bool) -> list[ResourceRow]:
    """The rows of bit-serial circuits of a task; those with digits of several bits too, where the line is of digits."""
    rows = resource_rows("harmonic", "bit_serial", task)
    return [row for row in rows if of_digits or _digit_bits(row.variables) == 1]


@cache
def family_for(part_family: str, task: str = "", of_digits: bool = False) -> tuple[str, bool]:
    """The family of rows for a family of parts, and whether it is its own: with rows of each digit held out."""
    family, own = family_of(part_family)
    held = alone_held_out if task else held_out
    rows = [row for row in _rows(task, of_digits) if held(row.variables)]
    measured: dict[str, set[int]] = {}
    for row in rows:
        measured.setdefault(row.family, set()).add(_digit_bits(row.variables))
    needed = set(DIGITS) if of_digits else {1}
    if needed <= measured.get(family, set()):
        return family, own
    return ALONE_SIMILAR if task else DIGITS_SIMILAR if of_digits else SIMILAR, False


@cache
def fit_of(family: str, piece: str, resource: str, task: str = "", of_digits: bool = False) -> Fit:
    """The line of a piece and a resource, in a family of rows."""
    terms = (ALONE if task else ARRAY)[piece][resource == "flip_flops"]
    rows = _rows(task, of_digits)
    return fit_rows(rows, family, piece, resource, terms, alone_held_out if task else held_out)


def counted(piece: str, variables: Variables, part_family: str, task: str = "") -> tuple[Line, Line]:
    """LUT and flip-flops of a piece."""
    of_digits = _digit_bits(variables) > 1
    luts, flip_flops = (
        _line(piece, each, variables, part_family, task, of_digits) for each in ("lut4", "flip_flops")
    )
    return luts, flip_flops


def _line(
    piece: str, resource: str, variables: Variables, part_family: str, task: str, of_digits: bool
) -> Line:
    """The count of a piece in a family of parts, rounded and never negative."""
    family, own = family_for(part_family, task, of_digits)
    law = fit_of(family, piece, resource, task, of_digits)
    terms = (ALONE if task else ARRAY)[piece][resource == "flip_flops"](variables)
    count = max(0, round(law.value(terms)))
    source = (
        f"synthesis of the RTL of this package for {family}; on sizes held out {law.mean:.1%} off in the mean"
    )
    return Line.item(
        piece, resource, count, Status.CALIBRATED if own else Status.ASSUMED, source, law.ends(count, own)
    )
