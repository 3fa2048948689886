"""JSON Schema of the mappings and values of a case file, as the models of `tbi_cli.case` check them."""

from __future__ import annotations

import re
from typing import Any, Literal

from pydantic.fields import FieldInfo

from tbi_cli.case.axle_forces import AxleForces
from tbi_cli.case.bridge import COEFFICIENT, Bridge, Damping, Stations
from tbi_cli.case.builtin import builtin_names
from tbi_cli.case.consist import Consist, Vehicles
from tbi_cli.case.fields import SMALLEST, Accepts, AtMost, Choice, Quantity, Switch, Text, Whole
from tbi_cli.case.geometry import Geometry
from tbi_cli.case.keys import accepts, fields_of, is_list, part_of
from tbi_cli.case.part import Part
from tbi_cli.case.settings import HISTORY_WORDS, Histories
from tbi_cli.case.track import Irregularity, Profile, Random
from tbi_cli.case.train import TRAINS, VEHICLES
from tbi_cli.case.unit_patterns import unit_pattern
from tbi_cli.case.units import to_si
from tbi_cli.docstrings import docstring

Schema = dict[str, Any]

_NAMES: Schema = {"type": "array", "items": {"type": "string", "pattern": "^[a-z0-9_]+$"}, "minItems": 1}
CHANNELS: Schema = {"anyOf": [{"const": "all"}, _NAMES | {"uniqueItems": True}]}


