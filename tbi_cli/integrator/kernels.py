"""What kernels there are, what they take, and how one is called.

A kernel is machine code that takes one *frame*, the addresses, shapes and numbers of its arguments as 64-bit
words in a row, and a count that changes from call to call.  `machine_code` makes it, `native` loads it, and
`kernel_cache` keeps it between the two; only the first of them needs numba.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from tbi_cli.integrator.arrays import Crossing, History, Lanes, Topology, Vector, Work


class Kernel(NamedTuple):
    """Where a kernel is written, and the types of its arguments before the last one, a count."""

    module: str
    arguments: tuple[Any, ...]


KERNELS = {
    "advance": Kernel("kernel", (Topology, Crossing, Work, int, History)),
    "advance_forces": Kernel("forces", (Topology, Crossing, Work, int, History)),
    "advance_exactly": Kernel("exact", (Topology, Crossing, Work, History)),
    "one_interval": Kernel("exact", (Lanes, Lanes, Vector, Vector, Lanes)),
}

# The kernels of whatever crosses a bridge, and those of trains of constant forces.
KINDS = {"general": ("advance",), "forces": ("advance_forces", "advance_exactly", "one_interval")}

Function = Callable[[int, int], int]  # address of the frame, count -> 0, or another number for an error


class Call:
    """A kernel with its arguments; calling it with a count lets it work on them.

    Raises TypeError if the arguments are not those of the kernel.
    """

    def __init__(self, name: str, function: Function, *values: Any) -> None:
        self._name, self._function = name, function
        self._values = values  # the frame holds their addresses
        self._frame = frame(name, values)

    def __call__(self, count: int) -> None:
        """Raises ArithmeticError where the kernel fails, as by a division by zero."""
        if self._function(self._frame.ctypes.data, count):
            raise ArithmeticError(f"kernel {self._name} failed")


def frame(name: str, values: tuple[Any, ...]) -> NDArray[np.int64]:
    """The words of the arguments of a kernel: a number is one, an array its address and its shape."""
    words: list[int] = []
    for argument, value in zip(_flat_types(name), _flat(values), strict=True):
        if argument in (int, bool):
            words.append(int(value))
            continue
        dtype, axes = argument.__metadata__
        if value.dtype != dtype or value.ndim != axes or not value.flags.c_contiguous:
            raise TypeError(f"expected a contiguous array of {axes} axes of {np.dtype(dtype)}, got {value!r}")
        words += (value.__array_interface__["data"][0], *value.shape)
    return np.array(words, dtype=np.int64)


def _flat(values: tuple[Any, ...]) -> Iterator[Any]:
    for value in values:
        yield from value if isinstance(value, tuple) else (value,)


@lru_cache
def _flat_types(name: str) -> list[Any]:
    found: list[Any] = []
    for argument in KERNELS[name].arguments:
        found += fields(argument) if hasattr(argument, "_fields") else [argument]
    return found


def fields(argument: Any) -> tuple[Any, ...]:
    """The types of the fields of a named tuple."""
    return tuple(get_type_hints(argument, include_extras=True).values())
