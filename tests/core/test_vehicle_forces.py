"""Forces on and under vehicles whose ends differ: statics, whatever the integrator does."""

from __future__ import annotations

import pytest

from tbi_cli.case import load_case
from tests.core.crossings import histories

HEAVY = "train.rear_bogie={mass: 6 t}"
ARMS = ("train.geometry.bogie_distance=null", "train.geometry.l_b1=5.5", "train.geometry.l_b2=12")


@pytest.mark.parametrize("contact", ["paper", "hertz"])
@pytest.mark.parametrize(
    ("changes", "front", "rear"),
    [((), 222_687, 222_687), ((HEAVY,), 222_687, 259_180), (ARMS, 297_092, 148_282)],
    ids=["alike", "a heavy rear bogie", "a centre of mass off the middle"],
)
def test_bogies_carry_what_statics_say(
    contact: str, changes: tuple[str, ...], front: float, rear: float
) -> None:
    """At t = 0, before anything has moved: newtons by hand, and what the wheels in the same file say.

    The wheels' forces hold the wheelset besides; what is left is rounding.
    """
    overrides = (
        "train=crh380a",
        "bridge=simply-supported",
        f"contact={{model: {contact}, static_load: physical}}",
        "velocity=50",
        "solver={sampling: 0.01, duration: 0.1}",
        "output.histories=all",
    )
    case = load_case("paper", overrides=(*overrides, *changes))
    h = histories(case)
    found = [h[f"{end}_bogie_force"][0] for end in ("front", "rear")]
    assert found == pytest.approx([front, rear], abs=0.5)
    wheelset = case.train.wheelset.mass * 9.81  # type: ignore[union-attr]
    for axles, force in zip(((1, 2), (3, 4)), found, strict=True):
        wheels = sum(h[f"wheel_{axle}_{side}_force"][0] for axle in axles for side in ("right", "left"))
        assert wheels - 2 * wheelset == pytest.approx(force, rel=1e-13)
