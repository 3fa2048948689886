"""Names, permissions and files of strangers, met by every command: an exit code and a message, no more."""

from __future__ import annotations

import contextlib
import os
import random
import shutil
from collections.abc import Iterator
from pathlib import Path

from fuzzing.strangers import accident
from soaking.common import Soak

from tests.cli.forked import Died, forked
from tests.cluster.fake_slurm import fake_slurm

CASE = """\
title: Two forces
train: {model: moving-load, forces: [1 kN, 2 kN], positions: [0, 3]}
bridge: {length: 20, modes: 1, right: {youngs_modulus: 35 GPa, second_moment: 0.5, mass_per_length: 15 t/m,
  damping: {ratio: 1 %}}}
solver: {method: exact, sampling: 0.01}
sweep: {velocity: [40, 50, 60]}
output: {histories: {channels: [right_midspan], every: 0.05 s}}
"""
STUDIES = CASE.replace(
    "sweep: {velocity: [40, 50, 60]}",
    "velocity: 50\nstudies: {one: {sweep: {bridge.length: [20, 25]}}, two: {sweep: {velocity: [40, 60]}}}",
)
SECRET = "hunter2"  # in a file that no case and no results file is in
SECONDS = 60

_LONG = "n" * 251
NAMES = {
    "the root": "/",
    "a folder": ".",
    "the folder above": "..",
    "nothing": "",
    "252 bytes": f"{_LONG[:249]}.h5",
    "247 bytes": f"{_LONG[:244]}.h5",
    "255 bytes": f"{_LONG}nnnn",
    "255 bytes of two each": "é" * 126 + ".h5",
    "300 bytes": _LONG + "n" * 49,
    "no UTF-8": os.fsdecode(b"r\xff\xfe.h5"),
    "marks and escapes": "r\x1b[31m\t\u202ex\u2028.h5",
    "two lines": "r\nx.h5",
    "a null character": "r\0x.h5",
    "100 folders": "/".join(["d" * 50] * 100) + "/r.h5",
    "a device": "/dev/null",
    "a pipe": "pipe",
    "a loop": "loop",
    "a file as folder": "case.yaml/r.h5",
    "no such folder": "missing/r.h5",
    "in a closed folder": "closed/r.h5",
    "in a blind folder": "blind/r.h5",
    "in a folder to be listed": "listed/r.h5",
    "in a folder to be read": "read/r.h5",
    "new in a folder to be read": "read/new.h5",
    "locked": "locked.h5",
    "with locked parts": "parts.h5",
    "with a locked layout": "layout.h5",
    "with a locked part": "part.h5",
    "with a locked lock": "lock.h5",
    "with a locked note": "note.h5",
    "with a file for parts": "file.h5",
    "with pipes for parts": "pipes.h5",
}
_CLOSED = {"closed": 0, "blind": 0o100, "listed": 0o400, "read": 0o500}


def _imported_once() -> None:
    """What commands import when they are called: children find it there."""
    from tbi_cli.cluster import status, submission  # noqa: F401
    from tbi_cli.report import draw, make  # noqa: F401


def commands(path: str) -> Iterator[tuple[str, ...]]:
    """Every command that takes a path, at every place where it takes one."""
    for command in ("status", "info", "export", "report", "run", "validate", "submit", "init", "reproduce"):
        yield (command, path)
    yield from (
        ("sweep", "velocity", path),
        ("merge", path, "-o", "m.h5"),
        ("info", "good.h5", "--diff", path),
    )
    yield ("merge", "s1.h5", path, "--partial", "-o", "m.h5")
    yield ("status", "case.yaml", "-o", path)
    for command in ("export", "reproduce", "report"):
        yield (command, "good.h5", "-o", path)
    for how in ((), ("--overwrite",)):
        yield ("merge", "s1.h5", "s2.h5", "-o", path, *how)
    for how in ((), ("--resume",), ("--overwrite",), ("--shard", "1/2")):
        yield ("run", "case.yaml", "-o", path, *how)
    for how in ((), ("--resume",), ("--overwrite",), ("--dry-run",)):
        yield ("submit", "case.yaml", "-o", path, *how)
    for key in ("output.file", "train", "bridge", "train.csv", "track.irregularity.profile.csv"):
        yield ("validate", "case.yaml", "--set", f"{key}={path}")
    for option in ("--set", "--channels", "--select", "--x", "--formats"):
        yield ("report", "good.h5", option, path)
    yield from (
        ("run", "case.yaml", "--backend", path),
        (path,),
        ("list", path),
        ("sweep", path, "case.yaml"),
    )
    yield ("submit", "case.yaml", "-o", "q.h5", "--setup", path, "--time", path, "--sbatch", f"--{path}")


