"""The arrays of records in protobuf messages: packed fields, and ``codesign.Array``.

An array of bool is stored as ``bits``. One of float64 is stored as ``float32`` where that loses nothing, and else as
``planes``, which pack better: of each value, its 64 bits less the bits of the value before it, modulo 2^64; first the
lowest byte of all differences, then the next.

Nothing that is decoded is trusted: sizes are bounded and checked against shapes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import TraceError
from codesign.ground.records import ArrayOf
from codesign.views.trace.values import MAX_ELEMENTS

PACKED_TYPES = {"int32": "sint32", "bool": "bool", "float64": "double"}
"""The type of protobuf of a packed array, by dtype."""

BITS = "bits"
"""Eight bool values a byte, the first in the highest bit."""

PLANES = "planes"
"""Differences of float64 values, byte by byte."""

_STORED = {"bool": (BITS,), "float64": ("float64", "float32", PLANES)}
"""The forms in which the values of an array may be stored; values of every other dtype are stored as they are."""


def is_packed(form: ArrayOf) -> bool:
    """True if the field of an array is packed: protobuf has its dtype, and the number of values gives its shape."""
    return form.dtype in PACKED_TYPES and None not in form.shape[1:]


def packed(name: str, form: ArrayOf, value: Any) -> NDArray[Any]:
    """The value of field ``name`` as an array of this form.

    Raises:
        TraceError: it does not agree with the dtype or the shape of the field, or is too large.
    """
    array, dtype = np.asarray(value), np.dtype(form.dtype)
    if array.size > MAX_ELEMENTS:
        raise TraceError(f"{name} has {array.size} elements, more than 2^24")
    if array.dtype != dtype and not np.can_cast(array.dtype, dtype, casting="safe"):
        raise TraceError(f"{name} is {array.dtype} in place of {dtype}")
    if not has_shape(form, array.shape):
        raise TraceError(f"{name} has shape {list(array.shape)}")
    return array.astype(dtype, copy=False)


def array_message(array: NDArray[Any]) -> dict[str, Any]:
    """The fields of ``codesign.Array``, in few bytes."""
    if array.dtype == bool:
        return {"shape": array.shape, "dtype": BITS, "data": np.packbits(array).tobytes()}
    if array.dtype == np.float64:
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            half = array.astype(np.float32)
        if not np.array_equal(half, array, equal_nan=True):
            differences = np.diff(np.ascontiguousarray(array).view("<u8").ravel(), prepend=np.uint64(0))
            planes = differences.astype("<u8", copy=False).view(np.uint8).reshape(-1, 8).T
            return {"shape": array.shape, "dtype": PLANES, "data": planes.tobytes()}
        array = half
    little = array.astype(array.dtype.newbyteorder("<"), copy=False)
    return {"shape": array.shape, "dtype": array.dtype.name, "data": little.tobytes()}


def decode_packed(name: str, form: ArrayOf, values: Any) -> NDArray[Any]:
    """The array of a packed field.

    Raises:
        TraceError: it is too large, or has no shape of the field.
    """
    size, shape = len(values), form.shape
    if size > MAX_ELEMENTS:
        raise TraceError(f"{name} has {size} elements, more than 2^24")
    rows, odd = divmod(size, math.prod(side or 1 for side in shape[1:]))
    if odd or shape[0] not in (None, rows):
        raise TraceError(f"{name} has {size} elements")
    return np.fromiter(values, form.dtype, size).reshape(rows, *(side or 1 for side in shape[1:]))


def decode_array(name: str, form: ArrayOf, message: Any) -> NDArray[Any]:
    """The array of a ``codesign.Array``.

    Raises:
        TraceError: it is too large, or does not agree with the dtype or the shape of the field.
    """
    if message.dtype not in _STORED.get(form.dtype, (form.dtype,)):
        raise TraceError(f"{name} is no {form.dtype} array")
    if not has_shape(form, message.shape):
        raise TraceError(f"{name} has shape {list(message.shape[:4])}")
    size, data = math.prod(message.shape), message.data
    if size > MAX_ELEMENTS:
        raise TraceError(f"{name} has {size} elements, more than 2^24")
    bits, planes = message.dtype == BITS, message.dtype == PLANES
    stored = np.dtype(np.uint8 if bits else "<u8" if planes else message.dtype).newbyteorder("<")
    if len(data) != (-(-size // 8) if bits else size * stored.itemsize):
        raise TraceError(f"{name} has {len(data)} bytes for {size} elements")
    if planes:
        lowest_first = np.ascontiguousarray(np.frombuffer(data, np.uint8).reshape(8, -1).T)
        values = np.cumsum(lowest_first.view(stored).ravel(), dtype=np.uint64).view(np.float64)
        return values.reshape(message.shape)
    flat = np.frombuffer(data, stored)
    return (np.unpackbits(flat, count=size) if bits else flat).astype(form.dtype).reshape(message.shape)


def has_shape(form: ArrayOf, shape: Sequence[int]) -> bool:
    """True if an array of this form may have this shape."""
    return len(shape) == len(form.shape) and all(
        side in (None, length) for side, length in zip(form.shape, shape, strict=True)
    )
