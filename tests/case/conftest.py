"""A folder to write case files in, and what loading them says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tbi_cli.case import Case, CaseError, load_case

Says = Callable[..., str]
Loads = Callable[..., Case]

CASE = """\
train: paper
bridge:
  length: 50 m
  modes: 4
  right:
    youngs_modulus: 207 GPa
    second_moment: 0.2
    mass_per_length: 20 t/m
    damping: 10 kN*s/m^2
  left: {youngs_modulus: 200 GPa, second_moment: 0.2, mass_per_length: 18 t/m, damping: 10 kN*s/m^2}
velocity: 300 km/h
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def loads(folder: Path) -> Loads:
    """Writes a text as case.yaml and loads it."""

    def load(text: str = CASE, **options: Any) -> Case:
        (folder / "case.yaml").write_text(text, encoding="utf-8")
        return load_case("case.yaml", **options)

    return load


@pytest.fixture
def says(loads: Loads) -> Says:
    """Writes a text as case.yaml, which must not load, and returns the whole message."""

    def message(text: str = CASE, **options: Any) -> str:
        with pytest.raises(CaseError) as caught:
            loads(text, **options)
        return str(caught.value)

    return message