def paths(soak: Soak) -> None:
    """Names that no one expects and places without permission, in every command."""
    made = _made(soak)
    names = list(NAMES.items())[:: 7 if soak.short else 1]
    wrong, tried = [], 0
    for what, path in names:
        for command in list(commands(path))[:: 5 if soak.short else 1]:
            with _place(soak.folder / "place", made) as place:
                before = _below(place)
                with contextlib.suppress(ValueError):  # no process can be given a null character
                    ended = forked(*command, folder=place, patience=SECONDS)
                    tried += 1
                    faults = faults_of(ended)
                    if ended.code == 2 and _below(place) != before:
                        faults.append(f"left {sorted(_below(place) ^ before)[:3]!r:.200}")
                    wrong += [f"{what}: tbi {' '.join(command)!r:.200}: {fault}" for fault in faults]
    _told(soak, f"{tried} commands on {len(names)} hostile paths", wrong)


def strangers(soak: Soak) -> None:
    """Results files, parts and notes after accidents, read by every command."""
    made, dice = _made(soak), random.Random(1)
    wrong: list[str] = []
    rounds = 4 if soak.short else 1000
    for _ in range(rounds):
        with _place(soak.folder / "place", made) as place:
            target = dice.choice(("good", "unfinished", "studies", "half", "sent"))
            files = {
                "good": [place / "good.h5"],
                "studies": [place / "several.h5"],
                "half": [file for file in place.glob("half.h5.parts/**/*") if file.is_file()],
                "unfinished": list(place.glob("unfinished.h5.parts/*")),
                "sent": list(place.glob("sent-slurm/*.json")),
            }[target]
            hurt = [dice.choice(files) for _ in range(dice.choice((1, 1, 3)))]
            done = [f"{file.name}: {accident(dice, file)}" for file in hurt]
            names = {"studies": "several"}
            path = f"{names.get(target, target)}.h5"
            for command in _of_strangers(dice, path, target):
                ended = forked(*command, folder=place, patience=SECONDS)
                wrong += [f"{done}: tbi {' '.join(command)}: {fault}" for fault in faults_of(ended)]
    _told(soak, f"{rounds} times an accident", wrong)


def _of_strangers(dice: random.Random, path: str, target: str) -> Iterator[tuple[str, ...]]:
    case = "several.yaml" if target in ("studies", "half") else "case.yaml"
    yield from (("info", path, "-v"), ("info", "whole.h5", "--diff", path), ("status", path))
    yield from (("export", path, "--overwrite"), ("merge", "s1.h5", path, "-o", "m.h5"))
    if dice.random() < 0.2:  # they take longer than all others together
        yield ("report", path, "--formats", "png", "-j", "1")
        yield ("reproduce", path, "-o", "again")
    yield ("submit", "case.yaml", "-o", path)
    yield ("submit", "case.yaml", "-o", path, "--resume")
    yield from (("run", case, "-o", path), ("run", case, "-o", path, "--resume"))
    yield ("run", case, "-o", path, "--overwrite")


def faults_of(ended: Died) -> list[str]:
    """What is wrong with how a command ended."""
    found = []
    if ended.code not in (0, 1, 2):
        found.append(f"ended with {ended.code}: {ended.text[-300:]!r}")
    elif "Traceback" in ended.text:
        found.append(f"a traceback: {ended.text[-300:]!r}")
    if ended.code == 2 and not ended.err.strip():
        found.append("no message")
    for stream in (ended.out, ended.err):
        try:
            lines = stream.decode("utf-8").split("\n")
        except UnicodeDecodeError:
            found.append(f"no UTF-8: {stream[:200]!r}")
        else:
            found += [f"not printable: {line!r:.200}" for line in lines if not line.isprintable()][:1]
    if SECRET in ended.text:
        found.append("shows what is in a file outside the case's folder")
    return found


