"""What the functions of a kernel are made with, besides vectors of lanes."""

from __future__ import annotations

import platform
from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils, extending

# Numba types an intrinsic by what its maker takes, not by what its caller gives.
intrinsic: Any = extending.intrinsic

# What kernels are made of.  Nothing in them owns memory, so numba need not count references to it.
UNCOUNTED: Any = {"_nrt": False}
inlined: Any = njit(forceinline=True, **UNCOUNTED)
subroutine: Any = njit(**UNCOUNTED)


@intrinsic
def item(typingctx: Any, a: Any, i: Any) -> Any:
    """Element `i` of a one-dimensional int64 array, `i` known not to be negative (no wrap-around)."""
    if not (isinstance(a, types.Array) and a.dtype == types.int64 and isinstance(i, types.Integer)):
        return None

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        return builder.load(builder.gep(data, [args[1]]))

    return types.int64(a, types.int64), codegen


@intrinsic
def flush_subnormals(typingctx: Any, flush: Any) -> Any:
    """Turns the flushing of subnormal numbers to zero on or off for this thread.

    A motion that has died away to below 1e-308 would otherwise cost three times as much as a living one.
    On processors other than x86, which do not slow down, nothing is done.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        if platform.machine() in ("x86_64", "AMD64"):
            word, pointer = ir.IntType(32), ir.IntType(8).as_pointer()
            call = ir.FunctionType(ir.VoidType(), [pointer])
            register = cgutils.alloca_once(builder, word)
            address = builder.bitcast(register, pointer)
            builder.call(
                cgutils.get_or_insert_function(builder.module, call, "llvm.x86.sse.stmxcsr"), [address]
            )
            old, bits = (
                builder.load(register),
                ir.Constant(word, 0x8040),
            )  # flush to zero, and zeros for operands
            builder.store(
                builder.select(args[0], builder.or_(old, bits), builder.and_(old, builder.not_(bits))),
                register,
            )
            builder.call(
                cgutils.get_or_insert_function(builder.module, call, "llvm.x86.sse.ldmxcsr"), [address]
            )
        return context.get_dummy_value()

    return types.void(types.boolean), codegen
