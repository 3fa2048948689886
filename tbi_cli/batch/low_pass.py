"""Digital low-pass filters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# Quality factors of the two pairs of poles of Butterworth's filter of fourth order.
_QUALITIES = (1 / (2 * np.cos(np.pi / 8)), 1 / (2 * np.cos(3 * np.pi / 8)))


def low_pass_filters(cut_off: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coefficients of Butterworth filters of fourth order for samples: two biquads each.

    cut_off (filters, scenarios) is where they let pass 1/sqrt(2), times the sampling interval: below 1/2.
    Returns rows b0, b1, b2, a1, a2 of each filter and biquad, (10 filters, scenarios): the bilinear transform
    of the analogue filter, its cut-off kept.
    """
    rows = []
    for k in np.tan(np.pi * np.asarray(cut_off)):
        for quality in _QUALITIES:
            scale = 1 / (1 + k / quality + k * k)
            b0 = k * k * scale
            rows += [b0, 2 * b0, b0, 2 * (k * k - 1) * scale, (1 - k / quality + k * k) * scale]
    return np.array(rows)