def _told(soak: Soak, what: str, wrong: list[str]) -> None:
    for line in wrong[:20]:
        print(f"       {line}")
    soak.holds(f"{what}: {len(wrong)} without an exit code and a message that can be printed", not wrong)


def _below(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


def _made(soak: Soak) -> Path:
    """A folder with results of every kind: whole, in shards, of studies, unfinished, sent to a cluster."""
    _imported_once()
    made = soak.folder / "made"
    made.mkdir()
    (made / "case.yaml").write_text(CASE)
    (made / "several.yaml").write_text(STUDIES)
    soak.tbi("run", "made/case.yaml", "-q", "-o", "made/good.h5")
    soak.tbi("run", "made/several.yaml", "-q", "-o", "made/several.h5")
    for number in (1, 2):
        soak.tbi("run", "made/case.yaml", "-q", "-o", f"made/s{number}.h5", "--shard", f"{number}/2")
    shutil.copy(made / "good.h5", made / "whole.h5")
    for case, name in (("case", "unfinished"), ("several", "half")):
        _stop(made / f"{case}.yaml", made / f"{name}.h5")
    (made / "sent-slurm" / "shards").mkdir(parents=True)
    (made / "sent-slurm" / "submission.json").write_text(
        '{"shards": 2, "jobs": {"shard": "17", "merge": "18"}}'
    )
    (made / "sent-slurm" / "case.yaml").write_text(CASE)
    return made


def _stop(case: Path, path: Path) -> None:
    """An unfinished run: all but its last step, which makes one file of the parts."""
    from tbi_cli.case import load_case
    from tbi_cli.runner import Options, _store
    from tbi_cli.studies import solver_of

    solver = solver_of(load_case(case))
    with _store(path, solver, Options()) as store:
        for index in range(sum(len(part.scenarios) for part in solver.parts.values()) - 1):
            result = solver.solve([index])
            assert result is not None
            store.write(result)


@contextlib.contextmanager
def _place(place: Path, made: Path) -> Iterator[Path]:
    """A copy of what was made in a folder with all that is hostile about a file system."""
    shutil.copytree(made, place)
    for name in ("parts", "layout", "part", "lock"):
        shutil.copytree(made / "unfinished.h5.parts", place / f"{name}.h5.parts")
    (place / "lock.h5.parts" / "lock").write_text("{}")
    shutil.copytree(made / "sent-slurm", place / "note-slurm")
    locked = [place / "locked.h5", place / "note-slurm" / "submission.json", place / "lock.h5.parts" / "lock"]
    shutil.copy(made / "good.h5", locked[0])
    locked += [place / "layout.h5.parts" / "layout.json", *place.glob("part.h5.parts/*.h5")]
    (place / "file.h5.parts").touch()
    (place / "pipes.h5.parts").mkdir()
    for pipe in ("pipe", "pipes.h5.parts/layout.json", "pipes.h5.parts/lock", "pipes.h5.parts/000000.h5"):
        os.mkfifo(place / pipe)
    (place / "loop").symlink_to("loop")
    (place.parent / "secret").write_text(f"{SECRET}: {SECRET}\n")
    for name in _CLOSED:
        (place / name).mkdir()
        shutil.copy(made / "good.h5", place / name / "r.h5")
    for file in (*locked, place / "parts.h5.parts"):
        file.chmod(0)
    for name, mode in _CLOSED.items():
        (place / name).chmod(mode)
    before = os.environ["PATH"]
    os.environ["PATH"] = f"{fake_slurm(place / 'bin')}:{before}"
    try:
        yield place
    finally:
        os.environ["PATH"] = before
        for folder, _, _ in os.walk(place):  # a folder is opened before what is in it is looked for
            Path(folder).chmod(0o700)
            for name in (*_CLOSED, "parts.h5.parts"):
                with contextlib.suppress(FileNotFoundError):
                    (Path(folder) / name).chmod(0o700)
        shutil.rmtree(place)
