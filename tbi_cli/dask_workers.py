"""Batches solved by a Dask cluster, through joblib's own Dask backend."""

from __future__ import annotations

import logging
import re
import threading
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import CancelledError
from types import TracebackType
from typing import Any

from tbi_cli.errors import RunFailedError, UserError
from tbi_cli.workers import Indices, Numbered, RemoteSolver, in_background, parallel

_SECONDS_TO_ANSWER = 10.0
_SECONDS_FOR_A_WORKER = 30.0
_SAFE = "what was finished is safe"


class DaskCrew:
    """The workers of a Dask cluster.  A batch whose worker is lost goes to another one.

    Raises UserError if Dask is not installed or no scheduler answers at the address.
    """

    def __init__(self, address: str, solve: RemoteSolver, halted: threading.Event) -> None:
        self._address, self._solve, self._halted = address, solve, halted
        self._client = _connect(address)

    @property
    def solve(self) -> Callable[[int, Indices], Numbered]:
        """Solves a batch."""
        return self._solve

    def __enter__(self) -> DaskCrew:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._client.close(timeout=_SECONDS_TO_ANSWER)

    def results(self, tasks: Iterator[Any]) -> Generator[Numbered, None, None]:
        """What the tasks return, as they end; those under way are cancelled once halted."""
        from joblib import parallel_config

        with parallel_config(backend="dask", client=self._client):
            everywhere = parallel(-1)
        try:
            yield from in_background(everywhere, tasks, self._halted, self._cancel, self._check)
        except Exception as error:
            self._check()
            if isinstance(error, CancelledError):
                raise RunFailedError(
                    f"the Dask scheduler at {self._address} was lost; {_SAFE}"
                ).kept() from None
            if isinstance(error, TimeoutError):
                raise RunFailedError(
                    f"the Dask cluster at {self._address} has no workers any more; {_SAFE}"
                ).kept() from None
            raise

    def _cancel(self) -> None:
        from distributed import Future

        self._client.cancel([Future(key, self._client) for key in list(self._client.futures)])

    def _check(self) -> None:
        """Raises RunFailedError if a task will never end: joblib waits for what Dask has given up."""
        if self._client.status != "running":
            raise RunFailedError(f"the Dask scheduler at {self._address} was lost; {_SAFE}").kept()
        for state in list(self._client.futures.values()):
            if state.status == "error":
                raise RunFailedError(
                    f"the Dask cluster at {self._address} gave up a batch: {state.exception}; {_SAFE}"
                ).kept()


def _connect(address: str) -> Any:
    """A client of the cluster, once it has a worker."""
    if not re.fullmatch(r"((tcp|tls|ucx|ws|wss)://)?(\[[0-9a-fA-F:]+\]|[^\s:/]+):\d+", address):
        raise UserError(f"--scheduler: expected an address such as tcp://10.0.0.1:8786, got {address!r}")
    try:
        import distributed
    except ImportError:
        raise UserError("--backend dask: Dask is not installed; pip install 'tbi-cli[dask]'") from None
    for name in ("distributed", "distributed.client", "tornado", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what matters of it is told in our messages
    make_client: Any = distributed.Client  # it has no types
    try:
        client = make_client(address, timeout=_SECONDS_TO_ANSWER, set_as_default=False)
    except (OSError, ValueError) as error:
        raise UserError(f"--scheduler: no Dask scheduler answers at {address} ({error})") from None
    try:
        client.wait_for_workers(1, timeout=_SECONDS_FOR_A_WORKER)
    except TimeoutError:
        client.close()
        raise UserError(f"--scheduler: the Dask scheduler at {address} has no workers") from None
    return client
