"""Joining shards."""

from __future__ import annotations

from pathlib import Path

import pytest

from tbi_cli.store import Layout, ResultsStore, StoreError, merge, open_results
from tests.store.example import batch, content, layout


def shards(folder: Path, count: int = 3, of: Layout | None = None, stop: int = 0) -> list[Path]:
    """The shards of a run of 15 cases, dealt in turn; shard ``stop`` was interrupted."""
    paths = []
    for k in range(1, count + 1):
        own = of or layout(histories=2, shard=f"{k}/{count}", host=f"node{k}")
        path = folder / f"shard-{k}.h5"
        with ResultsStore(path, own) as store:
            store.write(batch(own, range(k - 1, 15, 2 * count)))
            if k != stop:
                store.write(batch(own, range(k - 1 + count, 15, 2 * count)))
                store.finish()
        paths.append(path)
    return paths


def refusal(paths: list[Path], out: Path, **options: bool) -> str:
    with pytest.raises(StoreError) as caught:
        merge(paths, out, **options)
    assert not out.exists()
    assert not out.with_name(out.name + ".parts").exists()
    return str(caught.value)


def test_shards_are_full_size_and_empty_outside_their_part(tmp_path: Path) -> None:
    with open_results(shards(tmp_path)[1]) as results:
        assert results.status.ravel().tolist() == [0, 1, 0] * 5
        assert results.attributes["shard"] == "2/3"


@pytest.mark.parametrize("count", [1, 3, 7, 16])
def test_the_same_bits_as_in_one_go(tmp_path: Path, count: int) -> None:
    of = layout(histories=2)
    with ResultsStore(tmp_path / "whole.h5", of) as store:
        store.write(batch(of, range(15)))
        whole = store.finish()
    merged = merge(shards(tmp_path, count)[::-1], tmp_path / "merged.h5", attributes={"host": "here"})
    assert content(merged) == content(whole)
    with open_results(merged) as results, open_results(whole) as expected:
        assert {**results.attributes, "host": ""} == {**expected.attributes, "host": ""}
        assert results.attributes["host"] == "here"


def test_gaps(tmp_path: Path) -> None:
    paths = shards(tmp_path, 5)
    out = tmp_path / "merged.h5"
    left = [paths[0], paths[3]]
    assert refusal(left, out) == "missing shards: 2/5, 3/5, 5/5; --partial leaves their cases to be done"
    gone = tmp_path / "shard-9.h5"
    assert refusal([*paths, gone], out) == f"missing: {gone}"
    with open_results(merge([*left, gone], out, partial=True)) as results:
        assert (results.status == 0).sum() == 9


def test_a_shard_that_still_runs(tmp_path: Path) -> None:
    paths = shards(tmp_path, stop=2)
    assert refusal(paths, tmp_path / "merged.h5") == (
        f"not finished: {paths[1]}; --partial leaves their cases to be done"
    )
    with open_results(merge(paths, tmp_path / "merged.h5", partial=True)) as results:
        assert (results.status == 0).sum() == 2
    assert paths[1].with_name("shard-2.h5.parts").exists()


def test_cases_that_no_shard_holds(tmp_path: Path) -> None:
    own = layout(shard="1/1")
    with ResultsStore(tmp_path / "shard.h5", own) as store:
        store.write(batch(own, range(3, 15)))
        path = store.finish()
    assert refusal([path], tmp_path / "merged.h5") == (
        "no shard holds 3 of the cases, the first is 0; --partial leaves them to be done"
    )


def test_a_partial_merge_can_be_resumed(tmp_path: Path) -> None:
    paths = shards(tmp_path)
    of = layout(histories=2)
    merged = merge(paths[:2], tmp_path / "merged.h5", partial=True)
    with ResultsStore(merged, of, resume=True) as store:
        assert store.done().tolist() == [True, True, False] * 5
        store.write(batch(of, range(2, 15, 3)))
        store.finish()
    assert content(merged) == content(merge(paths, tmp_path / "whole.h5"))


def test_duplicates(tmp_path: Path) -> None:
    paths = shards(tmp_path)
    assert refusal([*paths, paths[0]], tmp_path / "merged.h5") == (
        f"{paths[0]}: is shard 1/3, and so is {paths[0]}"
    )
    own = layout(histories=2, shard="3/3")
    with ResultsStore(paths[2], own, overwrite=True) as store:
        store.write(batch(own, range(15)))
        store.finish()
    assert refusal(paths, tmp_path / "merged.h5") == (
        f"{paths[2]}: holds case 0, which another shard holds too"
    )


def test_other_cases_versions_and_counts(tmp_path: Path) -> None:
    paths = shards(tmp_path)
    out = tmp_path / "merged.h5"

    def third(**attributes: str) -> list[Path]:
        own = layout(histories=2, **{"shard": "3/3", **attributes})
        with ResultsStore(paths[2], own, overwrite=True) as store:
            store.finish()
        return paths

    case = "title: an example\nbridge:\n  length: 50.0\n  modes: 5\n"
    assert "holds another case (bridge.modes: 5, now 4)" in refusal(third(case=case, sha256="3" * 64), out)
    assert "was written by tbi 0.0.9, this is 0.1.0" in refusal(third(tbi_version="0.0.9"), out)
    assert refusal(third(shard="3/4"), out) == f"{paths[2]}: is one of 4 shards, {paths[0]} one of 3"
    assert refusal(third(shard="4/3"), out) == f"{paths[2]}: is not a shard of a run"
    assert refusal(third(shard=""), out) == f"{paths[2]}: is not a shard of a run"


def test_the_output(tmp_path: Path) -> None:
    paths = shards(tmp_path)
    out = tmp_path / "merged.h5"
    out.write_text("precious")
    with pytest.raises(StoreError, match="exists already"):
        merge(paths, out)
    assert out.read_text() == "precious"
    merge(paths, out, overwrite=True)
    with pytest.raises(StoreError, match="is one of the shards"):
        merge(paths, paths[0], overwrite=True)
    with pytest.raises(StoreError, match="does not exist"):
        merge(paths, tmp_path / "missing" / "merged.h5")
    with pytest.raises(StoreError, match="no shards"):
        merge([], tmp_path / "other.h5")
