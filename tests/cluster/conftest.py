"""The case that the tests here share, solved once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from tbi_cli.case import Case, load_case
from tbi_cli.runner import Options, run
from tests.cluster.runs import CASE, SLOW, content, inside
from tests.cluster.slurm_here import SlurmHere, why_not


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the case in it."""
    (tmp_path / "case.yaml").write_text(CASE)
    return tmp_path


@pytest.fixture(scope="session")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """The case."""
    file = tmp_path_factory.mktemp("case") / "case.yaml"
    file.write_text(CASE)
    return load_case(file)


@pytest.fixture(scope="session")
def whole(case: Case, tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, bytes]:
    """What an undisturbed run gives, all in one."""
    path = tmp_path_factory.mktemp("whole") / "whole.h5"
    run(case, Options(output=path))
    return content(path)


@pytest.fixture(scope="session")
def whole_slow(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, bytes]:
    """What an undisturbed run of the slow version gives."""
    place = tmp_path_factory.mktemp("whole")
    (place / "case.yaml").write_text(CASE)
    assert inside("run", "case.yaml", "-q", *SLOW, folder=place).code == 0
    return content(place / "results.h5")


@pytest.fixture(scope="module")
def slurm() -> Iterator[SlurmHere]:
    """A running Slurm."""
    if reason := why_not():
        pytest.skip(reason)
    cluster = SlurmHere(max_array_size=4)
    yield cluster
    cluster.stop()
