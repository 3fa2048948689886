"""Several studies, one of them refined, in one run that is cut into shards, stopped, joined and resumed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np
import pytest

from tbi_cli.case import Case, load_case
from tbi_cli.cluster.joining import join_shards
from tbi_cli.cluster.status import run_status
from tbi_cli.cluster.status_text import status_lines
from tbi_cli.rounds import Rounds
from tbi_cli.runner import Options, run
from tbi_cli.shards import Shard
from tbi_cli.solve import Solver
from tbi_cli.store import StoreError, merge, studies_of
from tbi_cli.studies import solver_of
from tbi_cli.workers import Workers
from tests.cluster.runs import CASE, content, inside
from tests.studies.test_campaigns import StopAfter

STUDIES = """\
title: Masses, and speeds that are refined
train: trains/paper.yaml
bridge: bridges/paper.yaml
velocity: 180 m/s
solver: {sampling: 0.002, substeps: 2, duration: 1}
output: {file: results.h5}
studies:
  masses:
    sweep: {train.car_body.mass: [20 t, 40 t, 60 t], velocity: {from: 20, to: 192, step: 8}}
    output.histories: {channels: [right_midspan, car_body_y], every: 0.01}
  speeds:
    bridge.modes: 2
    sweep: {bridge.modes: [2, 3], velocity: {from: 20, to: 116, step: 8, refine: resonance}}
  one: {}
"""
NAMES = ("masses", "speeds", "one")


@pytest.fixture(scope="module")
def studies(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """The case of several studies."""
    path = tmp_path_factory.mktemp("case") / "case.yaml"
    path.write_text(STUDIES)
    return load_case(path)


@pytest.fixture(scope="module")
def together(studies: Case, tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, bytes]:
    """What an undisturbed run gives."""
    path = tmp_path_factory.mktemp("together") / "results.h5"
    run(studies, Options(output=path))
    return content(path)


def solve(case: Case, folder: Path, of: int, *numbers: int) -> list[Path]:
    """Some shards of a case, solved."""
    paths = [Shard(number, of).path(folder / "results.h5") for number in numbers]
    for number, path in zip(numbers, paths, strict=True):
        run(case, Options(output=path, shard=Shard(number, of)))
    return paths


def test_a_study_is_refined_as_it_is_alone(
    studies: Case, together: Mapping[str, bytes], tmp_path: Path
) -> None:
    run(studies.studies["speeds"], Options(output=tmp_path / "alone.h5"))
    alone = content(tmp_path / "alone.h5")
    assert {f"speeds/{name}": value for name, value in alone.items()} == {
        name: value for name, value in together.items() if name.startswith("speeds/")
    }
    steps, possible = 13, 1 + 12 * 32
    assert steps < len(np.frombuffer(alone["velocity"])) < possible / 2


@pytest.mark.parametrize("of", [1, 3, 7])
def test_shards_joined_are_the_whole(
    studies: Case, together: Mapping[str, bytes], tmp_path: Path, of: int
) -> None:
    paths = solve(studies, tmp_path, of, *range(1, of + 1))
    assert all(studies_of(path) == NAMES for path in paths)
    merge(paths[::-1], tmp_path / "results.h5")
    assert content(tmp_path / "results.h5") == together
    with h5py.File(tmp_path / "results.h5") as file:
        assert file.attrs["case_sha256"] == studies.sha256
        assert not any("shard" in group.attrs for group in (file, *(file[name] for name in NAMES)))


def test_the_cost_of_all_studies_together_is_balanced(tmp_path: Path) -> None:
    """The studies are dealt as one grid: shard by shard, however unlike the studies are."""
    path = tmp_path / "case.yaml"
    path.write_text(STUDIES.replace(", refine: resonance", ""))
    solver = solver_of(load_case(path))
    steps = []
    for part in solver.parts.values():
        assert isinstance(part, Solver)
        grids = [part.scenarios.crosser(index).grid for index in range(len(part.scenarios))]
        steps += [grid.steps for grid in grids]
    owners = np.array([Rounds(solver, Shard(number, 4)).own for number in range(1, 5)])
    assert (owners.sum(axis=0) == 1).all()
    loads = owners @ np.array(steps)
    # Whoever has most is ahead of who has least by a bundle that was dealt late: some tenth of a shard.
    assert loads.max() < 1.1 * loads.mean()


def test_what_is_missing_is_refused_or_left_to_a_later_run(
    studies: Case, together: Mapping[str, bytes], tmp_path: Path
) -> None:
    paths = solve(studies, tmp_path, 3, 1, 3)
    with pytest.raises(StoreError, match=r"^missing shards: 2/3; --partial leaves their cases to be done$"):
        merge(paths, tmp_path / "results.h5")
    lines = join_shards(paths, tmp_path / "results.h5", partial=True, overwrite=False)
    assert lines[0].startswith("2 shards joined, ")
    assert lines[0].endswith(" to do")
    summary = run(studies, Options(output=tmp_path / "results.h5", resume=True))
    assert summary.solved > 0
    assert content(tmp_path / "results.h5") == together


@pytest.mark.parametrize("study", ["masses", "speeds"])
def test_shards_of_another_case(studies: Case, tmp_path: Path, study: str) -> None:
    """The message names the study's key that differs."""
    path = tmp_path / "case.yaml"
    path.write_text(STUDIES.replace(f"  {study}:\n", f"  {study}:\n    gravity: 9\n"))
    first = solve(studies, tmp_path, 2, 1)[0]
    second = solve(load_case(path), tmp_path, 2, 2)[0]
    with pytest.raises(StoreError) as caught:
        merge([first, second], tmp_path / "results.h5")
    assert str(caught.value).startswith(
        f"{second}: holds another case (studies.{study}.gravity: 9.0, now 9.81); {first} sets the measure"
    )
    path.write_text(CASE)
    run(load_case(path), Options(output=tmp_path / "grid.h5", shard=Shard(2, 2)))
    with pytest.raises(StoreError) as caught:
        merge([first, tmp_path / "grid.h5"], tmp_path / "results.h5")
    assert str(caught.value) == f"{tmp_path / 'grid.h5'}: holds one grid, {first} several studies"


