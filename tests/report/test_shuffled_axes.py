"""Axes in any order: all that a report draws and tables of shuffled axes is what it does of sorted ones.

Each study is solved twice, its axes sorted and shuffled, through the command line.  Only the order in which
curves and panels stand beside each other may differ: it is that of the file.  Zipped axes go by the
number of the case, which the order decides; heat maps over it are left out.
"""

from __future__ import annotations

import csv
import io
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import yaml

from tbi_cli.report import claims, make
from tbi_cli.report.bridge_figures import bridge_figures
from tbi_cli.report.catalogue import catalogue
from tbi_cli.report.contact_figures import contact_figures
from tbi_cli.report.ensembles import ensemble_figures, ensemble_table
from tbi_cli.report.envelopes import envelope_figures
from tbi_cli.report.extremes import extremes
from tbi_cli.report.generic_figures import generic_figures
from tbi_cli.report.interactive import interactive
from tbi_cli.report.paper_figures import paper_figure
from tbi_cli.report.paper_tables import paper_tables
from tbi_cli.report.plot import Panel, Plot
from tbi_cli.report.resonance import resonance_table
from tbi_cli.report.study import Study, open_studies
from tbi_cli.report.table import Table
from tbi_cli.report.track_figures import track_figures
from tbi_cli.report.wishes import Wishes
from tests.cli.commands import tbi

SPEEDS = [20, 25, 30, 34, 38, 42, 45, 50, 55, 61, 66, 70, 75, 78, 300 / 3.6, 90, 97, 105, 115, 130, 150]
FEW = [40, 55, 300 / 3.6, 120]
ROUGH = {"random": {"spectrum": "fra-6", "coherence": "independent", "seed": 3}}
FORCES = ["car_body_y", "wheel_1_right_force", "wheel_2_right_force"]
PAPER = {
    "train": "paper",
    "bridge": "paper",
    "contact": {"model": "paper", "static_load": "paper"},
    "velocity": "300 km/h",
    "solver": {"sampling": 0.001, "substeps": 1, "duration": 1},
    "studies": {
        "masses": {"sweep": {"car_body_mass": ["20 t", "40 t", "60 t"], "velocity": SPEEDS}},
        "spans": {"sweep": {"span": [30, 40, 50], "velocity": SPEEDS}},
        "damping": {"sweep": {"damping": [1e3, 5e3, 1e4], "velocity": SPEEDS}},
        "modes": {"sweep": {"modes": [1, 2, 3, 4]}, "output.histories": "all"},
        "sampling": {"sweep": {"velocity": FEW, "sampling": [0.001, 0.005, 0.01]}, "output.histories": "all"},
        "multiples": {
            "sweep": {"modes": [1, 2, 4], "car_body_mass": ["20 t", "40 t", "60 t"], "velocity": FEW},
            "solver.sampling": 0.01,
            "solver.substeps": 10,
        },
        "drawn": {
            "sweep": {
                "velocity": FEW,
                "sample": {"kind": "sobol", "count": 4, "over": {"bridge.length": {"uniform": [30, 50]}}},
            }
        },
        "ensemble": {
            "contact": {"model": "hertz", "static_load": "physical"},
            "track": {"irregularity": ROUGH},
            "solver.sampling": 0.002,
            "solver.substeps": "auto",
            "sweep": {"seed": [1, 2, 3, 5], "velocity": [300 / 3.6, 95, 110]},
            "output.histories": {"channels": FORCES},
        },
        "contact": {
            "contact": {"model": "hertz", "static_load": "physical"},
            "track": {"irregularity": ROUGH},
            "solver.sampling": 0.002,
            "solver.substeps": "auto",
            "sweep": {"velocity": [300 / 3.6, 95, 110]},
            "output.histories": {"channels": FORCES},
        },
    },
}
BRIDGE = {
    "train": {"model": "hslm-a", "number": 4},
    "bridge": {
        "length": 25,
        "modes": 3,
        "low_pass": "en-1990",
        "stations": [10, 4, 20],
        "right": {"youngs_modulus": "35 GPa", "second_moment": 1.6, "mass_per_length": "20 t/m"}
        | {"damping": {"ratio": "1 %"}},
    },
    "velocity": 90,
    "solver": {"method": "exact", "duration": 1.05},
    "studies": {
        "trains": {
            "sweep": {
                "train.number": [2, 4, 9],
                "span": [20, 25, 30],
                "bridge.right.second_moment": [1.1, 1.6, 2.3],
                "zip": ["span", "bridge.right.second_moment"],
                "velocity": [60, 66, 70, 75, 80, 85, 90, 95, 100],
            },
            "output.histories": {"channels": ["right_station_1_deflection"]},
        },
        "one": {"sweep": {"velocity": [60, 70, 80, 90, 100]}},
    },
}


