"""Vectors of scenarios for numba: one value of each of `LANES` scenarios, moved and computed together.

A *lane vector* is an LLVM vector of float64.  Arrays hold lane vectors in their last axis, of length
`LANES`; `load(a, i)` reads row `i` of such an array and `store(a, i, x)` writes it.  Every operation is
written out as one IEEE operation per lane, with the fused multiply-add only where `fma` says so.  The
compiler is left nothing to reassociate or contract, so a scenario's bits do not depend on its lane, on the
other lanes, or on the width of the machine's registers.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.extending import overload, register_model

from tbi_cli.integrator.arrays import LANES
from tbi_cli.integrator.primitives import intrinsic

_DOUBLE = ir.DoubleType()
_VECTOR = ir.VectorType(_DOUBLE, LANES)
_BITS = ir.VectorType(ir.IntType(1), LANES)


class _LaneVectorType(types.Type):
    def __init__(self) -> None:
        super().__init__(name=f"lanes<{LANES} x float64>")


class _LaneMaskType(types.Type):
    def __init__(self) -> None:
        super().__init__(name=f"lanes<{LANES} x bool>")


vector = _LaneVectorType()
mask = _LaneMaskType()


@register_model(_LaneVectorType)
class _LaneVectorModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _VECTOR)


@register_model(_LaneMaskType)
class _LaneMaskModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _BITS)


def _row_pointer(context: Any, builder: Any, array_type: Any, array: Any, row: Any) -> Any:
    data = context.make_array(array_type)(context, builder, array).data
    base = builder.bitcast(data, _VECTOR.as_pointer())
    return builder.gep(base, [row])


def _is_lane_array(a: Any) -> bool:
    return isinstance(a, types.Array) and a.dtype == types.float64 and a.layout == "C"


@intrinsic
def load(typingctx: Any, a: Any, row: Any) -> Any:
    """Row `row` (counted over all axes but the last) of a C-contiguous array of lane vectors."""
    if not (_is_lane_array(a) and isinstance(row, types.Integer)):
        return None

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        pointer = _row_pointer(context, builder, signature.args[0], args[0], args[1])
        return builder.load(pointer, align=8)

    return vector(a, types.int64), codegen


@intrinsic
def load_at(typingctx: Any, a: Any, place: Any) -> Any:
    """The row of a C-contiguous array of lane vectors before which so many bytes stand."""
    if not (_is_lane_array(a) and isinstance(place, types.Integer)):
        return None

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        base = builder.bitcast(data, ir.IntType(8).as_pointer())
        pointer = builder.bitcast(builder.gep(base, [args[1]]), _VECTOR.as_pointer())
        return builder.load(pointer, align=8)

    return vector(a, types.int64), codegen


@intrinsic
def store(typingctx: Any, a: Any, row: Any, x: Any) -> Any:
    """Write the lane vector `x` to row `row` of a C-contiguous array of lane vectors."""
    if not (_is_lane_array(a) and isinstance(row, types.Integer) and x == vector):
        return None

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        pointer = _row_pointer(context, builder, signature.args[0], args[0], args[1])
        builder.store(args[2], pointer, align=8)
        return context.get_dummy_value()

    return types.void(a, types.int64, vector), codegen


@intrinsic
def splat(typingctx: Any, x: Any) -> Any:
    """The lane vector that holds the scalar `x` in every lane."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        one = builder.insert_element(
            ir.Constant(_VECTOR, ir.Undefined), args[0], ir.Constant(ir.IntType(32), 0)
        )
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
        return builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), zeros)

    return vector(types.float64), codegen


