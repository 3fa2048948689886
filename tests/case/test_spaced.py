"""The values of a range are the doubles nearest to the decimals that were written, whatever it begins with.

What is compared with is read from texts: `float` of the decimal, or the same key given by itself with a unit.
"""

from __future__ import annotations

import random
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import xarray

from tbi_cli.case import ExtraAxis, load_case
from tests.cli.commands import tbi

from .conftest import CASE, Loads

FORCE = """\
train: {model: axle-forces, positions: [0, 3], forces: [180 kN, 120 kN]}
bridge: {length: 8, modes: 1, right: {youngs_modulus: 34 GPa, second_moment: 0.1, mass_per_length: 9 t/m, damping: {ratio: 1 %}}}
velocity: 20
solver: {method: exact, sampling: 0.05, duration: 1}
"""  # noqa: E501


def velocities(loads: Loads, form: str) -> tuple[float, ...]:
    (axis,) = loads(f"{CASE}sweep:\n  velocity: {form}\n").axes
    return axis.values


def decimal(number: int, places: int) -> str:
    """`number` 10^-places as a text, made of its digits alone."""
    digits = str(number).rjust(places + 1, "0")
    return f"{digits[:-places]}.{digits[-places:]}" if places else digits


@pytest.mark.parametrize("seed", range(12))
def test_values_by_steps_and_by_count_are_decimals(loads: Loads, seed: int) -> None:
    draw = random.Random(seed)
    places, count = draw.randint(1, 5), draw.randint(2, 400)
    first, step = draw.randint(1, 9 * 10**places), draw.randint(1, 3 * 10 ** (places - 1))
    texts = [decimal(first + i * step, places) for i in range(count)]
    ends = f"from: {texts[0]}, to: {texts[-1]}"
    values = tuple(map(float, texts))
    assert velocities(loads, f"{{{ends}, step: {decimal(step, places)}}}") == values
    assert velocities(loads, f"{{{ends}, count: {count}}}") == values
    down = f"{{from: {texts[-1]}, to: {texts[0]}, step: -{decimal(step, places)}}}"
    assert velocities(loads, down) == values[::-1]


@pytest.mark.parametrize("unit", ["km/h", "cm/s", "mph"])
def test_values_with_a_unit_are_those_that_are_read_one_by_one(loads: Loads, unit: str) -> None:
    texts = [f"{decimal(1000 + 37 * i, 1)} {unit}" for i in range(40)]
    ends = f"from: {texts[0]}, to: {texts[-1]}"
    values = velocities(loads, f"[{', '.join(texts)}]")
    assert velocities(loads, f"{{{ends}, step: 3.7 {unit}}}") == values
    assert velocities(loads, f"{{{ends}, count: 40}}") == values
    assert load_case("case.yaml", overrides=[f"velocity={texts[23]}"]).velocity == values[23]


def test_logarithmic_values_are_decimals_where_they_are_meant(loads: Loads) -> None:
    decades = tuple(map(float, ("0.001", "0.01", "0.1", "1", "10", "100", "1000")))
    assert velocities(loads, "{log: {from: 0.001, to: 1000, count: 7}}") == decades
    assert velocities(loads, "{log: {from: 1000, to: 0.001, count: 7}}") == decades[::-1]
    draw = random.Random(3)
    for _ in range(20):
        # The middle of two squares is the product of their roots.
        a, b = draw.randint(11, 99), draw.randint(101, 999)
        form = f"{{log: {{from: {decimal(a * a, 4)}, to: {decimal(b * b, 4)}, count: 3}}}}"
        assert velocities(loads, form)[1] == float(decimal(a * b, 4))


def test_a_refined_range_has_decimals_too(loads: Loads) -> None:
    """Eleven steps of 3.2 m/s, each in as many parts as needed: doubles nearest to the fractions."""
    values = velocities(loads, "{from: 20.3, to: 55.5, step: 3.2, refine: resonance}")
    parts, rest = divmod(len(values) - 1, 11)
    assert rest == 0 and parts % 32 == 0
    exact = (Fraction(203, 10) + Fraction(32, 10) * i / parts for i in range(11 * parts + 1))
    assert values == tuple(float(value) for value in exact)


def test_numbers_of_python_are_their_decimals() -> None:
    extra = ExtraAxis("velocity", start=20, stop=np.float64(28.2), step=0.1)  # type: ignore[arg-type]
    (axis,) = load_case("paper", extra_axis=extra).axes
    assert axis.values == tuple(float(decimal(200 + i, 1)) for i in range(83))


@pytest.mark.parametrize(
    "form",
    [
        "{from: 100 km/h, to: 200 km/h, step: 10 km/h}",
        "{from: 36 km/h, to: 100 km/h, step: 2 m/s}",
        "{from: 10, to: 100 km/h, count: 7}",
        "{log: {from: 50 km/h, to: 100, count: 9}}",
        '{from: "20.30000000000000000001", to: 50, step: 0.1}',
        "{from: 50 km/h, to: 120 km/h, step: 7 km/h, refine: resonance}",
    ],
)
def test_a_resolved_case_has_the_same_values_when_it_is_read_again(loads: Loads, form: str) -> None:
    case = loads(f"{CASE}sweep:\n  velocity: {form}\n")
    again = loads(case.to_yaml())
    assert again == case
    assert again.axes[0].values == case.axes[0].values
    assert again.sha256 == case.sha256
    assert not any("some have none" in warning for warning in again.warnings)


def test_a_unit_of_any_kind_can_stand_in_a_resolved_case(loads: Loads) -> None:
    case = loads(f"{CASE}sweep:\n  bridge.right.second_moment: {{from: 7 in^4, to: 90, count: 4}}\n")
    assert loads(case.to_yaml()) == case


def test_overlapping_sweeps_join_without_twins(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(FORCE)
    tables = []
    for name, first, last in (("a", "20", "30"), ("b", "25", "40")):
        ends = ("--from", first, "--to", last, "--step", "0.1")
        ended = tbi(
            "sweep", "velocity", "case.yaml", *ends, "-j", "1", "-q", "-o", f"{name}.h5", folder=tmp_path
        )
        assert ended.code == 0, ended.err
        with xarray.open_dataset(tmp_path / f"{name}.h5", group="peak", engine="h5netcdf") as data:
            tables.append(data.right_midspan.load())
    low, high = tables
    joined = low.combine_first(high)
    assert joined.sizes == {"velocity": 201}
    for speed in ("20.3", "28.2", "29.9"):
        assert float(low.sel(velocity=float(speed))) == float(joined.sel(velocity=float(speed)))
    shared = low.velocity.values[low.velocity.values >= 25]
    np.testing.assert_array_equal(low.sel(velocity=shared), high.sel(velocity=shared))
