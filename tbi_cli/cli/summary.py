"""The short table that ends a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tbi_cli.advice import go_on
from tbi_cli.runner import Summary
from tbi_cli.store import Results, Variable, open_results, studies_of

# What most people look at first, where the vehicle has it.
_HEADLINES = (
    "right_midspan",
    "left_midspan",
    "right_midspan_acceleration",
    "car_body_y",
    "car_body_z",
    "car_body_y_acceleration",
    "car_body_z_acceleration",
    "sprung_mass_y",
    "sprung_mass_y_acceleration",
    "beam_y",
    "beam_pitch",
)
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
# Below this share of the largest value of its unit a peak is what rounding leaves of a zero: a train that is
# the same on both sides does not sway.  Rounding is 1e-16, and grows with the steps and the stiffest spring.
_NOTHING = 1e-12
_PREFIXED = ("m", "m/s", "m/s2", "N", "rad", "rad/s", "rad/s2")


def print_summary(summary: Summary, command: Sequence[str], *, every_channel: bool = False) -> None:
    """Prints the extremes of the run that `command` made and where its results are."""
    if summary.left:
        print(
            f"stopped: {summary.solved + summary.before} scenarios are done, {summary.left} are left; "
            f"{go_on(command)}"
        )
        return
    for study in studies_of(summary.path) or ("",):
        with open_results(summary.path, study=study, own=True) as results:
            lines = extremes(results, every_channel=every_channel)
        print("\n".join([study, *(f"  {line}" for line in lines)] if study else lines))
    count = summary.solved + summary.before
    rate = summary.steps / max(summary.seconds, 1e-9)
    print(
        f"{count} scenario{'s' if count != 1 else ''} solved"
        + (f", {summary.failed} failed" if summary.failed else "")
        + (f" ({summary.before} of them before)" if summary.before else "")
        + (f"; {summary.seconds:.2f} s, {rate / 1e6:.2f} million steps a second" if summary.steps else "")
    )
    failed = (
        f"; {summary.failed} scenario{'s' if summary.failed != 1 else ''} failed" if summary.failed else ""
    )
    print(f"results: {summary.path}{failed}")


def unsettled(scenarios: Sequence[str]) -> str:
    """A line on the scenarios, in words, at which a refined sweep did not reach its tolerance."""
    count = len(scenarios)
    where = scenarios[0] if count == 1 else f"{count} scenarios, the first {scenarios[0]}"
    return f"the tolerance of the refined sweep was not reached at {where}; `converged` is 0 there"


def extremes(results: Results, *, every_channel: bool) -> list[str]:
    """A line per channel: its largest absolute value, when, and at which axis values; 0 for mere rounding."""
    channels = [c for c in results.channels if every_channel or c.name in _HEADLINES]
    if not every_channel:
        channels.sort(key=lambda channel: _HEADLINES.index(channel.name))
    swept = [
        (dim.name, column) for dim in results.dims if len(dim.values) > 1 for column in dim.members or (dim,)
    ]
    rows: list[Sequence[str]] = [("channel", "peak", "at", *(column.name for _, column in swept))]
    found: list[tuple[Variable, int, float]] = []
    of_unit: dict[str, float] = {}
    for channel in channels:
        peak = results.table("peak", channel.name).ravel()
        if np.isfinite(peak).any():
            case = int(np.nanargmax(peak))
            found.append((channel, case, float(peak[case])))
            of_unit[channel.units] = max(of_unit.get(channel.units, 0.0), found[-1][2])
    for channel, case, value in found:
        if value <= _NOTHING * of_unit[channel.units] < np.inf:
            rows.append((channel.name, _plain(0.0, channel.units), *[""] * (1 + len(swept))))
            continue
        at = results.table("time_of_peak", channel.name).ravel()[case]
        place = np.unravel_index(case, results.shape)
        where = dict(zip((dim.name for dim in results.dims), place, strict=True))
        rows.append(
            (
                channel.name,
                with_prefix(value, channel),
                f"{float(at):.4g} s",
                *(_plain(float(column.values[where[dim]]), column.units) for dim, column in swept),
            )
        )
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]


def with_prefix(value: float, channel: Variable) -> str:
    """A value with four digits and a sensible prefix: 46.38 mm."""
    if channel.units not in _PREFIXED or value == 0:
        return _plain(value, channel.units)
    factor, prefix = next((p for p in _PREFIXES if abs(value) >= 0.9995 * p[0]), _PREFIXES[-1])
    return f"{value / factor:.4g} {prefix}{channel.units}"


def _plain(value: float, units: str) -> str:
    return f"{value:.6g}" if units == "1" else f"{value:.6g} {units}"
