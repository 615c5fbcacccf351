"""The arrays of records in protobuf messages: packed fields, and ``codesign.Array``.

An array of bool is stored as ``bits``. One of float64 is stored as ``float32`` where that loses nothing, and else as
``planes``, which pack better: of each value, its 64 bits less those of the value before it, modulo 2^64; first the
lowest byte of all differences, then the next.

Nothing that is decoded is trusted: sizes are bounded and checked against shapes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.errors import TraceError
from codesign.trace.values import MAX_ELEMENTS

SHAPES: dict[str, tuple[int | None, ...]] = {
    "goals": (None, 2),
    "points": (None, 2),
    "block": (None,),
    "iterations": (None,),
    "cells": (None, 2),
    "blocked": (None,),
    "positions": (None, 2),
    "origin": (3,),
    "ranges": (None,),
    "hidden": (None, 2),
}
"""The shapes of arrays that are packed, by field. None: any length."""

_GRIDS = ("free", "unknown", "potential", "values")
"""The arrays of two dimensions."""

PACKED_TYPES = {"int32": "sint32", "bool": "bool", "float64": "double"}
"""The type of protobuf of a packed array, by dtype."""

BITS = "bits"
"""Eight bool values a byte, the first in the highest bit."""

PLANES = "planes"
"""Differences of float64 values, byte by byte."""

_STORED = {"bool": (BITS,), "float64": ("float64", "float32", PLANES)}
"""How the values of an array may be stored; those of every other dtype as they are."""


def packed(name: str, dtype: np.dtype[Any], value: Any) -> NDArray[Any]:
    """The value of field ``name`` as an array of ``dtype``.

    Raises:
        TraceError: it does not agree with the dtype or the shape of the field, or is too large.
    """
    array = np.asarray(value)
    if array.size > MAX_ELEMENTS:
        raise TraceError(f"{name} has {array.size} elements, more than 2^24")
    if array.dtype != dtype and not np.can_cast(array.dtype, dtype, casting="safe"):
        raise TraceError(f"{name} is {array.dtype} in place of {dtype}")
    if not _has_shape(name, array.shape):
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


def decode_packed(name: str, dtype: np.dtype[Any], values: Any) -> NDArray[Any]:
    """The array of a packed field.

    Raises:
        TraceError: it is too large, or has no shape of the field.
    """
    size, shape = len(values), SHAPES[name]
    if size > MAX_ELEMENTS:
        raise TraceError(f"{name} has {size} elements, more than 2^24")
    width = 2 if len(shape) == 2 else 1
    if size % width or (shape[0] is not None and size != shape[0]):
        raise TraceError(f"{name} has {size} elements")
    array = np.fromiter(values, dtype, size)
    return array.reshape(-1, 2) if width == 2 else array


def decode_array(name: str, dtype: np.dtype[Any], message: Any) -> NDArray[Any]:
    """The array of a ``codesign.Array``.

    Raises:
        TraceError: it is too large, or does not agree with the dtype or the shape of the field.
    """
    if message.dtype not in _STORED.get(dtype.name, (dtype.name,)):
        raise TraceError(f"{name} is no {dtype} array")
    if len(message.shape) > 4 or not _has_shape(name, tuple(message.shape)):
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
    return (np.unpackbits(flat, count=size) if bits else flat).astype(dtype).reshape(message.shape)


def _has_shape(name: str, shape: tuple[int, ...]) -> bool:
    """Whether the field ``name`` may have this shape."""
    if name in _GRIDS:
        return len(shape) == 2
    accepted = SHAPES.get(name, (None,) * len(shape))
    return len(shape) == len(accepted) and all(
        side in (None, length) for side, length in zip(accepted, shape, strict=True)
    )