def shuffled(case: dict[str, Any]) -> dict[str, Any]:
    """The case with the values of every listed axis in another order, neither rising nor falling."""
    draw = random.Random(7)
    studies: dict[str, Any] = {}
    for name, study in case["studies"].items():
        sweep = dict(study["sweep"])
        together = sweep.get("zip", [])
        orders: dict[int, list[int]] = {}
        for key, values in sweep.items():
            if key == "zip" or not isinstance(values, list):
                continue
            order = list(range(len(values)))
            while order in (sorted(order), sorted(order, reverse=True)):
                draw.shuffle(order)
            if key in together:
                order = orders.setdefault(0, order)
            sweep[key] = [values[k] for k in order]
            assert sweep[key] != values
        studies[name] = {**study, "sweep": sweep}
    return case | {"studies": studies}


@pytest.fixture(scope="module", params=["paper", "bridge"])
def both(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[Any]]:
    """The studies of a case with sorted axes, and those with shuffled ones."""
    case = {"paper": PAPER, "bridge": BRIDGE}[request.param]
    opened = []
    for name, written in (("sorted", case), ("shuffled", shuffled(case))):
        folder = tmp_path_factory.mktemp(name)
        (folder / "case.yaml").write_text(yaml.safe_dump(written, sort_keys=False))
        ended = tbi("run", "case.yaml", "-q", "-o", "r.h5", folder=folder, patience=300)
        assert ended.code == 0, ended.err
        opened.append(open_studies([folder / "r.h5"]))
    yield opened
    for study in (*opened[0], *opened[1]):
        study.results.close()


def of_all_studies(studies: list[Study]) -> Iterator[Plot]:
    """Every figure that a report can make of these studies."""
    for spec in catalogue():
        if found := paper_figure(spec, studies, {}):
            yield found[0]
    wishes = [
        Wishes(),
        Wishes(heat_map=True),
        Wishes(x="time"),
        Wishes(channels=("*_midspan",), x="velocity"),
    ]
    for study in studies:
        yield from track_figures(study, {})
        yield from contact_figures(study, {})
        yield from bridge_figures(study, {})
        yield from envelope_figures(study, {})
        for wish in wishes:
            if not (wish.heat_map and study.axis("span_and_bridge_right_second_moment")):
                yield from generic_figures(study, wish, {})
            yield from ensemble_figures(study, wish, {})
        if study.axis("car_body_mass"):
            place = Wishes(select=("car_body_mass=60 t",)).selection([study])[study.name]
            yield from generic_figures(study, Wishes(), place)


def of_panel(panel: Any) -> dict[str, Any]:
    """A panel by its words; what belongs to a curve by that curve's label."""
    if not isinstance(panel, Panel):
        return {**vars(panel), "lines": {line.label: (line.x, line.y) for line in panel.lines}}
    owner = dict(enumerate(curve.label for curve in panel.curves)) | {None: ""}
    owner = {curve.place: curve.label for curve in panel.curves} | owner
    return vars(panel) | {
        "curves": {curve.label: (curve.x, curve.y) for curve in panel.curves},
        "marks": {(mark.label, owner[mark.place], mark.values): True for mark in panel.marks},
        "points": {(points.label, owner[points.place]): (points.x, points.y) for points in panel.points},
        "bands": {band.label: (band.x, band.low, band.high) for band in panel.bands},
    }


