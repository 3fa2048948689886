"""Words and units in figures: from any file, for any number."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from matplotlib.cbook import is_math_text
from matplotlib.mathtext import MathTextParser

from tbi_cli.report import words
from tbi_cli.report.page import escape
from tbi_cli.store import Dim, Variable


@pytest.mark.parametrize(
    ("units", "largest", "factor", "unit"),
    [
        ("m", 0.0464, 1e-3, "mm"),
        ("m", 5.2e-6, 1e-6, "µm"),
        ("m", 60.0, 1.0, "m"),
        ("N", 3.94e5, 1e3, "kN"),
        ("N", 1.2e6, 1e6, "MN"),
        ("m/s2", 0.84, 1.0, "m/s²"),
        ("m/s2", 0.0048, 1e-3, "mm/s²"),
        ("rad", 2.51e-3, 1e-3, "mrad"),
        ("kg", 80e3, 1e3, "t"),
        ("m/s", 200.0, 1.0, "m/s"),
        ("N s/m^2", 1e4, 1e3, "kN s/m²"),
        ("1", 1.4, 1.0, ""),
        ("m", 0.0, 1.0, "m"),
    ],
)
def test_prefixes(units: str, largest: float, factor: float, unit: str) -> None:
    assert words.scale(units, largest) == words.Scale(factor, unit)


@given(st.floats(1e-8, 1e11), st.sampled_from(["N", "Pa", "N/m", "Hz"]))
def test_a_scaled_number_is_easy_to_read(value: float, units: str) -> None:
    scaled = value / words.scale(units, value).factor
    assert 0.999 <= scaled < 1000.5


@pytest.mark.parametrize(
    ("long_name", "quantity", "body"),
    [
        ("vertical displacement of the car body", "vertical displacement", "car body"),
        ("lateral displacement of the rear bogie, acceleration", "lateral acceleration", "rear bogie"),
        ("pitch of the car body, acceleration", "pitch acceleration", "car body"),
        ("mid-span deflection of the left beam, acceleration", "mid-span acceleration", "left beam"),
        ("force on the car body", "force", "car body"),
        ("force under the front bogie", "force", "front bogie"),
        ("force of the right wheel of axle 1 on its rail", "force", "right wheel of axle 1"),
        ("pitch of the car body, largest of all coaches", "pitch", "car body"),
        ("pitch of the car body, acceleration, coach 12", "pitch acceleration", "car body, coach 12"),
        ("bending moment of the right beam at 10 m", "bending moment", "right beam at 10 m"),
        ("something else", "something else", "something else"),
    ],
)
def test_quantity_and_body_of_a_channel(long_name: str, quantity: str, body: str) -> None:
    variable = Variable("x", "m", long_name)
    assert (words.quantity_of(variable), words.body_of(variable)) == (quantity, body)


def test_a_full_name_says_of_which_coaches() -> None:
    name = "pitch of the car body, acceleration, largest of all coaches"
    full = words.full_name(Variable("x", "rad/s2", name))
    assert full == "pitch acceleration of the car body, largest of all coaches"


def test_a_swept_key_keeps_the_words_of_its_path() -> None:
    dim = Dim("train_secondary_vertical_stiffness", np.array([1.0]), "N/m", "stiffness k; 0 for none")
    path = frozenset({"train.secondary.vertical.stiffness"})
    assert words.axis_words(dim, path) == "secondary vertical stiffness k"
    name = "track_irregularity_dip_depth"
    dip = Dim(name, np.array([1.0]), "m", "its depth, downward")
    assert words.axis_words(dip, frozenset({name.replace("_", ".")})) == "irregularity dip depth, downward"


@settings(deadline=None)
@given(st.text(max_size=80))
@example("\\A")  # a dollar sign behind the backslash would be one to the letter
@example("\\A of $b")
def test_any_text_can_be_drawn(text: str) -> None:
    for made in (words.mathtext(words.clean(text)), words.literal(words.clean(text))):
        # Raises for mathematics that cannot be set.
        MathTextParser("path").parse(made if is_math_text(made) else "", 72)
        assert is_math_text(made) or made == words.literal(words.clean(text))


@settings(deadline=None)
@given(st.text(max_size=80))
def test_no_text_can_open_an_element(text: str) -> None:
    assert not set('<>"') & set(escape(text))
