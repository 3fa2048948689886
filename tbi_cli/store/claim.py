"""Taking possession of the place of a results file, before anything is solved for it."""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path

from tbi_cli.advice import ANOTHER_FILE
from tbi_cli.store.durable import UNFINISHED, sync_folder
from tbi_cli.store.errors import ExistsError, PlaceError, StoreError
from tbi_cli.store.lock import LOCK_FILE, Lock, refuse_if_held
from tbi_cli.store.opening import Run, is_there, look_first, resolve
from tbi_cli.store.parts import LAYOUT_FILE, STUDIES_FILE, UNSETTLED_FILE, part_number, parts_folder
from tbi_cli.store.safe import looks_like_hdf5

_SUFFIXES = {".h5", ".hdf5", ".hdf", ".nc", ".nc4", ""}


def check_output(
    path: str | os.PathLike[str], *, resume: bool = False, overwrite: bool = False, resumes: bool = True
) -> Path:
    """Raise `StoreError` if a results file may not be written at ``path``; changes nothing.

    ``resumes`` says whether the command is one that can resume.  Returns the path with links followed.
    """
    if resume and overwrite:
        raise StoreError("--resume and --overwrite exclude each other")
    path = resolve(path)
    is_there(path)  # or it cannot be told, which is to be said of the file itself
    refuse_if_held(parts_folder(path), path)
    check_path(path, resume=resume, overwrite=overwrite, resumes=resumes)
    return path


def check_path(path: Path, *, resume: bool, overwrite: bool, resumes: bool = True) -> None:
    """As `check_output`, of a path whose links are followed and whose lock is of no concern."""
    try:
        _check_place(path)
        if path.exists() and not resume:
            if not overwrite:
                if not looks_like_hdf5(path):
                    raise StoreError(f"{path}: exists already and is no results file; {ANOTHER_FILE}")
                resume_it = "--resume completes it" if resumes else ANOTHER_FILE
                raise ExistsError(f"{path}: exists already; {resume_it}, --overwrite replaces it")
            if path.suffix not in _SUFFIXES and path.stat().st_size and not looks_like_hdf5(path):
                raise StoreError(f"{path}: is not a results file, and is not replaced by one")
    except OSError as error:
        raise StoreError.from_os(path, error) from error
    if not resume and not overwrite:
        try:
            _refuse_unfinished_run(path, resumes)
        except OSError as error:
            raise StoreError.from_os(parts_folder(path), error) from error


def _check_place(path: Path) -> None:
    folder = path.parent
    if not folder.exists():
        raise PlaceError(f"{path}: the folder {folder} does not exist")
    if not folder.is_dir():
        raise PlaceError(f"{path}: {folder} is not a folder")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PlaceError(f"{path}: the folder {folder} cannot be written to")
    if path.exists():
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise PlaceError(f"{path}: is a folder; name a file in it")
        if not stat.S_ISREG(mode):
            raise PlaceError(f"{path}: is not a regular file")


def _refuse_unfinished_run(path: Path, resumes: bool) -> None:
    folder = parts_folder(path)
    several = is_there(folder / STUDIES_FILE)
    solved = size = 0
    for study in sorted(p.name for p in folder.iterdir() if p.is_dir()) if several else [""]:
        look_first(path, study)
        run = Run.read(path, study)
        if run is None:
            continue
        with run.results() as results:
            solved, size = solved + int((results.status != 0).sum()), size + results.layout.size
    if size and any(part_number(p) is not None for p in folder.rglob("*.h5")):
        resume_it = "--resume continues it" if resumes else ANOTHER_FILE
        raise ExistsError(
            f"{folder}: holds an unfinished run, {solved} of {size} cases; "
            f"{resume_it}, --overwrite starts afresh"
        )


class Claim:
    """A results file's parts folder, made and locked for this process; or that of one study, within.

    Raises `StoreError`, with nothing left behind, if that cannot be.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.folder = parts_folder(path)
        self._within = False
        self._lock = self._acquire()

    def study(self, name: str) -> Claim:
        """The folder of one study, made if need be: locked as this one is, and given up with it."""
        inner = object.__new__(Claim)
        inner.path, inner.folder = self.path, parts_folder(self.path, name)
        inner._within, inner._lock = True, self._lock
        try:
            inner.folder.mkdir(exist_ok=True)
            sync_folder(self.folder)
        except OSError as error:
            raise StoreError.from_os(inner.folder, error) from error
        return inner

    def _acquire(self) -> Lock:
        error: OSError | None = None
        for _ in range(5):
            try:
                self.folder.mkdir(exist_ok=True)
                lock = Lock(self.folder, self.path)
                sync_folder(self.path.parent)
                return lock
            except FileNotFoundError as vanished:  # a process that has just finished removed the folder
                error = vanished
            except OSError as refused:
                self._remove_empty_folder()
                raise StoreError.from_os(self.folder, refused) from refused
        raise StoreError.from_os(self.folder, error or OSError())

    def check(self) -> None:
        """Raise `StoreError` if the folder is no longer this process's own."""
        if not self._lock.is_held():
            raise StoreError(f"{self.folder}: was removed or taken over while the run went on")
        self._lock.touch()

    def files(self) -> list[Path]:
        """What is in the folder."""
        try:
            return list(self.folder.iterdir())
        except OSError:
            return []

    @property
    def has_parts(self) -> bool:
        """Whether any batch is in the folder, of whatever run, that is not in a results file yet."""
        return any(part_number(path) is not None for path in self.folder.rglob("*.h5"))

    def clean(self, *, parts: bool) -> None:
        """Remove what dead runs left half written; with ``parts``, all that the run itself has stored too.

        The layout goes first: without it the parts mean nothing, so a crash here cannot leave half a run.
        """
        with contextlib.suppress(OSError):
            if parts:
                for name in (LAYOUT_FILE, STUDIES_FILE, UNSETTLED_FILE):
                    (self.folder / name).unlink(missing_ok=True)
                sync_folder(self.folder)
                for path in self.files():
                    if path.is_dir() and not path.is_symlink():
                        study = self.study(path.name)
                        study.clean(parts=True)
                        study.release()
            for path in self.files():
                if (
                    path.name.endswith(UNFINISHED)
                    or path.name.startswith(f"{LOCK_FILE}.")
                    or (parts and path.suffix == ".h5")
                ):
                    path.unlink()

    def release(self) -> None:
        """Give the place up; an empty folder goes too."""
        if not self._within:
            self._lock.release()
        self._remove_empty_folder()

    def _remove_empty_folder(self) -> None:
        with contextlib.suppress(OSError):
            self.folder.rmdir()
            sync_folder(self.path.parent)