@pytest.mark.parametrize("batches", [1, 20])
def test_a_shard_is_stopped_and_resumed(
    studies: Case, together: Mapping[str, bytes], tmp_path: Path, batches: int
) -> None:
    stop = StopAfter(batches)
    one = Workers(jobs=1)
    shard, other = (Shard(number, 2) for number in (1, 2))
    path = shard.path(tmp_path / "results.h5")
    left = run(studies, Options(path, one, shard), progress=stop, stop=stop.event).left
    assert left > 0
    told = run_status([path], studies)
    assert [file.state for file in told.files] == ["stopped", "not begun"]
    assert told.files[0].done > 0
    assert told.growing
    again = run(studies, Options(path, one, shard, resume=True))
    assert again.before == told.files[0].done
    run(studies, Options(other.path(tmp_path / "results.h5"), one, other))
    merge([path, other.path(tmp_path / "results.h5")], tmp_path / "results.h5")
    assert content(tmp_path / "results.h5") == together


def test_a_failed_scenario_of_a_refined_sweep_is_solved_again(tmp_path: Path) -> None:
    """Though the finished file has other speeds than the run that made it looked at."""
    (tmp_path / "case.yaml").write_text(STUDIES)
    case = load_case(tmp_path / "case.yaml").studies["speeds"]
    path = tmp_path / "results.h5"
    run(case, Options(output=path))
    whole = content(path)
    with h5py.File(path, "r+") as file:
        for place in ((0, 3), (1, 5)):
            file["status"][place], file["message"][place] = 2, "the state was no longer finite"
            file["peak/car_body_y"][place] = np.nan
    summary = run(case, Options(output=path, resume=True))
    assert (summary.solved, summary.failed, summary.left) == (2, 0, 0)
    assert content(path) == whole
    before = path.read_bytes()
    assert run(case, Options(output=path, resume=True)).solved == 0
    assert path.read_bytes() == before


def test_status_of_studies_and_of_shards_beside_the_case(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(STUDIES)
    begun = inside("status", "case.yaml", folder=tmp_path)
    assert "study      masses\nscenarios  66: 0 done, 0 failed, 66 missing\n" in begun.out
    assert "all studies\nscenarios  at least " in begun.out
    assert f"{tmp_path / 'results.h5'}: not begun, 0 of " in begun.out
    for number in (1, 2, 3):
        arguments = ("run", "case.yaml", "--shard", f"{number}/3", "-q")
        assert inside(*arguments, folder=tmp_path).code == 0
        by_case, by_name = (inside("status", word, folder=tmp_path) for word in ("case.yaml", "results.h5"))
        assert (by_case.code, by_case.out) == (0, by_name.out)
        assert f"shard {number}/3: finished" in by_case.out
    assert "shards     3: 3 finished\n" in by_case.out
    assert "study      one\nscenarios  1: 1 done, 0 failed, 0 missing\n" in by_case.out
    assert "at least" not in by_case.out
    assert "time left" not in by_case.out
    status = run_status([tmp_path / "results.h5"])
    assert status.done == sum(study.done for study in status.studies.values())
    assert "\n".join(status_lines(status)) + "\n" == by_case.out


def test_an_array_of_studies_is_cut_like_any_other(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(STUDIES)
    ended = inside("submit", "case.yaml", "--shards", "3", "--dry-run", folder=tmp_path)
    assert ended.code == 0, ended.err
    assert '--shard "$SLURM_ARRAY_TASK_ID/3" --resume --requeue\n' in ended.out


def left_unfinished(case: Case, path: Path) -> dict[str, bytes]:
    """A run that is stopped after its first batch, and what it leaves."""
    stop = StopAfter(1)
    assert run(case, Options(path, Workers(jobs=1)), progress=stop, stop=stop.event).left > 0
    return {
        str(file.relative_to(path.parent)): file.read_bytes() for file in path.parent.rglob("*.h5*/**/*.h5")
    }


@pytest.mark.parametrize("what", ["studies", "grid"])
def test_a_refused_run_takes_nothing_away(studies: Case, case: Case, tmp_path: Path, what: str) -> None:
    """Whatever is asked for in place of an unfinished run: its batches stay."""
    path = tmp_path / "results.h5"
    (tmp_path / "case.yaml").write_text(STUDIES.replace("180 m/s", "170 m/s"))
    other = load_case(tmp_path / "case.yaml")
    begun, foreign = (studies, case) if what == "studies" else (case, studies)
    before = left_unfinished(begun, path)
    assert len(before) == 1
    for options, one in (
        (Options(path), begun),
        (Options(path), foreign),
        (Options(path, resume=True), foreign),
        (Options(path, resume=True), other),
        (Options(path, shard=Shard(1, 2), resume=True), begun),
    ):
        with pytest.raises(StoreError) as caught:
            run(one, options)
        assert str(caught.value).startswith(f"{path}.parts: ")
        if not options.resume:
            continued = "Options(resume=True) continues it, Options(overwrite=True) starts afresh"
            another = "choose another file with Options(output=...)"
            assert str(caught.value).endswith(continued if one is begun else another)
        assert {str(f.relative_to(tmp_path)): f.read_bytes() for f in tmp_path.rglob("*.h5")} == before
    assert run(begun, Options(path, resume=True)).before > 0
