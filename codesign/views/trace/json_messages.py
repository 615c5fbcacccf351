"""Decode the messages of older traces: JSON, with arrays in base64 and maps as ``foxglove.Grid``.

Decoding trusts no content: sizes are bounded and checked against shapes, and types against the fields.
"""

from __future__ import annotations

import base64
import binascii
import math
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import TraceError
from codesign.ground.records import ArrayOf, Record
from codesign.views.trace.arrays import has_shape
from codesign.views.trace.messages import checked
from codesign.views.trace.schemas import FieldPlan, plan_of
from codesign.views.trace.values import MAX_ELEMENTS, parse_json

_MAX_INTEGER = 2**63 - 1
_PYTHON_TYPES: dict[str, tuple[type, ...]] = {
    "int64": (int,),
    "double": (int, float),
    "string": (str,),
    "bool": (bool,),
    "mapping": (dict,),
}


def decode_json(record_type: type[Record], message: bytes) -> Record:
    """The record of a message.

    Raises:
        TraceError: the message is no ``record_type``.
    """
    data = parse_json(message)
    if not isinstance(data, dict):
        _refuse(record_type, "not a JSON object")
    return checked(record_type(**{plan.name: _field(record_type, plan, data) for plan in plan_of(record_type)}))


def _field(record_type: type[Record], plan: FieldPlan, data: dict[str, Any]) -> Any:
    if plan.name == record_type.ROLE.grid:
        assert plan.array is not None
        if record_type.ROLE.spare_grid and "data" not in data:
            return np.zeros((0, 0), plan.array.dtype)
        return _grid(data, np.dtype(plan.array.dtype))
    if plan.name not in data:
        if plan.optional or plan.has_default:
            return plan.default
        _refuse(record_type, f"{plan.name} is missing")
    value = data[plan.name]
    if plan.array is not None:
        return _array(record_type, plan.name, plan.array, value)
    # bool is a subclass of int in Python, but not a number in JSON.
    if type(value) not in _PYTHON_TYPES[plan.kind] or (type(value) in (int, float) and abs(value) > _MAX_INTEGER):
        _refuse(record_type, f"{plan.name} is no {plan.kind}")
    return float(value) if plan.kind == "double" else value


def _array(record_type: type[Record], name: str, form: ArrayOf, value: Any) -> NDArray[Any]:
    if not isinstance(value, dict) or value.get("dtype") != form.dtype:
        _refuse(record_type, f"{name} is no {form.dtype} array")
    shape = value.get("shape")
    if not isinstance(shape, list) or not all(type(side) is int and side >= 0 for side in shape):
        _refuse(record_type, f"{name} has no shape")
    if not has_shape(form, shape):
        _refuse(record_type, f"{name} has shape {shape[:4]}")
    size, dtype = math.prod(shape), np.dtype(form.dtype)
    if size > MAX_ELEMENTS:
        _refuse(record_type, f"{name} has {size} elements, more than 2^24")
    data = _bytes(value.get("data"))
    if len(data) != size * dtype.itemsize:
        _refuse(record_type, f"{name} has {len(data)} bytes for {size} elements")
    return np.frombuffer(data, dtype.newbyteorder("<")).astype(dtype).reshape(shape)


def _grid(message: dict[str, Any], dtype: np.dtype[Any]) -> NDArray[Any]:
    """The array of a ``foxglove.Grid``: bool, where 1 is an obstacle, or float64. Its last row stands first."""
    itemsize = dtype.itemsize
    columns, text = message.get("column_count"), message.get("data")
    if type(columns) is not int or not 0 < columns <= MAX_ELEMENTS or not isinstance(text, str):
        raise TraceError("a grid without columns or data")
    if len(text) > MAX_ELEMENTS * itemsize * 4 // 3 + 4:
        raise TraceError(f"a grid of more than {MAX_ELEMENTS} cells")
    data = _bytes(text)
    if message.get("cell_stride") != itemsize or len(data) % (columns * itemsize):
        raise TraceError(f"a grid of {len(data)} bytes with {columns} columns of {itemsize} bytes")
    if dtype == np.dtype(bool):
        cells = np.frombuffer(data, np.uint8).reshape(-1, columns)
        if cells.size and cells.max() > 1:
            raise TraceError("a map with cells that are neither free nor occupied")
        free: NDArray[Any] = np.flipud(cells) == 0
        return free
    return np.flipud(np.frombuffer(data, "<f8").reshape(-1, columns)).astype(np.float64)


def _bytes(text: Any) -> bytes:
    if not isinstance(text, str):
        raise TraceError("an array without its base64 text")
    try:
        return base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError) as fault:
        raise TraceError(f"an array that is not base64: {fault}") from fault


def _refuse(record_type: type[Record], why: str) -> NoReturn:
    raise TraceError(f"no {record_type.__name__}: {why}")
