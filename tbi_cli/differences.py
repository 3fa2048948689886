"""What differs between two results files."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import CaseError
from tbi_cli.case.leaves import leaves_of
from tbi_cli.printable import one_line
from tbi_cli.store import Results
from tbi_cli.store.compare import in_short

_VERSIONS = ("tbi_version", "numpy_version", "numba_version", "h5py_version")


def differences(a: Results, b: Results) -> Iterator[str]:
    """Lines on versions, keys of the case, axes, channels, status and tables; none if nothing differs."""
    for key in _VERSIONS:
        one, other = (one_line(str(results.attributes.get(key, "nothing"))) for results in (a, b))
        if one != other:
            yield f"{key}: {one} and {other}"
    yield from _of_cases(a.case_yaml, b.case_yaml)
    axes = [{dim.name: dim.values for dim in results.dims} for results in (a, b)]
    for name in sorted(axes[0].keys() | axes[1].keys()):
        if name not in axes[0] or name not in axes[1]:
            yield f"axis {name}: only in the {'first' if name in axes[0] else 'second'}"
        elif not np.array_equal(axes[0][name], axes[1][name]):
            yield f"axis {name}: {len(axes[0][name])} values and {len(axes[1][name])}, not the same"
    yield from _of_names("channel", *([channel.name for channel in results.channels] for results in (a, b)))
    stored = ([channel.name for channel in results.history_channels] for results in (a, b))
    yield from _of_names("history of", *stored)
    if a.shape == b.shape:
        differ = int(np.sum(a.status != b.status))
        if differ:
            yield f"status: of {differ} scenario{'s' if differ > 1 else ''}"
        if _flags(a) != _flags(b):
            yield "converged: not the same"
        for group in a.layout.groups:
            yield from _of_table(group, a, b)


def _flags(results: Results) -> bytes | None:
    return None if results.converged is None else results.converged.tobytes()


def _of_cases(a: str, b: str) -> Iterator[str]:
    if a == b:
        return
    try:
        one, other = leaves_of(a), leaves_of(b)
    except CaseError:
        yield "case: not the same, and not to be compared key by key"
        return
    for key in sorted(one.keys() | other.keys()):
        values = [in_short(leaves[key]) if key in leaves else "nothing" for leaves in (one, other)]
        if key not in one or key not in other or one[key] != other[key]:
            yield f"case {one_line(key)}: {' and '.join(values)}"


def _of_names(kind: str, a: list[str], b: list[str]) -> Iterator[str]:
    for name in sorted(set(a) ^ set(b)):
        yield f"{kind} {name}: only in the {'first' if name in a else 'second'}"


def _of_table(group: str, a: Results, b: Results) -> Iterator[str]:
    """How many variables of a table differ, and the largest difference, over the variable's largest value."""
    names = [[variable.name for variable in results.layout.columns(group)] for results in (a, b)]
    found = (
        (_relative(a.table(group, name), b.table(group, name)), name) for name in names[0] if name in names[1]
    )
    differing = [(relative, name) for relative, name in found if relative]
    if differing:
        worst, where = max(differing)
        many = f"{len(differing)} channels differ" if len(differing) > 1 else "1 channel differs"
        amount = "in what is not computed" if np.isinf(worst) else f"by {worst:.2g} of its largest value"
        yield f"table {group}: {many}, {where} most, {amount}"


def _relative(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """The largest difference over the largest value; infinite where one lacks what the other has."""
    if np.array_equal(one, other, equal_nan=True):
        return 0.0
    both = np.isfinite(one) & np.isfinite(other)
    if not np.array_equal(np.isfinite(one), np.isfinite(other)):
        return np.inf
    size = float(np.max(np.abs(one[both]), initial=0.0)) or 1.0
    return float(np.max(np.abs(one - other)[both], initial=0.0)) / size
