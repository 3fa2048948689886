"""Machine code of this processor: loaded, and called."""

from __future__ import annotations

import ctypes
import hashlib
import platform
from typing import Any

import llvmlite.binding as llvm

# What numba makes of a function: it returns a status, and writes to where its first two arguments point.
_PROTOTYPE = ctypes.CFUNCTYPE(
    ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64
)


def processor() -> str:
    """Name of this processor, with a hash of what it can do."""
    features = llvm.get_host_cpu_features().flatten()
    return f"{llvm.get_host_cpu_name()}-{hashlib.sha256(features.encode()).hexdigest()[:8]}"


def target_machine() -> llvm.TargetMachine:
    """What makes code for this processor."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=3,
        reloc="static" if platform.machine() in ("x86_64", "AMD64") else "default",
        codemodel="jitdefault",
        jit=True,
    )


class Loaded:
    """The kernel of that name in an object file, in memory.  Calling it releases the interpreter's lock."""

    def __init__(self, name: str, code: bytes) -> None:
        self._engine: Any = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine())
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        self._function = _PROTOTYPE(self._engine.get_function_address(name))

    def __call__(self, frame: int, count: int) -> int:
        unused, error = ctypes.c_void_p(), ctypes.c_void_p()
        status: int = self._function(ctypes.byref(unused), ctypes.byref(error), frame, count)
        return status
