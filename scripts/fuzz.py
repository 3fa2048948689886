"""Tries broken case files on the reader: every one must load or end in a message, quickly.

    python scripts/fuzz.py --count 100000             mutations of the built-in cases, drawn by hypothesis
    python scripts/fuzz.py --engine atheris --count N  bytes, guided by coverage (pip install atheris)
    python scripts/fuzz.py --tables --count 10000     tables of axles and rails, whole and broken
    python scripts/fuzz.py --engine ends              every key at its ends, solved where that is short

Ends with exit code 1, and the input that did it, when a file brings an exception other than CaseError, a
message with control characters, a case that does not survive a round trip, or takes longer than 10 seconds
of the processor, or waits for ten minutes; or when a table is read as other numbers than it says, a whole
one is not read, or a broken one brings more than two messages.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import sys
import tempfile
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import FrameType
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

if any(argument.endswith("atheris") for argument in sys.argv):
    import atheris

    counted = atheris.instrument_imports(include=["tbi_cli"])
else:
    counted = nullcontext()
with counted:
    from fuzzing.corpus import BESIDE, CASE, CORPUS, MORE
    from fuzzing.tables import BRIDGE, CASES, TrueTable, close, hurt, tables
    from fuzzing.words import FRAGMENTS, KEYS

    from tbi_cli.case import CaseError, load_case
    from tbi_cli.case.messages import UNPRINTABLE

# Time of the processor, as a machine may be busy with other things; and of the clock, for what only waits.
LIMITS = ((signal.ITIMER_PROF, signal.SIGPROF, 10), (signal.ITIMER_REAL, signal.SIGALRM, 600))
SECONDS_FOR_ENDS = 300
PLACES = st.integers(0, 10_000)


@st.composite
def broken_files(draw: st.DrawFn) -> dict[str, str]:
    """A real case file after one to six accidents; or one that is whole beside a file that is not."""
    name = draw(st.sampled_from([*[CASE] * 6, *BESIDE]))
    files = BESIDE | {CASE: draw(st.sampled_from(CORPUS))}
    if name != CASE:
        files[CASE] = draw(st.sampled_from([text for text in MORE if name in text]))
    for _ in range(draw(st.integers(1, 6))):
        files[name] = draw(accidents(files[name]))
    return files


@st.composite
def accidents(draw: st.DrawFn, text: str) -> str:
    """The text with something put in, taken out, doubled, swapped or exchanged."""
    words = text.split()
    lines = text.split("\n")
    at = draw(PLACES) % (len(text) + 1)
    match draw(st.integers(0, 6)):
        case 0:
            return text[:at] + draw(st.sampled_from(FRAGMENTS)) + text[at:]
        case 1:
            return text[:at] + text[at + draw(st.integers(1, 30)) :]
        case 2:
            line = lines[draw(PLACES) % len(lines)]
            lines.insert(draw(PLACES) % (len(lines) + 1), line)
            return "\n".join(lines)
        case 3 if words:
            return text.replace(words[draw(PLACES) % len(words)], draw(st.sampled_from(FRAGMENTS)), 1)
        case 4 if words:
            return text.replace(words[draw(PLACES) % len(words)], words[draw(PLACES) % len(words)], 1)
        case 5:
            del lines[draw(PLACES) % len(lines)]
            return "\n".join(lines)
        case _:
            return text[:at] + draw(st.characters(exclude_categories=["Cs"])) + text[at + 1 :]


OPTIONS = st.lists(
    st.tuples(st.sampled_from(KEYS), st.sampled_from(["=", "", "= "]), st.sampled_from(FRAGMENTS)).map(
        "".join
    ),
    max_size=2,
)


def check(folder: Path, files: dict[str, bytes], options: list[str]) -> bool:
    """Loads the case with these options; whether it was one. Raises what should never be raised."""
    for name, content in files.items():
        (folder / name).write_bytes(content)
    path = folder / CASE
    with time_limit():
        try:
            case = load_case(path, overrides=options)
        except CaseError as error:
            message = str(error)
            assert message, "a message without words"
            assert not UNPRINTABLE.search(message.replace("\n", "")), f"control characters in {message!r}"
            return False
        assert not UNPRINTABLE.search("".join(case.warnings).replace("\n", "")), "control characters"
        path.write_text(case.to_yaml(), encoding="utf-8")
        again = load_case(path)
        assert again == case, "another case after a round trip"
        assert again.sha256 == case.sha256, "another hash after a round trip"
        case.at({axis.name: axis.values[-1] for axis in case.axes}).resolved()
    return True


@contextmanager
def time_limit() -> Iterator[None]:
    """Raises TimeoutError in what takes too long."""

    def late(number: int, frame: FrameType | None) -> None:
        raise TimeoutError(f"too long: {signal.Signals(number).name}")

    before = [signal.signal(number, late) for _, number, _ in LIMITS]
    try:
        for timer, _, seconds in LIMITS:
            signal.setitimer(timer, seconds)
        yield
    finally:
        for timer, _, _ in LIMITS:
            signal.setitimer(timer, 0)
        for (_, number, _), handler in zip(LIMITS, before, strict=True):
            signal.signal(number, handler)


def with_hypothesis(folder: Path, count: int, start: int) -> None:
    """`count` broken files; a failing one is made as small as it gets, and shown."""
    cases = 0

    @seed(start)
    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
        print_blob=False,
    )
    @given(broken_files(), OPTIONS)
    def run(files: dict[str, str], options: list[str]) -> None:
        nonlocal cases
        cases += check(folder, {name: text.encode("utf-8") for name, text in files.items()}, options)

    run()
    print(f"{count} files: {cases} were cases, the others ended in a message")


def check_table(folder: Path, table: TrueTable) -> bool:
    """Loads a case with this table; whether it was read, as what it says. Raises where it was misread."""
    (folder / "table.csv").write_bytes(table.content)
    path = folder / CASE
    path.write_text(CASES[table.kind] + BRIDGE, encoding="utf-8")
    with time_limit():
        try:
            case = load_case(path)
        except CaseError as error:
            assert not table.whole, f"a table that should be read: {error}"
            messages = [line for line in str(error).splitlines() if not line.startswith("   ")]
            assert len(messages) <= 2, f"a message for every value: {messages}"
            return False
    if table.kind == "axles":
        train: Any = case.train
        first = train.positions[0]
        found = (tuple(x - first for x in train.positions), train.forces)
    else:
        profile: Any = case.track and case.track.irregularity.profile
        found = profile.points[: 3 if profile.left else 2]
    assert close(found, table.columns), f"misread: {found}, not {table.columns}"
    assert not table.whole or len(case.warnings) == table.left_out, f"warnings: {case.warnings}"
    return True


def of_tables(folder: Path, count: int, start: int) -> None:
    """`count` tables, half of them broken."""
    read = 0

    @seed(start)
    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
        print_blob=False,
    )
    @given(st.one_of(tables(), tables().flatmap(hurt)))
    def run(table: TrueTable) -> None:
        nonlocal read
        read += check_table(folder, table)

    run()
    print(f"{count} tables: {read} were read, the others ended in a message")


def with_atheris(folder: Path, count: int, start: int) -> None:
    """`count` inputs of bytes, guided by what they reach in the reader."""

    beside = {name: text.encode("utf-8") for name, text in BESIDE.items()}

    def run(content: bytes) -> None:
        check(folder, {**beside, CASE: content}, [])

    seeds = folder / "corpus"
    seeds.mkdir()
    for number, text in enumerate(CORPUS):
        (seeds / f"{number}.yaml").write_text(text, encoding="utf-8")
    atheris.Setup([sys.argv[0], f"-runs={count}", f"-seed={start}", "-max_len=20000", str(seeds)], run)
    atheris.Fuzz()


def give_up(text: str) -> None:
    """Ends this process, whatever it is at."""
    print(text, file=sys.stderr, flush=True)
    os._exit(1)


def with_ends(folder: Path, count: int, start: int) -> None:
    """Every key at its ends; of more of them than `count` some, drawn."""
    from fuzzing.ends import check_ends, trials

    every = list(trials())
    chosen = every if count >= len(every) else random.Random(start).sample(every, count)
    found: Counter[str] = Counter()
    for base, override in chosen:
        # A signal waits for compiled code to come back, a thread does not.
        watch = threading.Timer(SECONDS_FOR_ENDS, give_up, [f"too long: {base}: --set '{override}'"])
        watch.start()
        try:
            found[check_ends(folder, base, override)] += 1
        except Exception:
            print(f"{base}: --set '{override}'", file=sys.stderr)
            raise
        finally:
            watch.cancel()
    print(f"{len(chosen)} of {len(every)} ends: {', '.join(f'{n} {what}' for what, n in found.items())}")


ENGINES = {"hypothesis": with_hypothesis, "atheris": with_atheris, "ends": with_ends}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000, help="how many inputs (default: 10000)")
    parser.add_argument("--seed", type=int, default=1, help="another seed, other inputs (default: 1)")
    parser.add_argument("--engine", choices=ENGINES, default="hypothesis")
    parser.add_argument("--tables", action="store_true", help="tables of axles and rails")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        engine = of_tables if arguments.tables else ENGINES[arguments.engine]
        engine(Path(folder), arguments.count, arguments.seed)


if __name__ == "__main__":
    main()
