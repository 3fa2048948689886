"""Kernels as another processor has them."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from tbi_cli.integrator import kernel_cache, native
from tbi_cli.integrator.machine_code import object_code


def of_the_oldest_processor(monkeypatch: pytest.MonkeyPatch, names: Iterable[str]) -> dict[str, bytes]:
    """Compiles kernels for the oldest processor of this family, and has them used until the test ends.

    Its vectors are of two numbers at most, and on x86-64 it has no multiply-adds: a library makes them.
    """
    monkeypatch.setattr(native.llvm, "get_host_cpu_name", lambda: "generic")
    monkeypatch.setattr(native.llvm, "get_host_cpu_features", native.llvm.FeatureMap)
    codes = {name: object_code(name) for name in names}
    for name, code in codes.items():
        monkeypatch.setitem(kernel_cache._functions, name, native.Loaded(name, code))
    return codes
