"""Envelopes along a span whose stations are named in any order, on beams that are nearly alike."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from tbi_cli.report.envelopes import envelope_figures
from tbi_cli.report.plot import Panel
from tbi_cli.report.study import open_studies
from tbi_cli.runner import Options, run
from tests.core.crossings import paper

PLACES = [22.0, 4.0, 31.0, 13.0]
LEFT = "{youngs_modulus: 207e9, second_moment: 0.194, mass_per_length: 20e3, damping: 1e4}"


def test_values_stand_where_their_stations_are(tmp_path: Path) -> None:
    """Each curve along the span, at rising places; beams 3 % apart have curves of their own."""
    case = paper(
        f"bridge.left={LEFT}",
        "bridge.length=35",
        f"bridge.stations={PLACES}",
        "sweep={velocity: [90, 61]}",
        "solver={sampling: 0.005, duration: 1}",
    )
    path = run(case, Options(output=tmp_path / "r.h5")).path
    (study,) = open_studies([path])
    (plot,) = envelope_figures(study, {})
    study.results.close()
    with h5py.File(path) as file:
        for panel, quantity in zip(
            plot.panels, ("deflection", "acceleration", "moment", "shear"), strict=True
        ):
            assert isinstance(panel, Panel)
            curves = iter(panel.curves)
            for side in ("right", "left"):
                for table, over in (("max", np.max), ("min", np.min)):
                    curve = next(curves)
                    assert curve.x.tolist() == sorted(PLACES)
                    for x, y in zip(curve.x, curve.y, strict=True):
                        name = f"{side}_station_{PLACES.index(x) + 1}_{quantity}"
                        assert y == over(file[table][name][...])
            assert next(curves, None) is None
