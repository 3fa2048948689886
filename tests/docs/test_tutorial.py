"""What the tutorial and the how-to pages tell a reader to type works as it stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.docs.pages import DOCS, follow


def test_every_command_of_the_tutorial(tmp_path: Path) -> None:
    printed = follow(DOCS / "tutorial.md", tmp_path)
    assert "refused, with exit code 2" in printed
    assert "did you mean length?" in printed
    folder = tmp_path / "my-bridge"
    assert (folder / "results-report" / "report.html").is_file()
    assert (folder / "results-tables" / "daf.csv").is_file()
    assert all((folder / f"{name}.h5").is_file() for name in ("results", "one", "lighter", "spans"))


@pytest.mark.parametrize("name", ["train", "bridge", "sweep", "fast-train", "slurm", "notebook"])
def test_every_command_of_a_how_to_page(name: str, tmp_path: Path) -> None:
    follow(DOCS / "how-to" / f"{name}.md", tmp_path)
