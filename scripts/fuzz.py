"""Tries broken case files on the reader: every one must load or end in a message, quickly.

    python scripts/fuzz.py --count 100000             mutations of the built-in cases, drawn by hypothesis
    python scripts/fuzz.py --engine atheris --count N  bytes, guided by coverage (pip install atheris)

Ends with exit code 1, and the input that did it, when a file brings an exception other than CaseError, a
message with control characters, a case that does not survive a round trip, or takes longer than 10 seconds.
"""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import FrameType

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

if any(argument.endswith("atheris") for argument in sys.argv):
    import atheris

    counted = atheris.instrument_imports(include=["tbi_cli"])
else:
    counted = nullcontext()
with counted:
    from tbi_cli.case import CaseError, list_builtin, load_case, starter_case
    from tbi_cli.case.messages import UNPRINTABLE

LONGEST_SECONDS = 10
# What stands where it should not: numbers out of range, YAML's own signs, words of the grammar.
FRAGMENTS = [
    *(".nan", ".inf", "-1", "0", "1e999", "1e15", "1e-300", "0x10", "9" * 40, "true", "null", "~", "on"),
    *(
        "[]",
        "{}",
        "[1]",
        "{a: 1}",
        "&a",
        "*a",
        "!!str",
        "!x",
        "<<",
        "-",
        "?",
        ":",
        "|",
        ">",
        "%",
        "@",
        "`",
        "#",
    ),
    *(
        "\n",
        "\n- ",
        "\n  ",
        "  ",
        "\r",
        "\t",
        "\0",
        "\x1b[31m",
        '"\\0"',
        "\u2028",
        "é",
        "---",
        "...",
        "[[[[",
        "{{{{",
    ),
    *(
        "5 kg",
        "1 %",
        "9**9**9 m",
        "km/h",
        "from",
        "to",
        "step",
        "count",
        "log",
        "zip",
        "sample",
        "velocity",
        "span",
    ),
    *(
        "damping",
        "ratio",
        "coefficient",
        "train",
        "bridge",
        "paper",
        "case.yaml",
        ".",
        "..",
        "/dev/null",
        "auto",
    ),
    *("full-31dof", "sprung-mass", "rigid-beam", "moving-load", "forces", "l_b1", "front_bogie", "hertz"),
]
KEYS = [
    *("velocity", "train", "bridge", "sweep", "sweep.velocity", "sweep.zip", "sweep.span.step", "a.b", ""),
    *("train.car_body.mass", "bridge.right.damping", "output.histories.every", "sweep.train.geometry.l_b1"),
]


# What no built-in case has: consists, lists of forces, another contact, every form of a sweep.
MORE = (
    """\
train:
  consist:
    - {vehicle: {model: moving-load, forces: [1 kN, 2 kN], positions: [0, 3]}, count: 2, spacing: 25 m}
    - {vehicle: {model: axle-forces, forces: [1 kN, 2 kN], positions: [0, 3]}, spacing: 20}
    - {vehicle: {model: hslm-a, number: 3}, count: 1, spacing: 400}
bridge: verification-1
solver: {method: exact, sampling: 0.01}
sweep: {train.consist.0.spacing: [25, 26], velocity: {log: {from: 1, to: 99, count: 3}}}
""",
    """\
train:
  consist:
    - {vehicle: paper, count: 3, spacing: 25 m}
    - {vehicle: &last crh380a, spacing: 25}
    - {vehicle: *last, spacing: 26 m}
bridge: &b paper
contact: {model: hertz, stiffness: 1.4e9}
velocity: 300 km/h
sweep:
  sample:
    {kind: random, count: 5, over: {velocity: {normal: [80, 5], within: [70, 90]}, span: {uniform: [30, 40]}}}
""",
    """\
train: {model: axle-forces, csv: forces.csv}
bridge: verification-2
sweep: {velocity: [10, 20, 10], damping: {from: 0, to: 2, count: 3}, modes: [1], zip: [velocity, damping]}
""",
)


def corpus() -> list[str]:
    """Real case files: the built-in ones, as written and resolved, the starter, and a few more."""
    cases = list_builtin("case")
    written = [case.path.read_text(encoding="utf-8") for case in cases]
    return [*written, *(load_case(case.name).to_yaml() for case in cases), starter_case(), *MORE]


CORPUS = corpus()
PLACES = st.integers(0, 10_000)


@st.composite
def broken_files(draw: st.DrawFn) -> str:
    """A real case file after one to six accidents."""
    text = draw(st.sampled_from(CORPUS))
    for _ in range(draw(st.integers(1, 6))):
        text = draw(accidents(text))
    return text


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


def check(folder: Path, content: bytes, options: list[str]) -> bool:
    """Loads the file with these options; whether it was a case. Raises what should never be raised."""
    path = folder / "case.yaml"
    path.write_bytes(content)
    (folder / "forces.csv").write_text("position,force\n0,1 kN\n3 m,2e3\n")
    with time_limit():
        try:
            case = load_case(path, overrides=options)
        except CaseError as error:
            message = str(error)
            assert message, "a message without words"
            assert not UNPRINTABLE.search(message.replace("\n", "")), f"control characters in {message!r}"
            return False
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
        raise TimeoutError(f"longer than {LONGEST_SECONDS} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, LONGEST_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


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
    def run(text: str, options: list[str]) -> None:
        nonlocal cases
        cases += check(folder, text.encode("utf-8"), options)

    run()
    print(f"{count} files: {cases} were cases, the others ended in a message")


def with_atheris(folder: Path, count: int, start: int) -> None:
    """`count` inputs of bytes, guided by what they reach in the reader."""

    def run(content: bytes) -> None:
        check(folder, content, [])

    seeds = folder / "corpus"
    seeds.mkdir()
    for number, text in enumerate(CORPUS):
        (seeds / f"{number}.yaml").write_text(text, encoding="utf-8")
    atheris.Setup([sys.argv[0], f"-runs={count}", f"-seed={start}", "-max_len=20000", str(seeds)], run)
    atheris.Fuzz()


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000, help="how many inputs (default: 10000)")
    parser.add_argument("--seed", type=int, default=1, help="another seed, other inputs (default: 1)")
    parser.add_argument("--engine", choices=("hypothesis", "atheris"), default="hypothesis")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        engine = with_atheris if arguments.engine == "atheris" else with_hypothesis
        engine(Path(folder), arguments.count, arguments.seed)


if __name__ == "__main__":
    main()
