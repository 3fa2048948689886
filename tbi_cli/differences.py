"""What differs between two results files."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import yaml

from tbi_cli.store import Results


def differences(a: Results, b: Results) -> Iterator[str]:
    """Lines on keys of the case, axes, channels, and by how much tables differ; none if nothing does."""
    yield from _of_cases(a.case_yaml, b.case_yaml)
    axes = [{dim.name: dim.values for dim in results.dims} for results in (a, b)]
    for name in sorted(axes[0].keys() | axes[1].keys()):
        if name not in axes[0] or name not in axes[1]:
            yield f"axis {name}: only in the {'first' if name in axes[0] else 'second'}"
        elif not np.array_equal(axes[0][name], axes[1][name]):
            yield f"axis {name}: {len(axes[0][name])} values and {len(axes[1][name])}, not the same"
    names = [[channel.name for channel in results.channels] for results in (a, b)]
    for name in sorted(set(names[0]) ^ set(names[1])):
        yield f"channel {name}: only in the {'first' if name in names[0] else 'second'}"
    if a.shape == b.shape:
        yield from _of_tables(a, b, [name for name in names[0] if name in names[1]])


def _of_cases(a: str, b: str) -> Iterator[str]:
    flat = [dict(_flat(yaml.safe_load(text))) for text in (a, b)]
    for key in sorted(flat[0].keys() | flat[1].keys()):
        one, other = flat[0].get(key, "nothing"), flat[1].get(key, "nothing")
        if one != other:
            yield f"case {key}: {one} and {other}"


def _flat(value: object, key: str = "") -> Iterator[tuple[str, object]]:
    if isinstance(value, dict):
        for name, item in value.items():
            yield from _flat(item, f"{key}.{name}" if key else str(name))
    else:
        yield key, value


def _of_tables(a: Results, b: Results, channels: list[str]) -> Iterator[str]:
    """The largest difference of each table that differs, over the channel's largest value."""
    for group in ("peak", "max", "min", "rms", "time_of_peak"):
        worst, where, count = 0.0, "", 0
        for name in channels:
            one, other = a.table(group, name), b.table(group, name)
            if np.array_equal(one, other, equal_nan=True):
                continue
            count += 1
            both = np.isfinite(one) & np.isfinite(other)
            size = float(np.max(np.abs(one[both]), initial=0.0)) or 1.0
            relative = float(np.max(np.abs(one - other)[both], initial=0.0)) / size
            if np.array_equal(np.isfinite(one), np.isfinite(other)) is False:
                relative = np.inf
            if relative >= worst:
                worst, where = relative, name
        if count:
            yield f"table {group}: {count} channels differ, {where} most, by {worst:.2g} of its largest value"
