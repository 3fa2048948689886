"""Marks beside curves: where the train leaves, wheels lift off, peaks belong to speeds of resonance."""

from __future__ import annotations

import numpy as np
import pytest

from tbi_cli.report import marks
from tbi_cli.report.plot import Curve
from tbi_cli.report.resonance import _belonging
from tests.core.crossings import paper


def test_the_train_leaves_with_its_last_axle() -> None:
    """(L + d)/v, d = 8.9 + 1.2 + 7.7 + 1.5 m."""
    arms = {"b1": 8.9, "b2": 7.7, "w1": 1.2, "w2": 1.3, "w3": 1.0, "w4": 1.5}
    geometry = [f"train.geometry.l_{arm}={value}" for arm, value in arms.items()]
    totals = ("train.geometry.bogie_distance=null", "train.geometry.wheelbase=null")
    case = paper(*totals, *geometry, "bridge.length=41", "velocity=37")
    (mark,) = marks.leaving(case)
    assert mark.values == ((pytest.approx((41 + 19.3) / 37, rel=1e-14), ""),)


def test_a_wheel_lifts_off_once_for_each_time_in_the_air() -> None:
    """However many samples it stays there; also where the history begins in the air."""
    force = np.array([0.0, 0.0, 7e4, 0.0, 0.0, 0.0, 3e4, 1.0, 0.0, 5e4, 0.0])
    time = 0.3 + 0.01 * np.arange(len(force))
    points = marks.lift_offs(Curve("axle 1", time, force, 0))
    assert points is not None
    assert points.x.tolist() == time[[0, 3, 8, 10]].tolist()
    assert marks.lift_offs(Curve("axle 1", time, force + 1.0, 0)) is None


def test_a_peak_between_two_expected_speeds_belongs_to_the_nearer() -> None:
    """50 m/s lies within a tenth of 48 and of 53: it is found at 48 alone."""
    expected = np.array([48.0, 53.0, 90.0])
    found = np.array([50.0, 70.0, 97.0])
    assert [_belonging(speed, expected, found) for speed in expected] == [50.0, None, 97.0]
