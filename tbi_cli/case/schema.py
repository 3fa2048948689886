"""JSON Schema (draft 2020-12) of the files as they are written, units included, for editors."""

from __future__ import annotations

import re
from typing import Any, Literal

from tbi_cli.case.axes import SHORT_NAMES
from tbi_cli.case.axle_forces import AxleForces
from tbi_cli.case.bridge import COEFFICIENT, MOST_STATIONS, Bridge, Damping, Stations
from tbi_cli.case.builtin import builtin_names
from tbi_cli.case.consist import Consist, Vehicles
from tbi_cli.case.fields import SMALLEST, Accepts, Choice, Quantity, Switch, Text, Whole
from tbi_cli.case.geometry import Geometry
from tbi_cli.case.keys import accepts, fields_of, find_number, is_list, numeric_keys, part_of
from tbi_cli.case.model import Case
from tbi_cli.case.part import Part
from tbi_cli.case.refinement import Refine
from tbi_cli.case.sample import DISTRIBUTIONS, KINDS, WITHIN
from tbi_cli.case.settings import HISTORY_WORDS, Histories
from tbi_cli.case.simple_vehicles import MOST_FORCES
from tbi_cli.case.studies import MOST_STUDIES, NAME, STUDIES
from tbi_cli.case.track import Irregularity, Profile, Random
from tbi_cli.case.train import TRAINS, VEHICLES
from tbi_cli.case.unit_patterns import unit_pattern
from tbi_cli.case.units import to_si

Schema = dict[str, Any]
Kind = Literal["case", "train", "bridge"]
SIMPLE = [model for model in VEHICLES if model != "full-31dof"]


def json_schema(kind: Kind = "case") -> Schema:
    """The schema of a case file, or of a train or a bridge that stands in a file of its own."""
    writer = _Writer()
    body = {"case": writer.case, "train": writer.train, "bridge": writer.bridge}[kind]()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"tbi {kind} file",
        **body,
        "$defs": dict(sorted(writer.definitions.items())),
    }


