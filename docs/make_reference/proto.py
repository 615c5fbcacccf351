"""``docs/reference/trace.proto``: the messages of records, for whoever decodes them without this package."""

from __future__ import annotations

import inspect

from codesign.ground.records import RECORD_TYPES
from codesign.views.trace.messages import ARRAY, PACKAGE, plan_of

_HEAD = f"""\
// The messages of records in the traces of hwsw, made from codesign/ground/records.py by python -m docs.make_reference.
// Each channel of a trace embeds the descriptors of its own message, so no decoder needs this file.
//
// The fields of n × 2 arrays are row by row: row, column, row, column. The log time of a message is the time of its
// record in whole nanoseconds from 0; `picoseconds` are to be added. A sint64 is a time, in picoseconds after that.
syntax = "proto3";

package {PACKAGE};

// An array. `dtype` is "float64", "float32", "int32" or another name of NumPy, with little-endian `data`, rows first;
// or "bits": eight bool values a byte, the first in the highest bit; or "planes": the 64 bits of each float64 less
// those of the value before it, modulo 2^64: first the lowest byte of all these differences, then the next.
message {ARRAY} {{
  repeated uint32 shape = 1;
  string dtype = 2;
  bytes data = 3;
}}
"""


def proto_page() -> str:
    """The text of the file."""
    parts = [_HEAD]
    for name, record in RECORD_TYPES.items():
        lines = [f"// {line}".rstrip() for line in inspect.cleandoc(record.__doc__ or "").splitlines()]
        fields = [
            f"  {plan.type_name} {plan.stored} = {plan.number};{'  // JSON' if plan.kind == 'mapping' else ''}"
            for plan in plan_of(record)
        ]
        parts.append("\n".join([*lines, f"message {name} {{", *fields, "}", ""]))
    return "\n".join(parts)
