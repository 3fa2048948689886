"""The answers as tables for a terminal, and as JSON."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence

import numpy as np

from identification.search import Certainty, Fit
from identification.targets import Target

_GOOD = 1.1  # answers with a total of up to so many times the best one's count as as good
_STRONG = 0.5  # correlations worth a line
_AT_BOUND = 0.01


def screening(fits: Sequence[Fit], as_published: Fit) -> str:
    """Each discrete combination, the masses of the beams scaled; the best first."""
    lines = [
        "Published vehicle, masses of the beams scaled: total, mu right and left [t/m], discrete unknowns"
    ]
    for fit in fits:
        right, left = fit.values[:2] / 1e3
        lines.append(f"  {fit.total:8.1f}  {right:5.1f} {left:5.1f}  {fit.trials.choice}")
    lines.append(f"  {as_published.total:8.1f}  as built in, nothing fitted")
    return "\n".join(lines) + "\n"


def answers(fits: Sequence[Fit]) -> str:
    """The totals of all starts of one combination."""
    totals = " ".join(f"{fit.total:.1f}" for fit in fits)
    return f"{fits[0].trials.choice}\n  totals from {len(fits)} starts: {totals}\n"


def residuals(targets: Sequence[Target], before: Fit, after: Fit) -> str:
    """Every number: the paper's, the built-in vehicle's, the fitted one's, and both residuals in errors."""
    lines = [f"{'what':62} {'paper':>9} {'error':>8} {'built in':>9} {'fitted':>9} {'residuals':>15}"]
    for k, t in enumerate(targets):
        lines.append(
            f"{t.what + f' [{t.unit}]':62.62} {t.value:9.5g} {t.error:8.2g} {before.ours[k]:9.5g} "
            f"{after.ours[k]:9.5g} {before.residuals[k]:+7.1f} {after.residuals[k]:+7.1f}"
        )
    for name, fit in (("built in", before), ("fitted", after)):
        lines.append(f"{name}: {summary(fit)}")
    closer = int(np.sum(np.abs(after.residuals) < np.abs(before.residuals)))
    lines.append(f"fitted closer than built in: {closer} of {len(targets)}")
    return "\n".join(lines) + "\n"


def summary(fit: Fit) -> str:
    """The misfit in a few numbers."""
    size = np.abs(fit.residuals)
    return (
        f"total {fit.total:.1f}, sum of squares {np.sum(size**2):.0f}, "
        f"median |residual| {np.median(size):.2f}, "
        f"{int(np.sum(size < 1))} of {len(size)} within one error, {int(np.sum(size < 3))} within three"
    )


def parameters(fits: Sequence[Fit], sure: Certainty) -> str:
    """The parameters of the best answer: where, how sure, where other good answers lie; correlations."""
    best = fits[0]
    good = np.array([fit.shares for fit in fits if fit.total <= _GOOD * best.total])
    lines = [
        f"{best.trials.choice}",
        f"{'':11} {'built in':>10} {'fitted':>10} {'from':>9} {'to':>9}  share spread  of {len(good)} best",
    ]
    for k, p in enumerate(best.trials.parameters):
        at = "at bound" if min(best.shares[k], 1 - best.shares[k]) < _AT_BOUND else ""
        lines.append(
            f"{p.symbol:11} {p.published:10.5g} {best.values[k]:10.5g} {p.lower:9.4g} {p.upper:9.4g}  "
            f"{best.shares[k]:5.2f} {sure.spread[k]:6.2f}  "
            f"{good[:, k].min():.2f} .. {good[:, k].max():.2f} {at}".rstrip()
        )
    lines.append("spread: 0 pinned down by the numbers, 1 not at all")
    lines.append("singular values: " + " ".join(f"{value:.3g}" for value in sure.singular))
    symbols = [p.symbol for p in best.trials.parameters]
    pairs = [
        (sure.correlation[i, j], symbols[i], symbols[j])
        for i in range(len(symbols))
        for j in range(i)
        if abs(sure.correlation[i, j]) > _STRONG
    ]
    strong = sorted(pairs, key=lambda pair: -abs(pair[0]))
    lines.append(
        "correlations: " + (", ".join(f"{a} with {b} {r:+.2f}" for r, a, b in strong) or "none strong")
    )
    return "\n".join(lines) + "\n"


def to_json(
    options: argparse.Namespace,
    targets: Sequence[Target],
    as_published: Fit,
    screened: Sequence[Fit],
    found: Sequence[Sequence[Fit]],
    sure: Certainty,
) -> str:
    """Everything, the certainty being that of the best answer of all."""

    def told(fit: Fit) -> dict[str, object]:
        values = {p.symbol: v for p, v in zip(fit.trials.parameters, fit.values.tolist(), strict=True)}
        return {"choice": str(fit.trials.choice), "total": fit.total, "values": values}

    best = min((fits[0] for fits in found), key=lambda fit: fit.total)
    rows = [
        {
            "id": t.id,
            "what": t.what,
            "unit": t.unit,
            "paper": t.value,
            "half_unit": t.half_unit,
            "error": t.error,
            "built_in": float(as_published.ours[k]),
            "fitted": float(best.ours[k]),
        }
        for k, t in enumerate(targets)
    ]
    everything = {
        "options": {key: value for key, value in vars(options).items() if key != "json"},
        "built_in": told(as_published),
        "best": told(best),
        "claims": rows,
        "screening": [told(fit) for fit in screened],
        "searches": [[told(fit) for fit in fits] for fits in found],
        "spread": sure.spread.tolist(),
        "singular_values": sure.singular.tolist(),
        "correlation": sure.correlation.tolist(),
    }
    return json.dumps(everything, indent=1) + "\n"
