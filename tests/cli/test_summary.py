"""The short table that ends a run, against the numbers of the file that it is about."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from tbi_cli.cli.summary import with_prefix
from tbi_cli.store import Variable
from tests.cli.commands import tbi

# Powers of ten of the prefixes of the International System of Units.
POWERS = {"G": 9, "M": 6, "k": 3, "": 0, "m": -3, "µ": -6, "n": -9}


@pytest.mark.parametrize("units", ["m", "m/s2", "N", "rad"])
def test_prefixes(units: str) -> None:
    """Values of every size, from the text back to the number: four digits, 1 to 999.9 before the prefix."""
    for value in np.random.default_rng(3).choice([-1, 1], 400) * np.geomspace(1.1e-9, 8e11, 400):
        text = with_prefix(float(value), Variable("a", units, "a"))
        found = re.fullmatch(rf"(-?[0-9.]+) ([GMkmµn]?){re.escape(units)}", text)
        assert found, text
        assert 1 <= abs(float(found[1])) < 1000
        assert float(found[1]) * 10.0 ** POWERS[found[2]] == pytest.approx(value, rel=6e-4)


def test_the_table_says_what_the_file_holds(tmp_path: Path) -> None:
    """Peak, time and speed of every line, to the digits that are printed."""
    ended = tbi(
        *("run", "paper", "-o", "r.h5", "--set", "sweep.velocity=[61, 47, 83.5]", "--set"),
        *("bridge.left.second_moment=0.13", "--set", "solver.duration=1"),
        folder=tmp_path,
    )
    assert ended.code == 0, ended.err
    lines = [line.split() for line in ended.out.splitlines() if re.match(r"(right|left|car_body)_", line)]
    assert sum(len(line) == 7 for line in lines) >= 5
    with h5py.File(tmp_path / "r.h5") as file:
        for name, value, unit, time, _, speed, _ in (line for line in lines if len(line) == 7):
            peaks = file["peak"][name][...]
            best = int(np.argmax(peaks))
            prefix, base = (unit[0], unit[1:]) if len(unit.split("/")[0]) > 1 else ("", unit)
            assert base == file["peak"][name].attrs["units"]
            assert float(value) * 10.0 ** POWERS[prefix] == pytest.approx(peaks[best], rel=6e-4)
            assert float(time) == pytest.approx(file["time_of_peak"][name][best], rel=6e-4)
            assert float(speed) == file["peak"]["velocity"][best]
