"""Colours and lines by place in a family: told apart by the colour-blind, and in black and white."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import resources
from typing import Any

import matplotlib as mpl

from tbi_cli.report.marks import LIFT_OFF, PEAK

# Okabe and Ito's palette, without its yellow, which is lost on white.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#56B4E9", "#E69F00", "#7F7F7F")
# Lines by lengths of dash and gap, in line widths.
DASHES: tuple[tuple[float, ...], ...] = (
    (),
    (5.0, 1.8),
    (1.2, 1.4),
    (7.0, 1.6, 1.2, 1.6),
    (9.0, 2.5),
    (3.0, 1.4, 1.0, 1.4, 1.0, 1.4),
    (2.6, 1.2),
    (8.0, 1.5, 3.0, 1.5),
    (12.0, 1.6, 1.2, 1.6, 1.2, 1.6),
    (1.2, 3.4),
)
#: Of bands by their depth: the wide one, the narrow one on top of it.
BAND_ALPHAS = (0.16, 0.28)
#: Of single points, by what they tell.
POINTS: Mapping[str, Mapping[str, Any]] = {
    LIFT_OFF: {"marker": "v", "linestyle": "", "markersize": 3.4},
    PEAK: {"marker": "o", "linestyle": "", "markersize": 4.2, "fillstyle": "none", "markeredgewidth": 0.9},
}
MARK, LIMIT = "#6B6B6B", "#9C1C1C"
BEAM_DASHES: dict[str, tuple[float, ...]] = {"": (), "right": (7.0, 3.0), "left": (1.2, 2.4)}


def colour(place: int) -> str:
    """The colour of the curve at a place."""
    return COLOURS[place % len(COLOURS)]


def dashes(place: int) -> tuple[float, ...]:
    """The dashes of the curve at a place; there are more than colours, which so meet others the next time."""
    return DASHES[place % len(DASHES)]


def marker(place: int) -> str:
    """The marker of the curve at a place, for curves of few points."""
    return "osD^v<>p"[place % 8]


@contextmanager
def in_style() -> Iterator[None]:
    """Drawing and saving inside have the look of tbi.mplstyle, whatever the user's matplotlibrc says."""
    style = resources.files("tbi_cli.report").joinpath("tbi.mplstyle")
    with resources.as_file(style) as file, mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(mpl.rc_params_from_file(file, use_default_template=False))
        yield
