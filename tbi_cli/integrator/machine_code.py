"""Compiles kernels: numba makes LLVM's language of them, and LLVM an object file that needs no numba."""

from __future__ import annotations

from importlib import import_module
from itertools import count
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numba import cfunc, types
from numba.core import extending
from numba.np.arrayobj import populate_array
from numba.np.numpy_support import from_dtype

from tbi_cli.integrator.kernels import KERNELS, fields
from tbi_cli.integrator.native import target_machine
from tbi_cli.integrator.primitives import UNCOUNTED

_WORD = ir.IntType(64)


def object_code(name: str) -> bytes:
    """The object file of a kernel, in which it is called by its name."""
    return bytes(target_machine().emit_object(module(name)))


def module(name: str) -> llvm.ModuleRef:
    """LLVM's module of a kernel: a function of its name, and what it calls."""
    kernel = KERNELS[name]
    function = getattr(import_module(f"tbi_cli.integrator.{kernel.module}"), name)
    return compiled(name, function, kernel.arguments)


def compiled(name: str, function: Any, arguments: tuple[Any, ...]) -> llvm.ModuleRef:
    """LLVM's module of a function of numba's: of its arguments, and of a count behind them."""
    unpack = _unpacker(types.Tuple([_type(argument) for argument in arguments]))

    @cfunc(types.void(types.CPointer(types.int64), types.int64), **UNCOUNTED)
    def entry(frame, number):  # type: ignore[no-untyped-def]
        function(*unpack(frame), number)

    found = llvm.parse_assembly(entry.inspect_llvm())
    main = found.get_function(entry.native_name.removeprefix("cfunc."))
    main.name = name
    for value in (*found.functions, *found.global_variables):
        if not value.is_declaration and value.name != name:
            value.linkage = "internal"
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.add_strip_dead_prototype_pass()
    passes.run(found, llvm.create_pass_builder(target_machine(), llvm.create_pipeline_tuning_options()))
    return found


def _type(argument: Any) -> Any:
    if argument in (int, bool):
        return types.int64 if argument is int else types.boolean
    if hasattr(argument, "_fields"):
        return types.NamedTuple([_type(field) for field in fields(argument)], argument)
    dtype, axes = argument.__metadata__
    return types.Array(from_dtype(np.dtype(dtype)), axes, "C")


def _unpacker(whole: Any) -> Any:
    """Makes a tuple of numba's of the words of a frame, see `kernels.frame`."""

    def unpack(typingctx: Any, frame: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            places = count()

            def word() -> Any:
                return builder.load(builder.gep(args[0], [ir.Constant(_WORD, next(places))]))

            def value(kind: Any) -> Any:
                if isinstance(kind, types.Array):
                    return array(kind)
                if kind == types.boolean:
                    return builder.icmp_unsigned("!=", word(), ir.Constant(_WORD, 0))
                if kind == types.int64:
                    return word()
                return context.make_tuple(builder, kind, [value(item) for item in kind])

            def array(kind: Any) -> Any:
                made = context.make_array(kind)(context, builder)
                data = builder.inttoptr(word(), made.data.type)
                shape = [word() for _ in range(kind.ndim)]
                itemsize = ir.Constant(_WORD, 8)
                strides = [itemsize]
                for extent in shape[:0:-1]:
                    strides.insert(0, builder.mul(strides[0], extent))
                populate_array(made, data, shape, strides, itemsize, meminfo=None)
                return made._getvalue()

            return value(whole)

        return whole(frame), codegen

    return extending.intrinsic(unpack)
