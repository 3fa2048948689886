"""Accidents of what a run leaves on the disk: results files, parts, notes."""

from __future__ import annotations

import contextlib
import json
import random
from pathlib import Path
from typing import Any

import h5py
import numpy as np

NUMBERS = (np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, -1.0, 0.0, 1e15, 2.0**63)
TEXTS = (
    "",
    "\x1b[31mred",
    "a\tb\nc",
    "\u202ekcab",
    "é\udcff",
    "/",
    "..",
    "peak/../status",
    "x" * 5000,
    "nan",
)
VALUES = (*NUMBERS, *TEXTS, None, True, [], {}, [[1.0]], -1, 10**30, 10**9, {"a": [0]}, "[" * 50)


def accident(dice: random.Random, file: Path) -> str:
    """Changes a file of a run; returns what was done, in a few words."""
    match file.suffix:
        case ".h5" if dice.random() < 0.7:
            with contextlib.suppress(OSError, RuntimeError):  # after another accident
                return _in_tree(dice, file)
        case ".json" if dice.random() < 0.8:
            with contextlib.suppress(ValueError, TypeError, IndexError):  # after another accident
                return _in_json(dice, file)
    return _in_bytes(dice, file)


def _in_bytes(dice: random.Random, file: Path) -> str:
    content = bytearray(file.read_bytes())
    if not content or dice.random() < 0.1:
        file.write_bytes(content[: dice.randrange(len(content) + 1)])
        return "cut short"
    places = [dice.randrange(len(content)) for _ in range(dice.choice((1, 1, 2, 8)))]
    for place in places:
        content[place] ^= 1 << dice.randrange(8)
    file.write_bytes(content)
    return f"bits flipped in bytes {places}"


def _in_json(dice: random.Random, file: Path) -> str:
    data: Any = json.loads(file.read_text(encoding="utf-8"))
    at, path = data, []
    while True:
        keys = list(at) if isinstance(at, dict) else list(range(len(at)))
        key = dice.choice(keys)
        path.append(key)
        inner = at[key]
        if not (isinstance(inner, dict | list) and inner and dice.random() < 0.8):
            break
        at = inner
    if dice.random() < 0.2:
        del at[key]
        done = "taken out"
    elif isinstance(at, list) and dice.random() < 0.2:
        at *= dice.choice((2, 1000))
        done = "repeated"
    else:
        at[key] = dice.choice(VALUES)
        done = f"now {at[key]!r:.40}"
    file.write_text(json.dumps(data), encoding="utf-8")
    return f"{path} {done}"


def _in_tree(dice: random.Random, file: Path) -> str:
    names: list[str] = []
    with h5py.File(file, "a") as root:
        root.visit(names.append)
        name = dice.choice(["/", *names])
        how = dice.choice((_attribute, _attribute, _numbers, _another, _gone, _link))
        with contextlib.suppress(KeyError, TypeError, ValueError, OSError, RuntimeError):
            return f"{name}: {how(dice, root, name)}"
    return f"{name}: nothing"


def _attribute(dice: random.Random, root: h5py.File, name: str) -> str:
    item = root[name]
    key = dice.choice(list(item.attrs) or ["units"])
    if dice.random() < 0.2:
        del item.attrs[key]
        return f"no attribute {key}"
    value = dice.choice((*NUMBERS, *TEXTS, b"\xff\x1b[2J", 10**9, np.arange(5), h5py.Empty("f8")))
    item.attrs[key] = value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value
    return f"attribute {key} now {value!r:.40}"


def _numbers(dice: random.Random, root: h5py.File, name: str) -> str:
    data = root[name]
    values = np.array(data[...])
    value = dice.choice(NUMBERS)
    if dice.random() < 0.5:
        values[...] = value
    else:
        values.ravel()[dice.randrange(values.size)] = value
    data[...] = values
    return f"numbers now {value}"


def _another(dice: random.Random, root: h5py.File, name: str) -> str:
    del root[name]
    shape = dice.choice(((), (0,), (1,), (3,), (2, 3), (10**6, 10**7)))
    kind = dice.choice(("f8", "f4", "i1", "i8", "u8", "S5", "c16", h5py.string_dtype(), h5py.ref_dtype))
    root.create_dataset(name, shape, kind, chunks=(1000, 1000) if shape[:1] == (10**6,) else None)
    return f"now of shape {shape} and type {kind}"


def _gone(dice: random.Random, root: h5py.File, name: str) -> str:
    del root[name]
    if dice.random() < 0.5:
        root.create_group(name)
        return "now a group"
    return "gone"


def _link(dice: random.Random, root: h5py.File, name: str) -> str:
    del root[name]
    link = dice.choice((h5py.SoftLink("/"), h5py.SoftLink(name), h5py.ExternalLink("secret.h5", "/peak")))
    root[name] = link
    return f"now {link!r:.60}"