class Parts:
    """Collects under `definitions` what is referred to."""

    def __init__(self) -> None:
        self.definitions: dict[str, Schema] = {}

    def define(self, name: str, schema: Schema) -> Schema:
        """A reference to a schema, which is kept once."""
        self.definitions.setdefault(name, schema)
        return {"$ref": f"#/$defs/{name}"}

    def train(self) -> Schema:
        """A train of any model."""
        return {"anyOf": [self.vehicle(model) for model in TRAINS]}

    def vehicle(self, model: str) -> Schema:
        """One vehicle, known by its `model`."""
        part = TRAINS[model]
        schema = self.mapping(part, {"model": {"const": model, "description": "which vehicle model this is"}})
        if "forces" in schema["properties"]:
            schema["properties"]["forces"] |= {"minItems": 1}
        if part is AxleForces:
            schema["required"] = ["model"]
            listed: Schema = {"required": ["positions", "forces"], "properties": {"csv": False}}
            in_file: Schema = {"required": ["csv"], "properties": {"positions": False, "forces": False}}
            schema["anyOf"] = [listed, in_file]
        if part is Consist:
            schema["required"] = ["consist"]
            schema["properties"]["consist"] |= {"minItems": 1}
        return self.define(part.__name__, schema)

    def vehicles(self) -> Schema:
        """A number of equal vehicles of a consist."""
        each = {
            "anyOf": [self.named("train"), *(self.vehicle(model) for model in VEHICLES)],
            "description": "the vehicle",
        }
        return self.define(Vehicles.__name__, self.mapping(Vehicles, {"vehicle": each}))

    def bridge(self) -> Schema:
        """The span and its beams."""
        return self.define("Bridge", self.mapping(Bridge))

    def named(self, kind: Literal["train", "bridge"]) -> Schema:
        """A train or a bridge by its name."""
        text = f"a file beside this one, or a built-in {kind}"
        return {"type": "string", "minLength": 1, "description": text, "examples": builtin_names(kind)}

    def mapping(self, part: type[Part], given: dict[str, Schema] | None = None) -> Schema:
        """A mapping with the keys of `part`; `given` are schemas that do not follow from the fields."""
        given = dict(given or {})
        properties: dict[str, Schema] = {}
        required = []
        for key, (_, info) in fields_of(part).items():
            if info.is_required():
                required.append(key)
            inner, leaf = part_of(info, None), accepts(info)
            if key in given:
                properties[key] = given.pop(key)
            elif inner is Damping:
                properties[key] = self.damping()
            elif inner is Histories:
                properties[key] = self.histories()
            elif inner is Stations:
                properties[key] = self.stations()
            elif inner is Vehicles:
                text = "the vehicles, the first in front"
                properties[key] = _list(self.vehicles(), info, text)
            elif inner is not None:
                properties[key] = self.define(inner.__name__, self.mapping(inner))
            elif leaf is not None:
                value = self.leaf(leaf)
                properties[key] = _list(value, info, leaf.text) if is_list(info) else value
        schema: Schema = {
            "type": "object",
            "description": _first_sentence(docstring(part)),
            "properties": properties | given,
            "required": required,
            "additionalProperties": False,
        }
        if part is Geometry:
            schema["allOf"] = [
                {"anyOf": [{"required": [whole]}, {"required": arms}]}
                for whole, arms in (
                    ("bogie_distance", ["l_b1", "l_b2"]),
                    ("wheelbase", ["l_w1", "l_w2", "l_w3", "l_w4"]),
                )
            ]
        if part is Irregularity:
            schema["minProperties"] = 1
        if part is Random:
            schema["required"] = ["spectrum"]
        if part is Profile:
            schema["required"] = []
            no_numbers: Schema = dict.fromkeys(("x", "right", "left"), False)
            listed: Schema = {"required": ["x", "right"], "properties": {"csv": False}}
            schema["anyOf"] = [listed, {"required": ["csv"], "properties": no_numbers}]
        return schema

    def leaf(self, leaf: Accepts) -> Schema:
        """One value."""
        schema: Schema
        if isinstance(leaf, Quantity):
            forms: list[Schema] = [self.quantity(leaf)]
            if leaf.words:
                forms.append({"enum": list(leaf.words)})
            schema = forms[0] if len(forms) == 1 else {"anyOf": forms}
            unit = "" if leaf.dimension.unit == "1" else f" [{leaf.dimension.unit}]"
            examples: list[Any] = [to_si(leaf.example, leaf.dimension.unit), *leaf.words]
            if " " in leaf.example:
                examples.insert(0, leaf.example)
            return schema | {"description": leaf.text + unit, "examples": examples}
        if isinstance(leaf, Whole):
            schema = {"type": "integer", "minimum": leaf.low, "maximum": leaf.high}
            if leaf.words:
                schema = {"anyOf": [schema, {"enum": list(leaf.words)}]}
            schema["examples"] = [leaf.low, *leaf.words]
        elif isinstance(leaf, Choice):
            schema = {"enum": list(leaf.words)}
        elif isinstance(leaf, Switch):
            schema = {"type": "boolean"}
        elif isinstance(leaf, Text) and leaf.longest:
            schema = {"type": "string", "maxLength": leaf.longest, "pattern": "^[^\\x00-\\x1f\\x7f]*$"}
        else:
            schema = {}
        return schema | {"description": leaf.text}

    def quantity(self, leaf: Quantity) -> Schema:
        """A number in SI or a text with a unit, by dimension and sign."""
        bounds: Schema = {"maximum": leaf.largest}
        if leaf.sign == "any":
            bounds["minimum"] = -leaf.largest
        else:
            bounds["minimum"] = SMALLEST if leaf.sign == "positive" else 0
        number: Schema = {"type": "number", **bounds}
        text: Schema = {"type": "string", "pattern": unit_pattern(leaf)}
        size = "" if leaf.largest == 1e15 else f"_to_{leaf.largest:g}"
        name = re.sub(r"\W+", "_", f"{leaf.sign} {leaf.dimension.noun}{size}")
        return self.define(name, {"anyOf": [number, text]})

    def damping(self) -> Schema:
        """The damping of a beam, in any of its forms."""
        forms = self.mapping(Damping)
        forms |= {"minProperties": 1, "maxProperties": 1}
        forms.pop("required")
        text = "c in N s/m^2, or {first_mode_ratio: ...}, or {ratio: ...} for all modes"
        return self.define("Damping", {"anyOf": [self.leaf(COEFFICIENT), forms], "description": text})

    def stations(self) -> Schema:
        """Places along the span."""
        mapping = self.mapping(Stations) | {"minProperties": 1, "maxProperties": 1}
        for places in mapping["properties"].values():
            places |= {"minItems": 1}
        text = "where the beams are looked at besides mid-span: positions, or fractions of the span"
        forms = [mapping["properties"]["positions"], mapping]
        return self.define("Stations", {"anyOf": forms, "description": text})

    def histories(self) -> Schema:
        """What is kept over time."""
        text = "all, or a list of channel names"
        mapping = self.mapping(Histories, {"channels": CHANNELS | {"description": text}})
        text = "which time histories are stored: none, all or some channels"
        return self.define(
            "Histories", {"anyOf": [{"enum": list(HISTORY_WORDS)}, mapping], "description": text}
        )


def _list(items: Schema, info: FieldInfo, text: str) -> Schema:
    most = next((item.most for item in info.metadata if isinstance(item, AtMost)), None)
    schema: Schema = {"type": "array", "items": items, "description": text}
    return schema if most is None else schema | {"maxItems": most}


def _first_sentence(text: str) -> str:
    return re.split(r"(?<=\.)\s", text, maxsplit=1)[0]
