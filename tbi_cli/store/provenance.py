"""Where a results file comes from: its root attributes."""

from __future__ import annotations

import os
import shlex
import socket
import subprocess
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import tbi_cli
from tbi_cli.printable import printable
from tbi_cli.store.layout import Scalar


def provenance(
    *, case_yaml: str, case_sha256: str, command: Sequence[str], title: str = "", shard: str = ""
) -> dict[str, Scalar]:
    """The root attributes of a run's results file.

    ``command`` is the argument vector, ``shard`` is ``"I/N"`` or empty.  The git revision is there if tbi
    runs from a checkout, the job id if it runs under Slurm.
    """
    attributes: dict[str, Scalar] = {
        "title": title,
        "tbi_version": tbi_cli.__version__,
        "case": case_yaml,
        "case_sha256": case_sha256,
        "command": printable(shlex.join(command)),
        "folder": printable(_here()),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "host": printable(socket.gethostname()),
        "numpy_version": version("numpy"),
        "numba_version": version("numba"),
        "h5py_version": version("h5py"),
        "git_revision": _git_revision(),
        "shard": shard,
        "slurm_job_id": os.environ.get("SLURM_ARRAY_JOB_ID", os.environ.get("SLURM_JOB_ID", "")),
        "slurm_array_task_id": os.environ.get("SLURM_ARRAY_TASK_ID", ""),
    }
    return {name: value for name, value in attributes.items() if value != ""}


def _here() -> str:
    """The working folder, in which the command's paths begin; nothing where that is gone."""
    try:
        return str(Path.cwd())
    except OSError:
        return ""


def _git_revision() -> str:
    """The revision of the checkout that tbi runs from, ``-dirty`` appended if it was changed since."""
    checkout = Path(tbi_cli.__file__).resolve().parents[1]
    if not (checkout / ".git").exists():
        return ""
    command = ["git", "-C", str(checkout), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, timeout=5, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return answer.stdout.strip()