def name_of(panel: Any) -> str:
    """What tells a panel from the others of its figure."""
    return f"{panel.title}: {panel.y.label}"


def of_page(plot: Plot) -> dict[str, Any] | None:
    """What the page draws interactively: the numbers by panel and curve, without looks and order."""
    figure = interactive(plot)
    if figure is None:
        return None
    found = {}
    for trace in figure["data"]:
        panel = plot.panels[int(trace["xaxis"][1:] or 1) - 1]
        name = trace["name"].partition(") ")[2] if trace["name"][:1] == "(" else trace["name"]
        if trace["mode"] != "markers":  # points of curves, compared by their panel
            found[name_of(panel), name, trace.get("fill")] = (trace["x"], trace["y"])
    return found


def data_of(plot: Plot) -> dict[str, Any]:
    """All that a figure says, by words."""
    panels = {name_of(panel): of_panel(panel) for panel in plot.panels}
    assert len(panels) == len(plot.panels)
    return {**vars(plot), "panels": panels, "page": of_page(plot)}


def assert_same(found: Any, wanted: Any, where: str) -> None:
    """Equal to the bit, mappings whatever the order of their keys."""
    if isinstance(wanted, dict):
        assert found.keys() == wanted.keys(), where
        for key in wanted:
            assert_same(found[key], wanted[key], f"{where} / {key}")
    elif isinstance(wanted, np.ndarray):
        np.testing.assert_array_equal(found, wanted, err_msg=where)
    elif isinstance(wanted, tuple | list) and any(isinstance(item, np.ndarray) for item in wanted):
        for one, other in zip(found, wanted, strict=True):
            assert_same(one, other, where)
    else:
        assert found == wanted, where


def test_figures_and_the_page(both: list[list[Study]]) -> None:
    wanted, found = ([data_of(plot) for plot in of_all_studies(studies)] for studies in both)
    assert [plot["name"] for plot in found] == [plot["name"] for plot in wanted]
    for one, other in zip(found, wanted, strict=True):
        assert_same(one, other, str(other["name"]))
    kinds = {plot["name"].removeprefix("r-").partition("-")[2] for plot in wanted}
    some = {"deck-acceleration", "resonance-acceleration", "envelopes", "time-stations", "deck"}
    if both[0][0].name == "r-masses":
        some = {"track", "lift-off", "wheel-forces", "heat-midspan", "ensemble-midspan", "ensemble-contact"}
        some |= {"ensemble-time-car_body_y", "midspan", "acceleration", "midspan-right_midspan"}
        drawn = {plot["name"] for plot in wanted}
        assert {"fig9", "fig15", "fig22"} & drawn
    assert some <= kinds, kinds


def rows(table: Table) -> list[list[str]]:
    """The table as its file has it, but for the time that a run took and the number of a zipped case."""
    read = list(csv.reader(io.StringIO(table.to_csv())))
    own = [k for k, head in enumerate(read[0]) if head.startswith("solution time") or "_and_" in head]
    return [[cell for k, cell in enumerate(row) if k not in own] for row in read]


def test_tables(both: list[list[Study]]) -> None:
    made: list[dict[str, list[list[str]]]] = []
    for studies in both:
        tables = [table for table, _ in paper_tables(studies).values()]
        for study in studies:
            some = (extremes(study), ensemble_table(study), resonance_table(study, {}))
            tables += [table for table in some if table is not None]
        made.append({table.name: rows(table) for table in tables})
        entries = [entry for entry in claims.entries(studies) if "seconds" not in entry.id]
        made[-1]["claims"] = [[entry.id, str(entry.ours), str(entry.holds)] for entry in entries]
    wanted, found = made
    assert found.keys() == wanted.keys()
    of_paper = {"table2", "table3", "table4", "table5", "ensemble-r-ensemble"}
    assert wanted.keys() >= (of_paper if both[0][0].name == "r-masses" else {"resonance-r-trains"})
    for name in wanted:
        if "trains" in name:  # rows in the order of zipped cases
            assert sorted(found[name]) == sorted(wanted[name]), name
        else:
            assert found[name] == wanted[name], name


