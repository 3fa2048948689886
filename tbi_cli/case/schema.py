"""JSON Schema (draft 2020-12) of the files as they are written, units included, for editors."""

from __future__ import annotations

from typing import Literal

from tbi_cli.case.document import STUDIES
from tbi_cli.case.keys import accepts, fields_of
from tbi_cli.case.model import Case
from tbi_cli.case.schema_parts import Parts, Schema
from tbi_cli.case.schema_sweep import SweepSchema
from tbi_cli.case.studies import MOST_STUDIES, NAME
from tbi_cli.case.train import TRAINS, VEHICLES

Kind = Literal["case", "train", "bridge"]
SIMPLE = [model for model in VEHICLES if model != "full-31dof"]


def json_schema(kind: Kind = "case") -> Schema:
    """The schema of a case file, or of a train or a bridge that stands in a file of its own."""
    parts = Parts()
    body = _case(parts) if kind == "case" else parts.train() if kind == "train" else parts.bridge()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"tbi {kind} file",
        **body,
        "$defs": dict(sorted(parts.definitions.items())),
    }


def _case(parts: Parts) -> Schema:
    train = {
        "anyOf": [parts.named("train"), *(parts.vehicle(model) for model in TRAINS)],
        "description": "the train",
    }
    bridge = {"anyOf": [parts.named("bridge"), parts.bridge()], "description": "the bridge"}
    schema = parts.mapping(Case, {"train": train, "bridge": bridge, "sweep": SweepSchema(parts).schema()})
    # A velocity that is swept may be left out.
    schema["required"].remove("velocity")
    over: Schema = {"sample": {"required": ["over"], "properties": {"over": {"required": ["velocity"]}}}}
    swept = [{"required": ["velocity"]}, {"required": ["sample"], "properties": over}]
    sweep: Schema = {"required": ["sweep"], "properties": {"sweep": {"anyOf": swept}}}
    schema["anyOf"] = [{"required": ["velocity"]}, sweep]
    full, simple = (
        {"required": ["train"], "properties": {"train": _vehicle_in(models)}}
        for models in (["full-31dof"], SIMPLE)
    )
    no_left: Schema = {"bridge": {"properties": {"left": False}}}
    no_paper: Schema = {"contact": {"properties": {"static_load": {"const": "physical"}}}}
    inline: Schema = {"bridge": {"if": {"type": "object"}, "then": {"required": ["left"]}}}
    schema["allOf"] = [
        {"if": simple, "then": {"properties": no_left | no_paper}},
        {"if": full, "then": {"properties": inline}},
    ]
    # With studies each of them is a case, and what stands outside of them may lack anything.
    whole = {key: schema.pop(key) for key in ("required", "anyOf", "allOf")}
    schema["properties"][STUDIES] = _studies(parts, schema["properties"])
    return schema | {"if": {"not": {"required": [STUDIES]}}, "then": whole}


def _studies(parts: Parts, keys: dict[str, Schema]) -> Schema:
    """Cases by name, each by what it changes: keys of the case, whole, in part or dotted."""
    partial = {key for key, (_, info) in fields_of(Case).items() if accepts(info) is None}
    changes: dict[str, Schema] = {}
    for key, schema in keys.items():
        words = ["string"] if key in ("train", "bridge") else []
        part: Schema = {"type": ["object", "null", *words], "description": f"changes of {key}"}
        either: Schema = {"anyOf": [schema, {"type": "null"}], "description": f"{key} of this study"}
        changes[key] = part if key in partial else either
    study: Schema = {
        "type": "object",
        "description": "what one study changes; null takes a key away",
        "properties": changes,
        "patternProperties": {rf"^({'|'.join(sorted(partial))})\.": {}},
        "additionalProperties": False,
    }
    return {
        "type": "object",
        "description": "cases that are solved as one run, by name: the rest of this file, changed",
        "additionalProperties": False,
        "patternProperties": {f"^{NAME}$": parts.define("Study", study)},
        "minProperties": 1,
        "maxProperties": MOST_STUDIES,
    }


def _vehicle_in(models: list[str]) -> Schema:
    return {"type": "object", "required": ["model"], "properties": {"model": {"enum": models}}}
