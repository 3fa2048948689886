"""Marks beside curves, from numbers of a train whose front and rear differ."""

from __future__ import annotations

import pytest

from tbi_cli.report import marks
from tests.core.crossings import paper


def test_the_train_leaves_with_its_last_axle() -> None:
    """(L + d)/v, d = 8.9 + 1.2 + 7.7 + 1.5 m."""
    arms = {"b1": 8.9, "b2": 7.7, "w1": 1.2, "w2": 1.3, "w3": 1.0, "w4": 1.5}
    geometry = [f"train.geometry.l_{arm}={value}" for arm, value in arms.items()]
    totals = ("train.geometry.bogie_distance=null", "train.geometry.wheelbase=null")
    case = paper(*totals, *geometry, "bridge.length=41", "velocity=37")
    (mark,) = marks.leaving(case)
    assert mark.values == ((pytest.approx((41 + 19.3) / 37, rel=1e-14), ""),)
