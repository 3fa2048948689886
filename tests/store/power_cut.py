"""What a program asks of the file system, call by call, and what a power cut after each call may leave.

strace records the calls.  `Disk` plays them back on a model of a file system that promises no more than POSIX
does: what a file holds is safe once the file is synced, and a name once its folder is.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_TRACED = (
    "open,openat,creat,write,pwrite64,writev,pwritev,pwritev2,fsync,fdatasync,rename,renameat,renameat2,link,"
    "linkat,symlink,symlinkat,unlink,unlinkat,mkdir,mkdirat,rmdir,ftruncate,truncate,fallocate,sendfile,"
    "copy_file_range"
)
_LINE = re.compile(r"\d+ +(?P<name>\w+)\((?P<arguments>.*)\) += (?P<result>-?\d+)(?:<(?P<opened>[^>]*)>)?.*")
_TEXT = re.compile(r'"((?:\\x[0-9a-f]{2})*)"')
_OF = re.compile(r"(-?\d+)<([^>]*)>")


@dataclass(frozen=True)
class Call:
    """One call that changed something below the folder: its name, the paths (relative), the data, the number.

    `number` is the offset of what is written, or the length of what is truncated.
    """

    name: str
    paths: tuple[str, ...]
    data: bytes = b""
    number: int = 0


def record(program: str, folder: Path, log: Path, more: Mapping[str, str] | None = None) -> list[Call]:
    """Runs a Python program, of which `sys.argv[1]` is the folder, and returns its calls on that folder."""
    command = ["strace", "-f", "-y", "-xx", "-s", str(1 << 26), "-e", f"trace={_TRACED}", "-o", str(log)]
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | dict(more or {})
    run = subprocess.run(
        [*command, sys.executable, "-c", program, str(folder)],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return list(_calls(log, folder))


def _calls(log: Path, folder: Path) -> Iterator[Call]:
    """The calls of a log that succeeded and were about the folder.

    A call during which another thread called is on two lines; they are joined where it ends.
    """
    begun: dict[str, str] = {}
    for line in log.read_text(encoding="ascii").splitlines():
        process = line.split(" ", 1)[0]
        if line.endswith("<unfinished ...>"):
            begun[process] = line.removesuffix("<unfinished ...>")
            continue
        if "<... " in line:
            line = begun.pop(process) + re.sub(r"^.*? resumed>", "", line)
        found = _LINE.fullmatch(line)
        if found is None or int(found["result"]) < 0:
            continue
        call = _call(found, folder)
        if call is not None:
            yield call


def _call(found: re.Match[str], folder: Path) -> Call | None:
    name, arguments = found["name"], found["arguments"]
    texts = [bytes.fromhex(text.replace("\\x", "")) for text in _TEXT.findall(arguments)]
    on = _OF.match(arguments)
    assert name not in ("writev", "pwritev", "pwritev2", "fallocate", "sendfile", "copy_file_range") or not (
        on and _inside(_decoded(on[2]), folder)
    ), f"{name}: not in the model"
    if name in ("open", "openat", "creat"):
        if not re.search(r"O_(CREAT|TRUNC)", arguments) or _inside(os.fsdecode(texts[0]), folder) is None:
            return None
        name = "create" if "O_TRUNC" in arguments else "open"
        return Call(name, (str(_inside(os.fsdecode(texts[0]), folder)),))
    if name in ("write", "pwrite64", "fsync", "fdatasync", "ftruncate"):
        path = _inside(_decoded(on[2]) if on else "", folder)
        if path is None:
            return None
        number = int(arguments.rsplit(", ", 1)[1]) if name in ("pwrite64", "ftruncate") else -1
        written = texts[0][: int(found["result"])] if texts else b""
        return Call({"fdatasync": "fsync", "pwrite64": "write"}.get(name, name), (path,), written, number)
    paths = [_inside(os.fsdecode(text), folder) for text in texts]
    if None in paths:
        assert all(path is None for path in paths), f"{name} across the folder's border"
        return None
    if name == "unlinkat":
        name = "rmdir" if "AT_REMOVEDIR" in arguments else "unlink"
    name = {"renameat": "rename", "renameat2": "rename", "linkat": "link", "mkdirat": "mkdir"}.get(name, name)
    return Call(name, tuple(str(path) for path in paths))


def _decoded(text: str) -> str:
    """A path that strace gives in hexadecimal numbers."""
    return os.fsdecode(bytes.fromhex(text.replace("\\x", ""))) if text.startswith("\\x") else text


def _inside(path: str, folder: Path) -> str | None:
    """A path relative to the folder ("." is the folder itself); None if it is elsewhere."""
    path = path.removesuffix(" (deleted)")
    if not path.startswith("/") or not Path(path).is_relative_to(folder):
        return None
    return str(Path(path).relative_to(folder))


@dataclass
class _File:
    data: bytearray = field(default_factory=bytearray)
    synced: bytes = b""


@dataclass
class _Folder:
    names: dict[str, _File | _Folder] = field(default_factory=dict)
    synced: dict[str, _File | _Folder] = field(default_factory=dict)


State = tuple[tuple[str, bytes | None], ...]  # the path and content of each file; None for a folder


class Disk:
    """A folder, and what of it is safe.  It begins as `folder` is now, all of it synced."""

    def __init__(self, folder: Path) -> None:
        self._root = _read(folder)
        self._position: dict[int, int] = {}

    def _at(self, path: str) -> _File | _Folder:
        node: _File | _Folder = self._root
        for part in Path(path).parts:
            assert isinstance(node, _Folder)
            node = node.names[part]
        return node

    def _folder(self, path: str) -> tuple[dict[str, _File | _Folder], str]:
        parent = self._at(str(Path(path).parent))
        assert isinstance(parent, _Folder)
        return parent.names, Path(path).name

    def play(self, call: Call) -> None:
        """Does what a call did."""
        if call.name == "fsync":
            node = self._at(call.paths[0])
            if isinstance(node, _Folder):
                node.synced = dict(node.names)
            else:
                node.synced = bytes(node.data)
            return
        names, name = self._folder(call.paths[-1])
        match call.name:
            case "create" | "open":
                file = names.setdefault(name, _File())
                assert isinstance(file, _File)
                if call.name == "create":
                    file.data.clear()
                    self._position[id(file)] = 0
            case "write":
                file = names[name]
                assert isinstance(file, _File)
                at = call.number if call.number >= 0 else self._position.get(id(file), 0)
                file.data.extend(bytes(max(0, at - len(file.data))))
                file.data[at : at + len(call.data)] = call.data
                self._position[id(file)] = at + len(call.data)
            case "ftruncate":
                file = names[name]
                assert isinstance(file, _File)
                del file.data[call.number :]
                file.data.extend(bytes(call.number - len(file.data)))
            case "mkdir":
                names[name] = _Folder()
            case "unlink" | "rmdir":
                del names[name]
            case "rename":
                source, old = self._folder(call.paths[0])
                names[name] = source.pop(old)
            case "link":
                names[name] = self._at(call.paths[0])
            case _:
                raise AssertionError(f"{call.name}: not in the model")

    def states(self) -> Iterator[tuple[str, State]]:
        """What a power cut may leave now: the least that is promised, names without data, or everything."""
        yield "only what was synced", _state(self._root, names=False, data=False)
        yield "all names, only synced data", _state(self._root, names=True, data=False)
        yield "everything", _state(self._root, names=True, data=True)


def _read(path: Path) -> _Folder:
    found = _Folder()
    for entry in path.iterdir():
        if entry.is_dir():
            found.names[entry.name] = _read(entry)
        else:
            content = entry.read_bytes()
            found.names[entry.name] = _File(bytearray(content), content)
    found.synced = dict(found.names)
    return found


def _state(folder: _Folder, *, names: bool, data: bool, before: str = "") -> State:
    found: list[tuple[str, bytes | None]] = []
    for name, node in sorted((folder.names if names else folder.synced).items()):
        if isinstance(node, _Folder):
            found.append((before + name, None))
            found += _state(node, names=names, data=data, before=f"{before}{name}/")
        else:
            found.append((before + name, bytes(node.data) if data else node.synced))
    return tuple(found)


def restore(state: State, folder: Path) -> None:
    """Makes a folder that holds a state."""
    folder.mkdir()
    for path, content in state:
        if content is None:
            (folder / path).mkdir()
        else:
            (folder / path).write_bytes(content)


def check_order(calls: Sequence[Call], temporary: re.Pattern[str]) -> list[str]:
    """Asserts that every file is written, synced, renamed and its folder synced, in this order.

    Files may be made under names that match `temporary` alone; folders have their own names synced before a
    file in them takes its own.  Returns the names that files took, in order.
    """
    unsynced: set[str] = set()
    folders: set[str] = set()
    taken: list[str] = []
    for k, call in enumerate(calls):
        path = call.paths[0]
        if call.name in ("create", "open", "write", "ftruncate"):
            assert temporary.search(path), f"{path} is written under its final name"
            unsynced.add(path)
        elif call.name == "mkdir":
            folders.add(path)
        elif call.name == "fsync":
            unsynced.discard(path)
            folders -= {made for made in folders if str(Path(made).parent) == path}
        elif call.name == "rename":
            source, target = call.paths
            assert source not in unsynced, f"{target} takes its name before its data are synced"
            folder = str(Path(target).parent)
            assert folder not in folders, f"{target}: the name of its folder is not synced"
            following = next((c for c in calls[k + 1 :] if c.paths != (source,)), None)
            assert following == Call("fsync", (folder,), b"", -1), f"{target}: its folder is synced too late"
            taken.append(target)
    return taken
