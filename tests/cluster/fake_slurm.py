"""Commands by the names of Slurm's, which say what a test wants to hear."""

from __future__ import annotations

from pathlib import Path


def fake_slurm(folder: Path, **answers: bytes) -> Path:
    """Puts sbatch, scontrol, squeue and scancel into a new folder, which is returned, to be put into PATH.

    Each prints its answer, which is empty but for the number of a job from sbatch; one whose answer begins
    with `!` prints the rest as an error and fails.
    """
    folder.mkdir()
    for name in ("sbatch", "scontrol", "squeue", "scancel"):
        answer = answers.get(name, b"17\n" if name == "sbatch" else b"")
        failed = answer.startswith(b"!")
        (folder / f"{name}.answer").write_bytes(answer.removeprefix(b"!"))
        text = f'#!/bin/sh\ncat "$0.answer" >&{2 if failed else 1}\nexit {int(failed)}\n'
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    return folder
