"""Several studies as one run, in one file: the same as each of them alone."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import h5py
import pytest
import xarray

from tbi_cli.case import Case, load_case
from tbi_cli.runner import Options, Silence, run
from tbi_cli.store import StoreError, open_results, studies_of
from tbi_cli.workers import Workers
from tests.cli.commands import everything_below, tbi

CASE = """\
title: Three studies
train: paper
bridge: paper
contact: {model: paper, static_load: paper}
solver: {sampling: 0.01, substeps: 10, duration: 1}
output: {file: results.h5}
studies:
  masses:
    sweep: {car_body_mass: [20 t, 40 t], velocity: [50, 60, 70]}
  spans:
    title: Spans
    velocity: 50
    bridge.modes: 2
    sweep: {span: [30 m, 40 m]}
    output.histories: {channels: [car_body_y]}
  beam:
    train: {model: moving-load, forces: [100 kN], positions: [0]}
    bridge: {left: null}
    contact: {static_load: physical}
    velocity: 60
"""
ALONE = Workers(jobs=1)  # batch after batch, so that a stop leaves some
NAMES = ("masses", "spans", "beam")


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    path = tmp_path_factory.mktemp("case") / "case.yaml"
    path.write_text(CASE, encoding="utf-8")
    return load_case(path)


@pytest.fixture(scope="module")
def file(case: Case, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("together") / "results.h5"
    assert run(case, Options(output=path)).solved == 6 + 2 + 1
    return path


def contents(group: h5py.Group) -> Iterator[tuple[str, bytes]]:
    """Every dataset below a group, by its path in it, and its bytes."""
    found: dict[str, bytes] = {}
    group.visititems(
        lambda name, item: (
            found.update({name: item[...].tobytes()})
            if isinstance(item, h5py.Dataset) and item.dtype.kind == "f"
            else None
        )
    )
    yield from found.items()


@pytest.mark.parametrize("name", NAMES)
def test_a_study_has_the_bits_of_a_file_of_its_own(case: Case, file: Path, name: str, tmp_path: Path) -> None:
    run(case.studies[name], Options(output=tmp_path / "alone.h5"))
    with h5py.File(file) as together, h5py.File(tmp_path / "alone.h5") as alone:
        assert dict(contents(together[name])) == dict(contents(alone))
        assert set(together[name]) == set(alone)
        for attribute in ("case", "case_sha256", "dimensions", "channels", "case_steps", "format"):
            assert together[name].attrs[attribute] == alone.attrs[attribute]


def test_a_study_loads_as_the_case_that_its_group_holds(case: Case, file: Path, tmp_path: Path) -> None:
    assert studies_of(file) == NAMES == tuple(case.studies)
    for name in NAMES:
        with open_results(file, study=name) as results:
            (tmp_path / "case.yaml").write_text(results.case_yaml, encoding="utf-8")
        assert load_case(tmp_path / "case.yaml") == case.studies[name]


def test_xarray_opens_a_group(file: Path) -> None:
    peak = xarray.open_dataset(file, group="masses/peak", engine="h5netcdf")
    assert dict(peak.sizes) == {"car_body_mass": 2, "velocity": 3}
    assert peak.velocity.values.tolist() == [50, 60, 70]
    assert peak.right_midspan.attrs["units"] == "m"


def test_one_of_several_studies_has_to_be_named(file: Path) -> None:
    with pytest.raises(
        StoreError, match=r"holds several studies, of which one is to be named: masses spans beam"
    ):
        open_results(file)
    with pytest.raises(StoreError, match="holds no study spam"):
        open_results(file, study="spam")


class StopAfter(Silence):
    """Sets an event once so many batches are on disk."""

    def __init__(self, batches: int) -> None:
        self.event, self._left = threading.Event(), batches

    def advance(self, scenarios: int, steps: int) -> None:
        self._left -= 1
        if not self._left:
            self.event.set()


@pytest.mark.parametrize("batches", [1, 2])
def test_a_stopped_run_is_readable_and_resumed(case: Case, file: Path, tmp_path: Path, batches: int) -> None:
    path = tmp_path / "results.h5"
    stop = StopAfter(batches)
    summary = run(case, Options(output=path, workers=ALONE), progress=stop, stop=stop.event)
    assert summary.left > 0
    assert not path.exists()
    assert studies_of(path) == NAMES
    done = 0
    for name in NAMES:
        with open_results(path, study=name) as results:
            done += int((results.status == 1).sum())
    assert done == summary.solved
    with pytest.raises(StoreError, match="holds an unfinished run"):
        run(case, Options(output=path))
    again = run(case, Options(output=path, resume=True))
    assert (again.before, again.left) == (done, 0)
    assert [p.name for p in tmp_path.iterdir()] == ["results.h5"]
    with h5py.File(path) as one, h5py.File(file) as other:
        assert dict(contents(one)) == dict(contents(other))


def test_a_finished_file_has_nothing_to_resume(case: Case, tmp_path: Path) -> None:
    path = tmp_path / "results.h5"
    run(case, Options(output=path))
    before = everything_below(tmp_path)
    summary = run(case, Options(output=path, resume=True))
    assert (summary.solved, summary.before) == (0, 9)
    assert everything_below(tmp_path) == before


def test_another_case_is_not_mixed_in(case: Case, file: Path, tmp_path: Path) -> None:
    path = tmp_path / "results.h5"
    path.write_bytes(file.read_bytes())
    with pytest.raises(StoreError, match="holds several studies"):
        run(case.studies["beam"], Options(output=path, resume=True))
    (tmp_path / "case.yaml").write_text(CASE.replace("[30 m, 40 m]", "[30 m, 50 m]"), encoding="utf-8")
    with pytest.raises(StoreError, match=r"holds another case \(studies.spans.sweep.span"):
        run(load_case(tmp_path / "case.yaml"), Options(output=path, resume=True))
    assert path.read_bytes() == file.read_bytes()


def test_a_file_of_one_grid_is_replaced_by_studies_and_back(case: Case, tmp_path: Path) -> None:
    path = tmp_path / "results.h5"
    for one in (case.studies["beam"], case, case.studies["beam"]):
        run(one, Options(output=path, overwrite=True))
        assert studies_of(path) == tuple(one.studies)
        assert [p.name for p in tmp_path.iterdir()] == ["results.h5"]


@pytest.mark.parametrize("first", ["union", "alone"])
def test_what_a_stopped_run_left_goes_with_overwrite(case: Case, tmp_path: Path, first: str) -> None:
    path = tmp_path / "results.h5"
    single = load_case("paper", overrides=["sweep.velocity=[50, 55, 60]", "sweep.modes=[1, 2]"])
    old, new = (case, single) if first == "union" else (single, case)
    stop = StopAfter(1)
    assert run(old, Options(output=path, workers=ALONE), progress=stop, stop=stop.event).left
    for options in (Options(output=path), Options(output=path, resume=True)):
        with pytest.raises(StoreError, match=r"unfinished run|another case"):
            run(new, options)
    run(new, Options(output=path, overwrite=True))
    assert [p.name for p in tmp_path.iterdir()] == ["results.h5"]
    assert studies_of(path) == tuple(new.studies)


def test_the_commands(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(CASE, encoding="utf-8")
    told = tbi("validate", "case.yaml", folder=tmp_path)
    assert "study      spans" in told.out
    assert "scenarios  9" in told.out
    ran = tbi("run", "case.yaml", folder=tmp_path)
    assert ran.code == 0, ran.err
    assert "9 scenarios solved" in ran.out
    told = tbi("status", "results.h5", folder=tmp_path)
    assert "study      spans\nscenarios  2: 2 done, 0 failed, 0 missing\n" in told.out
    assert tbi("status", "case.yaml", folder=tmp_path).out == told.out
    shown = tbi("info", "results.h5", folder=tmp_path)
    assert all(f"study          {name}" in shown.out for name in NAMES)
    assert tbi("info", "results.h5", "--diff", "results.h5", folder=tmp_path).out.startswith("the same case")
    assert "tables/spans/peak.csv" in tbi("export", "results.h5", folder=tmp_path).out
    assert tbi("sweep", "velocity", "case.yaml", folder=tmp_path).code == 2
    reported = tbi("report", "results.h5", "--formats", "png", folder=tmp_path)
    assert reported.code == 0, reported.err
    assert "fig19" in reported.out