def _llvm_call(name: str, n_args: int) -> Any:
    """An intrinsic of `n_args` lane vectors that is one call of LLVM's `name`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        function_type = ir.FunctionType(_VECTOR, [_VECTOR] * n_args)
        function = cgutils.get_or_insert_function(builder.module, function_type, f"{name}.v{LANES}f64")
        return builder.call(function, args)

    return codegen


@intrinsic
def fma(typingctx: Any, x: Any, y: Any, z: Any) -> Any:
    """x y + z, rounded once."""
    return vector(vector, vector, vector), _llvm_call("llvm.fma", 3)


@intrinsic
def floor(typingctx: Any, x: Any) -> Any:
    """Each lane rounded down to an integer."""
    return vector(vector), _llvm_call("llvm.floor", 1)


@intrinsic
def nearest_integer(typingctx: Any, x: Any) -> Any:
    """Each lane rounded to the nearest integer, halves to even."""
    return vector(vector), _llvm_call("llvm.rint", 1)


def _compare(predicate: str) -> Any:
    def typer(typingctx: Any, x: Any, y: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return builder.fcmp_ordered(predicate, args[0], args[1])

        return mask(vector, vector), codegen

    return intrinsic(typer)


greater = _compare(">")
less = _compare("<")
at_least = _compare(">=")


@intrinsic
def select(typingctx: Any, where: Any, x: Any, y: Any) -> Any:
    """Each lane of `x` where the mask is set, else of `y`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(*args)

    return vector(mask, vector, vector), codegen


@intrinsic
def both(typingctx: Any, a: Any, b: Any) -> Any:
    """Lanes set in `a` and in `b`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.and_(*args)

    return mask(mask, mask), codegen


@intrinsic
def either(typingctx: Any, a: Any, b: Any) -> Any:
    """Lanes set in `a` or in `b`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.or_(*args)

    return mask(mask, mask), codegen


@intrinsic
def any_lane(typingctx: Any, where: Any) -> Any:
    """True where at least one lane of the mask is set."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        bits = builder.bitcast(args[0], ir.IntType(LANES))
        return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(LANES), 0))

    return types.boolean(mask), codegen


@intrinsic
def gather_four(typingctx: Any, a: Any, record: Any) -> Any:
    """Elements 4 i, 4 i + 1, 4 i + 2, 4 i + 3 of a C-contiguous array, each lane with its own i.

    The i are whole numbers, within the array.  Returns four lane vectors.
    """
    if not (_is_lane_array(a) and record == vector):
        return None
    four = ir.VectorType(_DOUBLE, 4)

    def picked(*order: int) -> Any:
        return ir.Constant(ir.VectorType(ir.IntType(32), LANES), list(order))

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        base = builder.bitcast(data, four.as_pointer())
        records = []
        for lane in range(LANES):
            number = builder.extract_element(args[1], ir.Constant(ir.IntType(32), lane))
            place = builder.gep(base, [builder.fptosi(number, ir.IntType(64))])
            records.append(builder.load(place, align=8))
        # Eight rows of four to four rows of eight: by twos, by fours, by eight.
        twos = [
            builder.shuffle_vector(records[k], records[k + 1], picked(0, 4, 1, 5, 2, 6, 3, 7))
            for k in range(0, LANES, 2)
        ]
        low, high = (picked(*(k, k + 1, k + 8, k + 9, k + 2, k + 3, k + 10, k + 11)) for k in (0, 4))
        fours = [[builder.shuffle_vector(twos[k], twos[k + 1], half) for half in (low, high)] for k in (0, 2)]
        first, second = picked(0, 1, 2, 3, 8, 9, 10, 11), picked(4, 5, 6, 7, 12, 13, 14, 15)
        columns = [
            builder.shuffle_vector(fours[0][k], fours[1][k], half) for k in (0, 1) for half in (first, second)
        ]
        return context.make_tuple(builder, signature.return_type, columns)

    return types.UniTuple(vector, 4)(a, vector), codegen


def _arithmetic(python_operator: Any, instruction: str) -> None:
    @intrinsic
    def lanewise(typingctx: Any, x: Any, y: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return getattr(builder, instruction)(*args)

        return vector(vector, vector), codegen

    # numba wants the overload and what it returns to agree in their annotations: neither has any.
    @overload(python_operator)
    def typed(x, y):  # type: ignore[no-untyped-def]
        return (lambda x, y: lanewise(x, y)) if x == vector and y == vector else None


_arithmetic(operator.add, "fadd")
_arithmetic(operator.sub, "fsub")
_arithmetic(operator.mul, "fmul")


@overload(operator.neg)
def _negate(x):  # type: ignore[no-untyped-def]
    return (lambda x: splat(-0.0) - x) if x == vector else None
