"""Units are converted exactly, once, and only where the dimension fits."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tbi_cli.case.units import UnitError, to_si


@pytest.mark.parametrize(
    ("written", "unit", "value"),
    [
        ("300 km/h", "m/s", 300 / 3.6),
        ("40 t", "kg", 40e3),
        ("207 GPa", "Pa", 207e9),
        ("0.5 %", "1", 0.005),
        ("0.5%", "1", 0.005),
        ("2 ‰", "1", 0.002),
        ("20 t/m", "kg/m", 20e3),
        ("10 kN*s/m^2", "N*s/m^2", 10e3),
        ("10 kN s / m^2", "N*s/m^2", 10e3),
        ("10 kN·s/m²", "N*s/m^2", 10e3),
        ("10 kN*s/m**2", "N*s/m^2", 10e3),
        ("10 kN*s*m^-2", "N*s/m^2", 10e3),
        ("10 kPa*s", "N*s/m^2", 10e3),
        ("40 kN*s/m", "N s/m", 40e3),
        ("260 N/mm", "N/m", 260e3),
        ("1.3 MN/m", "N/m", 1.3e6),
        ("0.2 m^4", "m^4", 0.2),
        ("2e11 mm^4", "m^4", 0.2),
        ("110.2 t*m^2", "kg m^2", 110.2e3),
        ("1 ms", "s", 1e-3),
        ("2 min", "s", 120.0),
        ("1 h", "s", 3600.0),
        ("5 Hz", "1/s", 5.0),
        ("60 mph", "m/s", 26.8224),
        ("12 in", "m", 0.3048),
        ("1 kip", "N", 4448.2216152605),
        ("3 kN/(m*s)", "N/m/s", 3e3),
        ("5", "m", 5.0),
        ("5e3", "m", 5e3),
        ("  5 m ", "m", 5.0),
        ("50 meters", "m", 50.0),
        ("-5 m", "m", -5.0),
        # As engineers type them.
        ("300 kph", "m/s", 300 / 3.6),
        ("300 kmh", "m/s", 300 / 3.6),
        ("300 Km/h", "m/s", 300 / 3.6),
        ("300 km/hr", "m/s", 300 / 3.6),
        ("5 m/sec", "m/s", 5.0),
        ("207e3 N/mm2", "Pa", 207e9),
        ("207e3 N/mm²", "Pa", 207e9),
        ("20700 kN/cm2", "Pa", 207e9),
        ("7e4 cm4", "m^4", 7e-4),
        ("10 kNs/m²", "N*s/m^2", 10e3),
        ("10 kN.s/m2", "N*s/m^2", 10e3),
        ("10 kN·s·m⁻²", "N*s/m^2", 10e3),
        ("40 kNs/m", "N s/m", 40e3),
        ("3 MNm", "N m", 3e6),
        ("3 kNmm", "N m", 3.0),
        ("3 MNm2", "N m^2", 3e6),
        ("110.2 tm2", "kg m^2", 110.2e3),
        ("110.2 kgm^2", "kg m^2", 110.2),
        ("9 m s-2", "m/s^2", 9.0),
        ("25 1/MNm", "1/(N m)", 25e-6),
        ("7 µm", "m", 7e-6),
        ("7 um", "m", 7e-6),
        ("2 dm", "m", 0.2),
        ("180 KN", "N", 180e3),
        ("40 Kg", "kg", 40.0),
        ("40 kgs", "kg", 40.0),
        ("5 kgram", "kg", 5.0),
        ("50 metres", "m", 50.0),
        ("2 tf", "N", 19613.3),
        ("5 kgf", "N", 49.03325),
        ("7 daN", "N", 70.0),
    ],
)
def test_units_convert(written: str, unit: str, value: float) -> None:
    assert to_si(written, unit) == value


@pytest.mark.parametrize(
    ("written", "unit", "reason"),
    [
        ("207 GPx", "Pa", 'no unit "GPx"'),
        ("20 t", "kg/m", '"t" is a mass'),
        ("5 kN", "Pa", '"kN" is a force'),
        ("5 m/s^3", "m/s", '"m/s^3" is something else'),
        ("5 m2", "m", '"m2" is an area'),
        ("5 Ns", "N", '"Ns" is something else'),
        ("5 kNs/m", "N/m", '"kNs/m" is a damping'),
        ("5 Nms", "N", 'no unit "Nms"'),
        ("5 m10", "m", 'no unit "m10"'),
        ("5 rad/s", "Hz", 'no unit "rad/s"'),
        ("18.3 t", "N", '"t" is a mass, 1 t weighs 9.807 kN'),
        ("5 Pas", "Pa", 'no unit "Pas"'),
        ("13 800 kg", "kg", 'no unit "800 kg"'),
        ("1,5 m", "m", 'no unit ",5 m"'),
        ("5 m m/", "m", 'no unit "m m/"'),
        ("5 9**9**9", "m", 'no unit "9**9**9"'),
        ("5 m**9**9**9", "m", 'no unit "m**9**9**9"'),
        ("5 __import__", "m", 'no unit "__import__"'),
        ("5 (((((m)))))", "m", 'no unit "(((((m)))))"'),
        ("5 " + "m*" * 50 + "m", "m", 'no unit "m*m*m*m*m*m*m*m*m*m*m*m*m*m*m*m*m*m*m*m*"'),
        ("1e999 m", "m", "too large"),
        ("1e300 m", "m", "too large or too small"),
        ("1e-300 m", "m", "too large or too small"),
        ("1e-999999999 m", "m", "too small"),
        ("kN", "N", "no number"),
        ("", "m", "no number"),
        ("five m", "m", "no number"),
        ("1_000 m", "m", 'no unit "_000 m"'),
        ("9" * 100 + " m", "m", "no number"),
    ],
)
def test_what_is_no_fitting_unit(written: str, unit: str, reason: str) -> None:
    with pytest.raises(UnitError) as caught:
        to_si(written, unit)
    assert str(caught.value) == reason


@settings(deadline=None)
@given(
    st.decimals(-(10**6), 10**6, places=6),
    st.sampled_from([("t", "kg", 1000), ("km/h", "m/s", Fraction(5, 18))]),
)
def test_conversion_gives_the_nearest_float(number: object, units: tuple[str, str, Fraction]) -> None:
    written, unit, factor = units
    assert to_si(f"{number} {written}", unit) == float(Fraction(str(number)) * factor)