def test_a_place_is_found_by_its_values(both: list[list[Study]], tmp_path: Path) -> None:
    """Numbers, status and histories at a place are those of the file at its values, as h5py reads them."""
    for study in both[1]:
        if study.name not in ("r-sampling", "r-trains"):
            continue
        path = tmp_path / "r.h5"
        path.write_bytes(study.results.path.read_bytes())
        group = study.name.removeprefix("r-")
        channel = "right_station_1_deflection" if "trains" in study.name else "right_midspan"
        with h5py.File(path, "r+") as file:
            here = file["studies"][group] if "studies" in file else file[group]
            values = [here[axis.name][()] for axis in study.axes]
            here["status"][tuple(len(one) - 1 for one in values)] = 0
            at = [len(one) // 2 for one in values]
            peak = here["peak/right_midspan"][tuple(at)]
            flat = np.ravel_multi_index(at, [len(one) for one in values])
            history = here[f"histories/{flat}/{channel}"][()]
        (again,) = (one for one in open_studies([path]) if one.name == study.name)
        lacks = [axis.nearest(one[-1]) for axis, one in zip(again.axes, values, strict=True)]
        assert np.argwhere(again.status == 0).tolist() == [lacks]
        place = {axis.name: axis.nearest(one[k]) for axis, one, k in zip(again.axes, values, at, strict=True)}
        assert float(again.along("peak", "right_midspan", [], place)) == peak
        found = again.history(place, [channel])
        assert found is not None
        np.testing.assert_array_equal(found.values[0], history)
        again.results.close()


def test_no_function_of_a_report_is_forgotten() -> None:
    """What `make` draws and tables with is what this module tries."""
    ends = ("figures", "figure", "table", "tables", "extremes")
    used = {name for name, value in vars(make).items() if callable(value) and name.endswith(ends)}
    assert {name for name in used if not name.startswith("_")} <= set(globals())


def test_the_resonance_is_found_where_it_is(tmp_path: Path) -> None:
    """HSLM-A4 on 25 m, at five speeds in any order: 17.63 mm and 10.41 m/s2 at 90 m/s."""
    case = {key: value for key, value in BRIDGE.items() if key != "studies"}
    case["bridge"] = {k: v for k, v in BRIDGE["bridge"].items() if k not in ("low_pass", "stations", "modes")}  # type: ignore[attr-defined]
    case["sweep"] = {"velocity": [100, 60, 80, 70, 90]}
    (tmp_path / "case.yaml").write_text(yaml.safe_dump(case))
    assert tbi("run", "case.yaml", "-q", "-o", "r.h5", folder=tmp_path).code == 0
    shown = tbi("info", "r.h5", folder=tmp_path).out
    assert "velocity: 5 values, 60 to 100 m/s" in shown
    assert "velocity: 5 values, 60 to 100 m/s" in tbi("validate", "case.yaml", folder=tmp_path).out
    assert tbi("report", "r.h5", "-o", "report", "--channels", "right_midspan", folder=tmp_path).code == 0
    with (tmp_path / "report" / "resonance-r.csv").open(newline="") as file:
        peaks = [
            (row["deflection peaks at [m/s]"], row["acceleration peaks at [m/s]"])
            for row in csv.DictReader(file)
        ]
    assert {cell for row in peaks for cell in row if cell} == {"90"}
    with (tmp_path / "report" / "extremes-r.csv").open(newline="") as file:
        largest = {row["channel"]: float(row["largest"]) for row in csv.DictReader(file)}
    # As the digits of the numbers go.
    assert largest["right_midspan"] == pytest.approx(17.63e-3, abs=0.005e-3)
    assert largest["right_midspan_acceleration"] == pytest.approx(10.41, abs=0.005)
