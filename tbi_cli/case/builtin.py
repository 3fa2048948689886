"""The trains, bridges and cases that come with the package."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

Kind = Literal["train", "bridge", "case"]
_FOLDERS: dict[str, Kind] = {"trains": "train", "bridges": "bridge"}
_NOT_LISTED = {"templates"}
_DIGITS = re.compile(r"([0-9]+)")


@dataclass(frozen=True)
class Builtin:
    """One of them: its kind, the name by which it is called, what it is, and where its values come from."""

    kind: Kind
    name: str
    description: str
    source: str
    path: Path


@cache
def configs_folder() -> Path:
    """The folder of built-in files: inside the installed package, or at the top of a source checkout."""
    package = Path(__file__).resolve().parent.parent
    installed = package / "configs"
    return installed if installed.is_dir() else package.parent / "configs"


def list_builtin(kind: Kind | None = None) -> list[Builtin]:
    """All of them, or those of one kind, by kind and name; hslm-a10 comes after hslm-a9."""

    def key(builtin: Builtin) -> tuple[object, ...]:
        words = tuple(
            (word.isdigit(), int(word) if word.isdigit() else word) for word in _DIGITS.split(builtin.name)
        )
        return (builtin.kind != "train", builtin.kind != "bridge", words)

    return sorted((builtin for builtin in _all() if kind in (None, builtin.kind)), key=key)


def builtin_path(kind: Kind, name: str) -> Path | None:
    """The file of a built-in train, bridge or case; `name` may have its folder before it and .yaml behind."""
    wanted = name.removesuffix(".yaml").removesuffix(".yml")
    if kind != "case":
        wanted = wanted.removeprefix(f"{kind}s/")
    if not wanted or any(part in ("", ".", "..") for part in wanted.split("/")) or "\0" in wanted:
        return None
    folder = configs_folder() if kind == "case" else configs_folder() / f"{kind}s"
    if kind == "case" and (wanted.split("/")[0] in _FOLDERS or wanted.split("/")[0] in _NOT_LISTED):
        return None
    path = folder / f"{wanted}.yaml"
    try:
        return path if path.is_file() else None
    except OSError:
        return None


def builtin_names(kind: Kind) -> list[str]:
    """Their names, sorted."""
    return [builtin.name for builtin in list_builtin(kind)]


def _all() -> Iterator[Builtin]:
    root = configs_folder()
    for path in sorted(root.rglob("*.yaml")):
        relative = path.relative_to(root)
        if relative.parts[0] in _NOT_LISTED:
            continue
        kind = _FOLDERS.get(relative.parts[0], "case") if len(relative.parts) > 1 else "case"
        name = path.stem if kind != "case" else relative.with_suffix("").as_posix()
        yield Builtin(kind, name, *_heading(path), path)


def _heading(path: Path) -> tuple[str, str]:
    """The first comment line of a file, and what follows "Source:" in its heading."""
    heading = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        heading.append(line.lstrip("# ").rstrip())
    source = next(
        (line.removeprefix("Source:").strip() for line in heading if line.startswith("Source:")), ""
    )
    return (heading[0].rstrip(".") if heading else "", source)
