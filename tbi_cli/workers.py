"""Where batches are solved: in threads of this process, in processes beside it, or by a Dask cluster.

joblib does the work in all three.  Whatever the place, a scenario goes through the same compiled kernel in a
lane of its own, so its bits are the same.  Results come back to this process, which alone writes.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import socket
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

import tbi_cli
from tbi_cli.errors import RunFailedError, UserError
from tbi_cli.integrator.kernel_cache import compile_kernels, fingerprint
from tbi_cli.resources import available_cpus, available_memory
from tbi_cli.store.records import BatchResult
from tbi_cli.studies import AnySolver, kernels_of, solver_of

BACKENDS = ("threads", "processes", "dask")

Indices = NDArray[np.int64]
Numbered = tuple[int, BatchResult | None]
# Worker processes may be killed by the system (out of memory); batches that go on killing them are given up.
_LOST_IN_A_ROW = 3
_SECONDS_BETWEEN_LOOKS = 0.1
_SECONDS_TO_END = 5.0


@dataclass(frozen=True)
class Workers:
    """Who solves: the backend, how many batches at a time (None: this job's CPUs), and Dask's address."""

    backend: str = "threads"
    jobs: int | None = None
    scheduler: str | None = None

    def check(self) -> None:
        """Raises UserError for options that do not go together."""
        if self.backend not in BACKENDS:
            raise UserError(f"--backend: expected one of {', '.join(BACKENDS)}; got {self.backend!r}")
        if self.scheduler is not None and self.backend != "dask":
            raise UserError("--scheduler: only --backend dask has a scheduler")
        if self.backend == "dask" and self.scheduler is None:
            raise UserError("--backend dask: needs --scheduler ADDRESS, e.g. tcp://10.0.0.1:8786")
        if self.backend == "dask" and self.jobs is not None:
            raise UserError(
                "--jobs: the workers of a Dask cluster decide how many batches are solved at a time"
            )


def solve_batches(
    solver: AnySolver, batches: Iterable[Indices], sizes: Indices, workers: Workers, halted: threading.Event
) -> Generator[BatchResult, None, None]:
    """The results of batches as they are finished, in any order.

    `sizes` (n,) are the bytes of each scenario's history: no more batches are under way, or solved and not
    yet taken, than memory has room for.  The batch of a worker that dies is solved again.  Ends early once
    `halted` is set, and sets it if the caller leaves early.  Raises RunFailedError if workers keep dying or
    the Dask cluster is lost.
    """
    todo = deque(enumerate(batches))
    room = available_memory() // 4
    lost = 0
    with _crew(solver, workers, len(todo), halted) as crew:
        while todo and not halted.is_set():
            under_way: dict[int, Indices] = {}
            try:
                tasks = _tasks(crew.solve, todo, under_way, sizes, room, halted)
                with contextlib.closing(crew.results(tasks)) as results:
                    for number, result in results:
                        if result is not None:
                            lost = 0
                            yield result
                        del under_way[number]
            except BrokenProcessPool:
                lost += 1
                if lost == _LOST_IN_A_ROW:
                    raise RunFailedError(
                        f"worker processes died {lost} times in a row before a batch was finished (out of "
                        "memory? fewer --jobs need less of it); what was finished before is safe"
                    ).kept() from None
            todo.extendleft(under_way.items())


def _tasks(
    solve: Callable[[int, Indices], Numbered],
    todo: deque[tuple[int, Indices]],
    under_way: dict[int, Indices],
    sizes: Indices,
    room: int,
    halted: threading.Event,
) -> Iterator[Any]:
    """Tasks for joblib, as long as the histories under way leave room; the others are for the next round."""
    from joblib import delayed

    while todo and not halted.is_set():
        number, batch = todo[0]
        taken = sum(int(sizes[other].sum()) for other in list(under_way.values()))
        if taken and taken + int(sizes[batch].sum()) > room:
            return
        under_way[number] = batch
        todo.popleft()
        yield delayed(solve)(number, batch)


class _Crew(Protocol):
    """A kind of workers."""

    @property
    def solve(self) -> Callable[[int, Indices], Numbered]:
        """Solves a batch and gives its number back with the result."""

    def results(self, tasks: Iterator[Any]) -> Generator[Numbered, None, None]:
        """What the tasks return, as they end."""


@contextlib.contextmanager
def _crew(solver: AnySolver, workers: Workers, batches: int, halted: threading.Event) -> Iterator[_Crew]:
    jobs = max(1, min(workers.jobs or available_cpus(), batches))
    if workers.backend == "dask":
        from tbi_cli.dask_workers import DaskCrew

        with DaskCrew(str(workers.scheduler), RemoteSolver.of(solver), halted) as crew:
            yield crew
    elif workers.backend == "processes" and jobs > 1:
        with _Processes(jobs, solver, halted) as crew:
            yield crew
    else:
        yield _Threads(jobs, solver, halted)


class _Threads:
    """Threads of this process.  The kernel holds no lock, and the case and its models are shared.

    A thread takes its next batch when the one before is on disk: a crash costs one batch a thread at most.
    """

    def __init__(self, jobs: int, solver: AnySolver, halted: threading.Event) -> None:
        self._jobs, self._solver, self._halted = jobs, solver, halted
        self._free = threading.Semaphore(jobs)

    def solve(self, number: int, batch: Indices) -> Numbered:
        """Solves a batch, once one before it is on disk; it notices by itself that it should stop."""
        while not self._free.acquire(timeout=_SECONDS_BETWEEN_LOOKS):
            if self._halted.is_set():
                return number, None
        return number, self._solver.solve(batch)

    def results(self, tasks: Iterator[Any]) -> Generator[Numbered, None, None]:
        """What the tasks return, as they end."""
        results = parallel(self._jobs, "threading")(tasks)
        try:
            while (result := next(results, None)) is not None:
                yield result
                self._free.release()  # the caller has it on disk
        except GeneratorExit:
            self._halted.set()
            for _ in results:
                pass
            raise


class _Processes:
    """Processes of this machine, for what holds Python's lock: making a model for every scenario."""

    def __init__(self, jobs: int, solver: AnySolver, halted: threading.Event) -> None:
        self._jobs, self._halted = jobs, halted
        descriptor, name = tempfile.mkstemp(prefix="tbi-run-")
        os.close(descriptor)
        self._token = Path(name)
        self._solve = RemoteSolver.of(solver, Master(os.getpid(), name))

    def __enter__(self) -> _Processes:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        from joblib.externals.loky import get_reusable_executor

        if self._token.exists():
            get_reusable_executor(reuse=True).shutdown(wait=True)
            self._dismiss()

    @property
    def solve(self) -> Callable[[int, Indices], Numbered]:
        """Solves a batch; the process ends when it should stop."""
        return self._solve

    def results(self, tasks: Iterator[Any]) -> Generator[Numbered, None, None]:
        """What the tasks return, as they end; those under way are dropped once halted."""
        return in_background(parallel(self._jobs, "loky"), tasks, self._halted, self._dismiss)

    def _dismiss(self) -> None:
        """Ends the processes.  joblib's own ways to do so wait for what they should end."""
        self._token.unlink(missing_ok=True)


def parallel(jobs: int, backend: str | None = None) -> Any:
    """joblib's Parallel.  One batch is one task, to be on disk as soon as it is solved."""
    from joblib import Parallel

    return Parallel(n_jobs=jobs, backend=backend, batch_size=1, return_as="generator_unordered")


def in_background(
    parallel: Any,
    tasks: Iterator[Any],
    halted: threading.Event,
    interrupt: Callable[[], None],
    check: Callable[[], None] = lambda: None,
) -> Generator[Numbered, None, None]:
    """What the tasks return, as they end, waited for by a thread of its own: this one can stop at any time.

    Once `halted`, or if the caller leaves early, `interrupt` has to make the tasks end, be it by an error.
    `check` is called now and then and raises if no result will come any more.
    """
    made: queue.SimpleQueue[Numbered | BaseException | None] = queue.SimpleQueue()

    def wait() -> None:
        try:
            for result in parallel(tasks):
                made.put(result)
            made.put(None)
        except BaseException as error:
            made.put(error)

    waiting = threading.Thread(target=wait, daemon=True)
    waiting.start()
    try:
        while not halted.is_set():
            try:
                result = made.get(timeout=_SECONDS_BETWEEN_LOOKS)
            except queue.Empty:
                check()
                continue
            if isinstance(result, BaseException):
                raise result
            if result is None:
                return
            yield result
    except GeneratorExit:
        halted.set()
        raise
    finally:
        if waiting.is_alive():
            interrupt()
            waiting.join(timeout=_SECONDS_TO_END)


@dataclass(frozen=True)
class Master:
    """The process that worker processes belong to, and a file that is there as long as it needs them."""

    process: int
    token: str


@dataclass(frozen=True)
class RemoteSolver:
    """Solves batches of a case in another process, where the case is unpickled once.

    A worker with a `master` ends with it.
    """

    case: bytes = field(repr=False)
    version: str
    master: Master | None = None

    @classmethod
    def of(cls, solver: AnySolver, master: Master | None = None) -> RemoteSolver:
        """The remote twin of a solver."""
        return cls(pickle.dumps(solver.case.standing_at(None)), code_version(), master)

    def __str__(self) -> str:
        return "tbi batch"  # what Dask calls it

    def __call__(self, number: int, batch: Indices) -> Numbered:
        """The number and the result of a batch.  Raises RunFailedError if the worker's tbi is another one."""
        if code_version() != self.version:
            raise RunFailedError(
                f"a worker on {socket.gethostname()} runs {code_version()}, this is {self.version}"
            )
        if self.master is not None:
            _end_with(self.master)
        return number, _twin(self.case).solve(batch)


@lru_cache(maxsize=2)
def _twin(case: bytes) -> AnySolver:
    """The solver in a worker process."""
    solver = solver_of(pickle.loads(case))
    compile_kernels(lambda text: None, kernels_of(solver))
    return solver


@lru_cache
def _end_with(master: Master) -> None:
    """Ends this process soon after its master is gone, or has no more use for it."""

    def watch() -> None:
        while os.getppid() == master.process and Path(master.token).exists():
            time.sleep(_SECONDS_BETWEEN_LOOKS)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def code_version() -> str:
    """tbi's version, and what its compiled kernels are made of."""
    return f"tbi {tbi_cli.__version__} (integrator {fingerprint()})"
