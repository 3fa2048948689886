"""The paper's whole campaign, run once by its documented command and shared by all tests and test workers."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tbi_cli.report.study import Study, open_studies
from tests.cli.commands import tbi


@pytest.fixture(scope="session")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that `tbi reproduce` fills."""
    workers = "PYTEST_XDIST_WORKER" in os.environ
    base = tmp_path_factory.getbasetemp().parent if workers else tmp_path_factory.getbasetemp()
    folder, done = base / "campaign", base / "campaign-done"
    try:
        (base / "campaign-lock").mkdir()
    except FileExistsError:
        for _ in range(1200):
            if done.exists():
                break
            time.sleep(0.1)
    if not done.exists():
        ended = tbi("reproduce", "-o", str(folder), "-q", folder=base, patience=600)
        assert ended.code == 0, ended.err
        done.touch()
    return folder


@pytest.fixture(scope="session")
def results(campaign: Path) -> list[Path]:
    """The results files of the campaign."""
    return sorted(campaign.glob("*.h5"))


@pytest.fixture
def studies(results: list[Path]) -> Iterator[list[Study]]:
    """The campaign, opened."""
    opened = open_studies(results)
    yield opened
    for study in opened:
        study.results.close()
