# mypy: ignore-errors
# ruff: noqa: ARG001
# The compiler of numba gives types, and calls the generators below with arguments that some do without.
"""Eight words that move as one, for numba.

Numba leaves vectors to the compiler's judgement, and it does not find them where carries run across a loop over
planes. So the kernels use vectors of eight words explicitly, one AVX-512 register. Where the machine has narrower
registers the compiler splits them.

Arrays are given by their addresses: an array inside a kernel has its references counted at every use.

Numba's cache does not see edits in this file: ``kernels`` names the remedy.
"""

from __future__ import annotations

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, models, overload, register_model

from codesign.planners.harmonic.plan.layout import LANES, WORD_BITS

# lane      0        1              7
#       +--------+--------+ .. +--------+
#       | row i  | row i+1|    | row i+7|     each lane a word: 64 columns of one row, 512 nodes in all
#       +--------+--------+ .. +--------+
_WORD = ir.IntType(WORD_BITS)
_VECTOR = ir.VectorType(_WORD, LANES)


class Lanes(types.Type):
    """Eight words that move as one."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


lanes_type = Lanes()


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, _VECTOR)


def _pointer(builder, arguments, kind):
    words = builder.inttoptr(arguments[0], _WORD.as_pointer())
    return builder.bitcast(builder.gep(words, [arguments[1]]), kind.as_pointer())


@intrinsic
def load(typing_context, address, index):
    """Eight words from ``index`` on."""

    def generate(context, builder, signature, arguments):
        # Aligned to a word only: north and south are loads that begin one word off a group.
        return builder.load(_pointer(builder, arguments, _VECTOR), align=8)

    return lanes_type(types.int64, types.int64), generate


@intrinsic
def store(typing_context, address, index, lanes):
    """Put eight words from ``index`` on."""

    def generate(context, builder, signature, arguments):
        builder.store(arguments[2], _pointer(builder, arguments, _VECTOR), align=8)
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, lanes_type), generate


@intrinsic
def get(typing_context, address, index):
    """The word at ``index``."""

    def generate(context, builder, signature, arguments):
        return builder.load(_pointer(builder, arguments, _WORD))

    return types.int64(types.int64, types.int64), generate


@intrinsic
def put(typing_context, address, index, word):
    """Put a word at ``index``."""

    def generate(context, builder, signature, arguments):
        builder.store(arguments[2], _pointer(builder, arguments, _WORD))
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64), generate


@intrinsic
def zeros(typing_context):
    """All zeros."""

    def generate(context, builder, signature, arguments):
        return ir.Constant(_VECTOR, [0] * LANES)

    return lanes_type(), generate


@intrinsic
def any_bit(typing_context, lanes):
    """True if any bit is set."""

    def generate(context, builder, signature, arguments):
        # Eight comparisons become one byte with a bit a lane, and that is compared with 0: a mask register, no loop.
        set_lanes = builder.icmp_unsigned("!=", arguments[0], ir.Constant(_VECTOR, [0] * LANES))
        packed = builder.bitcast(set_lanes, ir.IntType(LANES))
        return builder.icmp_unsigned("!=", packed, ir.Constant(ir.IntType(LANES), 0))

    return types.boolean(lanes_type), generate


@intrinsic
def majority(typing_context, a, b, c):
    """The carry of a + b + c, bit by bit. The sum is a ^ b ^ c."""

    # Bit by bit a + b + c = 2 · carry + sum: a full adder, 64 of them in a word.
    def generate(context, builder, signature, arguments):
        a, b, c = arguments
        features = context.codegen().magic_tuple()[2].split(",")
        if "+avx512f" not in features:
            return builder.or_(builder.and_(a, b), builder.and_(c, builder.or_(a, b)))
        # LLVM makes two instructions of this; the processor has one for any function of three bits, here the eight
        # values 1 1 1 0 1 0 0 0 for a b c from 111 down to 000.
        kind = ir.FunctionType(_VECTOR, [_VECTOR] * 3 + [ir.IntType(32)])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.x86.avx512.pternlog.q.512")
        return builder.call(function, [a, b, c, ir.IntType(32)(0b11101000)])

    return lanes_type(lanes_type, lanes_type, lanes_type), generate


def _funnel(name, what):
    def shift(typing_context, a, b):
        def generate(context, builder, signature, arguments):
            kind = ir.FunctionType(_VECTOR, [_VECTOR] * 3)
            function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{LANES}i{WORD_BITS}")
            return builder.call(function, [*arguments, ir.Constant(_VECTOR, [1] * LANES)])

        return lanes_type(lanes_type, lanes_type), generate

    shift.__doc__ = what
    return intrinsic(shift)


shift_up = _funnel("fshl", "The first, one bit up; the lowest bit of a word is the highest of the second's.")
shift_down = _funnel("fshr", "The second, one bit down; the highest bit of a word is the lowest of the first's.")


@intrinsic
def spread(typing_context, word):
    """The same word in every lane."""

    def generate(context, builder, signature, arguments):
        # Into lane 0, then from there to all: the form that LLVM knows as a broadcast.
        single = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), arguments[0], ir.IntType(32)(0))
        return builder.shuffle_vector(
            single, ir.Constant(_VECTOR, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
        )

    return lanes_type(types.uint64), generate


def _overload_logic(instruction, *operations):
    @intrinsic
    def apply(typing_context, a, b):
        def generate(context, builder, signature, arguments):
            return getattr(builder, instruction)(*arguments)

        return lanes_type(lanes_type, lanes_type), generate

    def choose(a, b):
        if isinstance(a, Lanes) and isinstance(b, Lanes):
            return lambda a, b: apply(a, b)  # noqa: PLW0108  (numba wants a plain function)
        return None

    for operation in operations:
        overload(operation)(choose)


_overload_logic("and_", operator.and_, operator.iand)
_overload_logic("or_", operator.or_, operator.ior)
_overload_logic("xor", operator.xor, operator.ixor)
_overload_logic("shl", operator.lshift)
_overload_logic("lshr", operator.rshift)
