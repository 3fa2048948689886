"""What goes in comes out, bit for bit, however it was cut into batches, shards and runs."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tbi_cli.store import (
    DAF,
    DONE,
    TABLES,
    BatchResult,
    Dim,
    History,
    Layout,
    Results,
    ResultsStore,
    Variable,
    merge,
    open_results,
)
from tbi_cli.store.errors import one_line
from tests.store.example import content

# Words are one printable line, as the program writes them; others are made so when a file is read.
words = st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=12).map(one_line)
names = st.from_regex(r"[a-z][a-z0-9_]{0,12}", fullmatch=True)
floats = st.floats(allow_nan=False, allow_infinity=False)


@st.composite
def layouts(draw: st.DrawFn) -> Layout:
    """Grids of one to three axes, with channels and histories of any names."""
    used = draw(st.lists(names.filter(lambda n: n != "time"), min_size=8, max_size=8, unique=True))
    lengths = draw(st.lists(st.integers(1, 5), min_size=1, max_size=3))
    dims = tuple(
        Dim(used[k], np.array(draw(st.lists(floats, min_size=n, max_size=n))), draw(words), draw(words))
        for k, n in enumerate(lengths)
    )
    channels = tuple(
        Variable(name, draw(words), draw(words)) for name in used[3 : 3 + draw(st.integers(1, 3))]
    )
    histories = tuple(
        Variable(name, draw(words), draw(words)) for name in used[6 : 6 + draw(st.integers(0, 2))]
    )
    daf = draw(st.sampled_from([tuple(DAF), ("right", "right_static"), ()]))
    attributes = {"case": draw(words), "case_sha256": draw(names), "tbi_version": "0.1.0"}
    return Layout(dims, channels, histories, daf, attributes)


@st.composite
def runs(draw: st.DrawFn) -> tuple[Layout, list[BatchResult]]:
    """A layout and some batches that cover some of its grid, once each."""
    layout = draw(layouts())
    indices = draw(st.permutations(range(layout.size)))[: draw(st.integers(0, layout.size))]
    cuts = sorted(draw(st.sets(st.integers(0, len(indices)), max_size=4)))
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    batches = []
    for a, b in zip([0, *cuts], [*cuts, len(indices)], strict=True):
        flat = np.array(indices[a:b], dtype=np.int64)
        status = random.integers(1, 3, len(flat)).astype(np.int8)
        lost = (status != DONE)[:, None]
        shape = (len(flat), len(layout.channels))
        tables = {group: np.where(lost, np.nan, random.normal(size=shape)) for group in TABLES}
        daf = {name: np.where(lost[:, 0], np.nan, random.normal(size=len(flat))) for name in layout.daf}
        histories = {}
        if layout.history_channels:
            for i in flat[status == DONE]:
                n = int(random.integers(0, 9))
                histories[int(i)] = History(
                    random.normal(size=n), random.normal(size=(len(layout.history_channels), n))
                )
        messages = [f"Grund {i}: größer" if s != DONE else "" for i, s in zip(flat, status, strict=True)]
        seconds, steps = random.random(len(flat)), random.integers(0, 1000, len(flat))
        batches.append(BatchResult(flat, status, messages, tables, daf, seconds, steps, histories))
    return layout, batches


def check(results: Results, layout: Layout, batches: list[BatchResult]) -> None:
    """Everything in ``results`` is what the batches hold, and nothing else is there."""
    status = np.zeros(layout.size, dtype=np.int8)
    for batch in batches:
        status[batch.indices] = batch.status
    np.testing.assert_array_equal(results.status, status.reshape(layout.shape))
    messages = {int(i): m for b in batches for i, m in zip(b.indices, b.messages, strict=True) if m}
    assert results.messages == dict(sorted(messages.items()))
    for group in layout.groups:
        for column, variable in enumerate(layout.columns(group)):
            expected = np.full(layout.size, np.nan)
            for batch in batches:
                daf = group == "daf"
                expected[batch.indices] = batch.daf[variable.name] if daf else batch.tables[group][:, column]
            found = results.table(group, variable.name)
            assert found.tobytes() == expected.tobytes()
            assert found.shape == layout.shape
    histories = {i: h for batch in batches for i, h in batch.histories.items()}
    assert results.history_indices() == sorted(histories)
    for index, history in histories.items():
        found = results.history(index)
        assert found.time.tobytes() == history.time.tobytes()
        assert found.values.tobytes() == history.values.tobytes()
        last = layout.history_channels[-1].name
        np.testing.assert_array_equal(results.history(index, [last]).values, history.values[-1:])


@settings(max_examples=60, deadline=None)
@given(runs())
def test_parts_and_file_hold_what_was_written(run: tuple[Layout, list[BatchResult]]) -> None:
    layout, batches = run
    with TemporaryDirectory() as folder:
        path = Path(folder) / "results.h5"
        with ResultsStore(path, layout) as store:
            for batch in batches:
                store.write(batch)
            with open_results(path) as results:
                assert not results.finished
                check(results, layout, batches)
            store.finish()
        assert [p.name for p in Path(folder).iterdir()] == ["results.h5"]
        with open_results(path) as results:
            assert results.finished
            check(results, layout, batches)
            assert results.channels == layout.channels
            assert results.case_yaml == layout.attributes["case"]
            for found, dim in zip(results.dims, layout.dims, strict=True):
                assert (found.name, found.units, found.long_name) == (dim.name, dim.units, dim.long_name)
                assert found.values.tobytes() == dim.values.tobytes()


@settings(max_examples=40, deadline=None)
@given(runs(), st.integers(0, 5), st.booleans())
def test_an_interrupted_run_ends_with_the_same_bits(
    run: tuple[Layout, list[BatchResult]], stop: int, finished: bool
) -> None:
    """Stopped after some batches, with or without a results file of what there was; then resumed."""
    layout, batches = run
    with TemporaryDirectory() as folder:
        whole, broken = Path(folder) / "whole.h5", Path(folder) / "broken.h5"
        with ResultsStore(whole, layout) as store:
            for batch in batches:
                store.write(batch)
            store.finish()
        with ResultsStore(broken, layout) as store:
            for batch in batches[:stop]:
                store.write(batch)
            if finished:
                store.finish()
        with ResultsStore(broken, layout, resume=True) as store:
            done = np.zeros(layout.size, dtype=bool)
            for batch in batches[:stop]:
                done[batch.indices] = batch.status == DONE
            np.testing.assert_array_equal(store.done(), done)
            for batch in batches:
                if not done[batch.indices].all():
                    store.write(batch)
            store.finish()
        assert content(broken) == content(whole)
        assert sorted(p.name for p in Path(folder).iterdir()) == ["broken.h5", "whole.h5"]


@settings(max_examples=40, deadline=None)
@given(runs(), st.integers(1, 4))
def test_shards_merge_to_the_same_bits(run: tuple[Layout, list[BatchResult]], count: int) -> None:
    layout, batches = run
    with TemporaryDirectory() as folder:
        whole = Path(folder) / "whole.h5"
        with ResultsStore(whole, layout) as store:
            for batch in batches:
                store.write(batch)
            store.finish()
        shards = []
        for k in range(count):
            attributes = {**layout.attributes, "shard": f"{k + 1}/{count}"}
            own = Layout(layout.dims, layout.channels, layout.history_channels, layout.daf, attributes)
            with ResultsStore(Path(folder) / f"shard{k}.h5", own) as store:
                for batch in batches[k::count]:
                    store.write(batch)
                shards.append(store.finish())
        merged = merge(shards[::-1], Path(folder) / "merged.h5", partial=True)
        assert content(merged) == content(whole)
