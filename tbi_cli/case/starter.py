"""The commented case that `tbi init` writes."""

from __future__ import annotations

from dataclasses import dataclass
from string import Template
from textwrap import indent
from typing import Any

from tbi_cli.case.builtin import Kind, builtin_names, builtin_path, configs_folder
from tbi_cli.case.files import read_source
from tbi_cli.case.messages import CaseError, Problem, Source, quoted, suggestion
from tbi_cli.case.yaml12 import plain, read_yaml


@dataclass(frozen=True)
class _Kind:
    """What a starter says to a kind of train: the bridge it gets, a number to change, its beams in words."""

    bridge: str
    example: str
    beams: str


_DECK = "One simply supported beam, the whole deck: forces have no left and right."
_BEAMS = "Two simply supported beams of the same length, the right and the left one."
_KINDS = {
    "full-31dof": _Kind("simply-supported", "train.car_body.mass='45 t'", _BEAMS),
    "consist": _Kind("simply-supported", "train.consist.1.count=4", _BEAMS),
    "hslm-a": _Kind("whole-deck", "train.number=2", _DECK),
}


def starter_case(train: str = "paper", bridge: str | None = None) -> str:
    """The text of a case file with a built-in train and bridge, the bridge written out to be changed.

    Without a bridge the train gets one with as many beams as it runs on.  Raises CaseError when there is no
    such train or bridge, or when the bridge has not the beams that the train needs.
    """
    kind = _KINDS[_mapping(_source("train", train)).get("model", "consist")]
    bridge = bridge or kind.bridge
    beams = _source("bridge", bridge)
    if ("left" in _mapping(beams)) != (kind.beams == _BEAMS):
        text = "it has one beam only; the train needs two"
        if kind.beams == _DECK:
            text = f"it has two beams; the train {train} needs one for the whole deck, e.g. {kind.bridge}"
        raise CaseError([Problem(None, f"--bridge {quoted(bridge)}", text)])
    template = (configs_folder() / "templates" / "case.yaml").read_text(encoding="utf-8")
    lines = [line for line in beams.text.splitlines() if not line.startswith("#")]
    return Template(template).substitute(
        train=train, example=kind.example, beams=kind.beams, bridge=indent("\n".join(lines), "  ")
    )


def _mapping(source: Source) -> dict[str, Any]:
    found: dict[str, Any] = plain(read_yaml(source)[0])
    return found


def _source(kind: Kind, name: str) -> Source:
    path = builtin_path(kind, name)
    if path is None:
        text = f"no built-in {kind} of that name; {suggestion(name, builtin_names(kind))}"
        raise CaseError([Problem(None, f"--{kind} {quoted(name)}", text)])
    return read_source(path, name)
