"""Shards: a grid cut into parts of equal cost, solved apart and joined again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tbi_cli.case import Case, load_case
from tbi_cli.errors import UserError
from tbi_cli.integrator.arrays import LANES
from tbi_cli.rounds import Rounds
from tbi_cli.runner import Options, plan_of, run
from tbi_cli.shards import Shard, deal
from tbi_cli.solve import Solver
from tbi_cli.store import merge
from tests.cluster.runs import SCENARIOS, content, inside


@pytest.mark.parametrize(
    "text", ["", "1", "0/3", "4/3", "1/0", "-1/3", "1/3/5", "1.5/3", "a/b", " 1/3", "1/9999999"]
)
def test_not_a_shard(text: str) -> None:
    with pytest.raises(UserError) as caught:
        Shard.parse(text)
    assert str(caught.value) == f"--shard: expected I/N, with I from 1 to N, e.g. 3/16; got {text!r}"


@given(
    steps=st.lists(st.integers(1, 10**6), min_size=1, max_size=200),
    structures=st.integers(1, 4),
    of=st.integers(1, 20),
)
def test_every_scenario_is_dealt_once_and_the_cost_is_balanced(
    steps: list[int], structures: int, of: int
) -> None:
    cost = np.array(steps, dtype=np.int64)
    owner = deal(cost, np.arange(len(steps)) % structures, of)
    assert owner.shape == cost.shape
    assert set(owner) <= set(range(1, of + 1))
    loads = np.bincount(owner, cost, minlength=of + 1)[1:]
    # Whoever has most got its last bundle when it had least, so it is above the mean by one bundle at most:
    # one scenario, or several that cost no more than the mean together.
    assert loads.max() <= loads.mean() + max(loads.mean(), cost.max())


def test_the_papers_sweep_is_balanced_where_counting_scenarios_is_not() -> None:
    """2-200 m/s: the slowest crossing takes a hundred times the steps of the fastest."""
    speeds = np.arange(2, 200.25, 0.5)
    steps = (5 * 67.5 / speeds / 0.001).astype(np.int64)
    for of in (2, 3, 7, 16):
        owner = deal(steps, np.zeros(len(steps), dtype=np.int64), of)
        loads, counts = np.bincount(owner, steps)[1:], np.bincount(owner)[1:]
        assert loads.max() < 1.03 * loads.mean()
        assert counts.max() > counts.min()


def test_like_lengths_stay_together() -> None:
    """Where a grid is large, shards are cut along full lanes: no more of them in all than without shards."""
    steps = np.sort(np.random.default_rng(1).integers(1000, 9000, 4096))[::-1].astype(np.int64)
    owner = deal(steps, np.zeros(len(steps), dtype=np.int64), 16)
    bundles = owner.reshape(-1, LANES)
    assert (bundles == bundles[:, :1]).all()


def test_a_shard_does_not_depend_on_what_is_kept(folder: Path) -> None:
    """Whatever histories are asked for, and of whichever of its scenarios a resumed shard is left with."""
    plain, kept = (
        load_case(folder / "case.yaml", overrides=overrides)
        for overrides in ([], ["output.histories={channels: [car_body_y], every: 0.01}"])
    )
    some = np.arange(SCENARIOS) % 3 == 0
    for number in (1, 2, 3):
        own = Rounds(Solver(plain), Shard(number, 3)).own
        solver = Solver(kept)
        rounds = Rounds(solver, Shard(number, 3))
        assert np.array_equal(own, rounds.own)
        assert np.array_equal(rounds.own, rounds.first())
        batched = np.concatenate(plan_of(solver, rounds.first() & some).batches)
        assert np.array_equal(np.sort(batched), np.flatnonzero(own & some))
        assert not rounds.more().any()


@pytest.mark.parametrize("of", [1, 3, 7, 16])
def test_shards_joined_are_the_whole(case: Case, whole: Mapping[str, bytes], tmp_path: Path, of: int) -> None:
    paths = [tmp_path / f"{number}.h5" for number in range(1, of + 1)]
    solved = 0
    for number, path in enumerate(paths, 1):
        summary = run(case, Options(output=path, shard=Shard(number, of)))
        solved += summary.solved
    assert solved == SCENARIOS
    merge(paths[::-1], tmp_path / "joined.h5")
    assert content(tmp_path / "joined.h5") == whole


def test_a_shard_on_its_own(case: Case, whole: Mapping[str, bytes], tmp_path: Path) -> None:
    """Full-size tables: the numbers of the whole in its part; NaN, and status 0, outside."""
    path = tmp_path / "shard.h5"
    run(case, Options(output=path, shard=Shard(2, 3)))
    with h5py.File(path) as file:
        status, peak = file["status"][...], file["peak/right_midspan"][...]
        assert file.attrs["shard"] == "2/3"
    assert status.shape == peak.shape == (2, 3, 44)
    assert set(np.unique(status)) == {0, 1}
    assert np.array_equal(np.isnan(peak), status == 0)
    reference = np.frombuffer(whole["peak/right_midspan"]).reshape(peak.shape)
    assert np.array_equal(peak[status == 1], reference[status == 1])


def test_more_shards_than_scenarios(case: Case, tmp_path: Path) -> None:
    few = case.swept(tuple(replace(axis, values=axis.values[:1]) for axis in case.axes))
    paths = [tmp_path / f"{number}.h5" for number in (1, 2, 3)]
    for number, path in enumerate(paths, 1):
        run(few, Options(output=path, shard=Shard(number, 3)))
    merge(paths, tmp_path / "joined.h5")
    with h5py.File(tmp_path / "joined.h5") as file:
        assert file["status"][...].tolist() == [[[1]]]


def test_from_the_command_line(folder: Path, whole: Mapping[str, bytes]) -> None:
    """Each shard has a file of its own; gaps are refused, or left to a later run."""
    for number in ("1", "3"):
        assert inside("run", "case.yaml", "--shard", f"{number}/3", "-q", folder=folder).code == 0
    names = ["results.shard-1-of-3.h5", "results.shard-3-of-3.h5"]
    assert sorted(path.name for path in folder.glob("*.h5")) == names

    ended = inside("run", "case.yaml", "--shard", "3/3", folder=folder)
    assert ended.code == 2
    assert "results.shard-3-of-3.h5: exists already" in ended.err
    ended = inside("run", "case.yaml", "--shard", "2/3", "-o", names[0], "--resume", folder=folder)
    assert ended.code == 2
    assert "is shard 1/3, not 2/3" in ended.err

    ended = inside("merge", *names, "-o", "results.h5", folder=folder)
    assert (ended.code, ended.out) == (2, "")
    assert ended.err == "missing shards: 2/3; --partial leaves their cases to be done\n"
    assert not (folder / "results.h5").exists()
    ended = inside("merge", *names, "-o", "results.h5", "--partial", folder=folder)
    assert ended.code == 0
    assert "to do" in ended.out
    ended = inside("merge", "results.h5", "-o", "other.h5", folder=folder)
    assert (ended.code, ended.err) == (2, f"{folder / 'results.h5'}: is not a shard of a run\n")

    assert inside("run", "case.yaml", "--resume", "-q", folder=folder).code == 0
    assert content(folder / "results.h5") == whole
    with h5py.File(folder / "results.h5") as file:
        assert "shard" not in file.attrs