class _Writer:
    """Collects under `definitions` what is referred to."""

    def __init__(self) -> None:
        self.definitions: dict[str, Schema] = {}

    def define(self, name: str, schema: Schema) -> Schema:
        self.definitions.setdefault(name, schema)
        return {"$ref": f"#/$defs/{name}"}

    def case(self) -> Schema:
        train = {
            "anyOf": [self.named("train"), *(self.vehicle(model) for model in TRAINS)],
            "description": "the train",
        }
        bridge = {"anyOf": [self.named("bridge"), self.bridge()], "description": "the bridge"}
        schema = self.mapping(Case, {"train": train, "bridge": bridge, "sweep": self.sweep()})
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
        schema["properties"][STUDIES] = self.studies(schema["properties"])
        return schema | {"if": {"not": {"required": [STUDIES]}}, "then": whole}

    def studies(self, keys: dict[str, Schema]) -> Schema:
        """Cases by name, each by what it changes: keys of the case, whole, in part or dotted."""
        parts = {key for key, (_, info) in fields_of(Case).items() if accepts(info) is None}
        changes: dict[str, Schema] = {}
        for key, schema in keys.items():
            words = ["string"] if key in ("train", "bridge") else []
            part: Schema = {"type": ["object", "null", *words], "description": f"changes of {key}"}
            either: Schema = {"anyOf": [schema, {"type": "null"}], "description": f"{key} of this study"}
            changes[key] = part if key in parts else either
        study: Schema = {
            "type": "object",
            "description": "what one study changes; null takes a key away",
            "properties": changes,
            "patternProperties": {rf"^({'|'.join(sorted(parts))})\.": {}},
            "additionalProperties": False,
        }
        return {
            "type": "object",
            "description": "cases that are solved as one run, by name: the rest of this file, changed",
            "additionalProperties": False,
            "patternProperties": {f"^{NAME}$": self.define("Study", study)},
            "minProperties": 1,
            "maxProperties": MOST_STUDIES,
        }

    def train(self) -> Schema:
        return {"anyOf": [self.vehicle(model) for model in TRAINS]}

    def vehicle(self, model: str) -> Schema:
        """One vehicle, known by its `model`."""
        part = TRAINS[model]
        schema = self.mapping(part, {"model": {"const": model, "description": "which vehicle model this is"}})
        if "forces" in schema["properties"]:
            schema["properties"]["forces"] |= {"minItems": 1, "maxItems": MOST_FORCES}
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
        return self.define("Bridge", self.mapping(Bridge))

    def named(self, kind: Literal["train", "bridge"]) -> Schema:
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
                properties[key] = {"type": "array", "items": self.vehicles(), "description": text}
            elif inner is not None:
                properties[key] = self.define(inner.__name__, self.mapping(inner))
            elif leaf is not None:
                properties[key] = self.leaf(leaf)
                if is_list(info):
                    properties[key] = {"type": "array", "items": self.leaf(leaf), "description": leaf.text}
        schema: Schema = {
            "type": "object",
            "description": _first_sentence(part.__doc__),
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
        forms = self.mapping(Damping)
        forms |= {"minProperties": 1, "maxProperties": 1}
        forms.pop("required")
        text = "c in N s/m^2, or {first_mode_ratio: ...}, or {ratio: ...} for all modes"
        return self.define("Damping", {"anyOf": [self.leaf(COEFFICIENT), forms], "description": text})

    def stations(self) -> Schema:
        mapping = self.mapping(Stations) | {"minProperties": 1, "maxProperties": 1}
        for places in mapping["properties"].values():
            places |= {"minItems": 1, "maxItems": MOST_STATIONS}
        text = "where the beams are looked at besides mid-span: positions, or fractions of the span"
        forms = [mapping["properties"]["positions"], mapping]
        return self.define("Stations", {"anyOf": forms, "description": text})

    def histories(self) -> Schema:
        names = {"type": "array", "items": {"type": "string", "pattern": "^[a-z0-9_]+$"}, "minItems": 1}
        channels: Schema = {"anyOf": [{"const": "all"}, names | {"uniqueItems": True}]}
        channels["description"] = "all, or a list of channel names"
        mapping = self.mapping(Histories, {"channels": channels})
        text = "which time histories are stored: none, all or some channels"
        return self.define(
            "Histories", {"anyOf": [{"enum": list(HISTORY_WORDS)}, mapping], "description": text}
        )

    def sweep(self) -> Schema:
        axes: dict[str, Schema] = {}
        for model in TRAINS:
            for key in numeric_keys(model):
                axes.setdefault(key, self.axis(key, model))
        axes |= {name: self.axis(paths[0], "full-31dof") for name, paths in SHORT_NAMES.items()}
        speeds, refined = axes["velocity"], self.refined("velocity")
        axes["velocity"] = {"anyOf": [speeds, refined], "description": speeds["description"]}
        group: Schema = {"type": "array", "items": {"type": "string"}, "minItems": 2, "uniqueItems": True}
        together: Schema = {"anyOf": [group, {"type": "array", "items": group, "minItems": 1}]}
        together["description"] = "axes of this sweep that move together, or several such lists"
        force = self.axis_of(find_number("train.forces.0", {"train": {"forces": [1]}}, "moving-load")[0])
        return {
            "type": ["object", "null"],
            "description": "swept axes; their grid is taken in this order",
            "properties": axes | {"zip": together, "sample": self.sample(sorted(axes))},
            "patternProperties": {
                r"^train\.forces\.[0-9]+$": force,
                r"^train\.consist\.[0-9]+\.": {"type": ["array", "object"]},
            },
            "additionalProperties": False,
        }

    def axis(self, path: str, model: str) -> Schema:
        if path.endswith(".damping") and path.startswith("bridge."):
            names = ("coefficient", "ratio")
            forms = [find_number(f"{path}.{name}", {}, model)[0] for name in names]
            return {
                "anyOf": [self.axis_of(form) for form in forms],
                "description": "damping, in the form given",
            }
        leaf = find_number(path, {}, model)[0]
        return self.axis_of(leaf) | {"description": leaf.text}

    def axis_of(self, leaf: Quantity | Whole) -> Schema:
        """The values of one axis: a list or a range of what its key takes."""
        if isinstance(leaf, Quantity):
            value, step = (
                self.quantity(leaf),
                self.quantity(Quantity("", leaf.dimension, leaf.example, "any")),
            )
            name = "axis_of_" + value["$ref"].rpartition("/")[2]
        else:
            value, step = {"type": "integer", "minimum": leaf.low, "maximum": leaf.high}, {"type": "integer"}
            name = f"axis_of_whole_numbers_to_{leaf.high}"
        step = step | {"description": "distance of the values"}
        count = {"type": "integer", "minimum": 1, "description": "number of values"}
        ends = {"from": value | {"description": "first value"}, "to": value | {"description": "last value"}}
        logarithmic = _all_of(ends | {"count": count})
        logarithmic["description"] = "values each of which is the one before times the same factor"
        forms: list[Schema] = [
            {"type": "array", "items": value, "minItems": 1, "description": "values, one by one"},
            _all_of(ends | {"step": step}),
            _all_of(ends | {"count": count}),
            _all_of({"log": logarithmic}),
        ]
        return self.define(name, {"anyOf": forms})

    def refined(self, path: str) -> Schema:
        """A range of speeds that grows speeds of its own."""
        leaf = find_number(path, {}, "full-31dof")[0]
        assert isinstance(leaf, Quantity)
        speed, refine = self.quantity(leaf), self.mapping(Refine)
        names = {"type": "array", "items": {"type": "string", "pattern": "^[a-z0-9_]+$"}, "minItems": 1}
        refine["properties"]["channels"] |= {"anyOf": [{"const": "all"}, names | {"uniqueItems": True}]}
        texts = {"from": "first speed", "to": "last speed", "step": "speeds that are solved in any case"}
        ends = {key: speed | {"description": text} for key, text in texts.items()}
        refine["properties"] |= ends
        refine["required"] += list(ends)
        return self.define("RefinedVelocity", refine)

    def sample(self, keys: list[str]) -> Schema:
        pair: Schema = {"type": "array", "items": {"type": ["number", "string"]}}
        forms = []
        for kind, names in DISTRIBUTIONS.items():
            numbers = pair | {"minItems": len(names), "maxItems": len(names), "description": ", ".join(names)}
            form = _all_of({kind: numbers})
            form["properties"][WITHIN] = pair | {"minItems": 2, "maxItems": 2, "description": "low, high"}
            forms.append(form)
        schema = _all_of(
            {
                "kind": {"enum": list(KINDS), "description": "how the cases are drawn"},
                "count": {"type": "integer", "minimum": 1, "description": "number of cases"},
                "over": {
                    "type": "object",
                    "description": "the keys that are drawn, each with its distribution",
                    "minProperties": 1,
                    "propertyNames": {"enum": keys},
                    "additionalProperties": {"anyOf": forms},
                },
            }
        )
        seed: Schema = {"type": "integer", "minimum": 0, "maximum": 2**32 - 1}
        schema["properties"]["seed"] = seed | {"description": "another seed, other cases; 0 unless given"}
        return schema | {"description": "a random design: all its keys move together"}


def _all_of(properties: dict[str, Schema]) -> Schema:
    """A mapping with just these keys, all of them needed."""
    return {
        "type": "object",
        "properties": dict(properties),
        "required": list(properties),
        "additionalProperties": False,
    }


def _vehicle_in(models: list[str]) -> Schema:
    return {"type": "object", "required": ["model"], "properties": {"model": {"enum": models}}}


def _first_sentence(text: str | None) -> str:
    return re.split(r"(?<=\.)\s", text or "", maxsplit=1)[0]
