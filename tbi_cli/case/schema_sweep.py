"""JSON Schema of `sweep:`: every key with a number, as lists and ranges, and what axes do together."""

from __future__ import annotations

from tbi_cli.case.axes import SHORT_NAMES
from tbi_cli.case.fields import Quantity, Whole
from tbi_cli.case.keys import find_number, numeric_keys
from tbi_cli.case.refinement import Refine
from tbi_cli.case.sample import DISTRIBUTIONS, KINDS, WITHIN
from tbi_cli.case.schema_parts import CHANNELS, Parts, Schema
from tbi_cli.case.train import TRAINS


class SweepSchema:
    """The swept axes; what it refers to is defined in `parts`."""

    def __init__(self, parts: Parts) -> None:
        self.parts = parts

    def schema(self) -> Schema:
        """The mapping of axes."""
        axes: dict[str, Schema] = {}
        for model in TRAINS:
            for key in numeric_keys(model):
                axes.setdefault(key, self._axis(key, model))
        axes |= {name: self._axis(paths[0], "full-31dof") for name, paths in SHORT_NAMES.items()}
        speeds, refined = axes["velocity"], self._refined("velocity")
        axes["velocity"] = {"anyOf": [speeds, refined], "description": speeds["description"]}
        group: Schema = {"type": "array", "items": {"type": "string"}, "minItems": 2, "uniqueItems": True}
        together: Schema = {"anyOf": [group, {"type": "array", "items": group, "minItems": 1}]}
        together["description"] = "axes of this sweep that move together, or several such lists"
        force = self._axis_of(find_number("train.forces.0", {"train": {"forces": [1]}}, "moving-load")[0])
        return {
            "type": ["object", "null"],
            "description": "swept axes; their grid is taken in this order",
            "properties": axes | {"zip": together, "sample": self._sample(sorted(axes))},
            "patternProperties": {
                r"^train\.forces\.[0-9]+$": force,
                r"^train\.consist\.[0-9]+\.": {"type": ["array", "object"]},
            },
            "additionalProperties": False,
        }

    def _axis(self, path: str, model: str) -> Schema:
        if path.endswith(".damping") and path.startswith("bridge."):
            names = ("coefficient", "ratio")
            forms = [find_number(f"{path}.{name}", {}, model)[0] for name in names]
            return {
                "anyOf": [self._axis_of(form) for form in forms],
                "description": "damping, in the form given",
            }
        leaf = find_number(path, {}, model)[0]
        return self._axis_of(leaf) | {"description": leaf.text}

    def _axis_of(self, leaf: Quantity | Whole) -> Schema:
        """The values of one axis: a list or a range of what its key takes."""
        if isinstance(leaf, Quantity):
            value, step = (
                self.parts.quantity(leaf),
                self.parts.quantity(Quantity("", leaf.dimension, leaf.example, "any")),
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
        return self.parts.define(name, {"anyOf": forms})

    def _refined(self, path: str) -> Schema:
        """A range of speeds that grows speeds of its own."""
        leaf = find_number(path, {}, "full-31dof")[0]
        assert isinstance(leaf, Quantity)
        speed, refine = self.parts.quantity(leaf), self.parts.mapping(Refine)
        refine["properties"]["channels"] |= CHANNELS
        texts = {"from": "first speed", "to": "last speed", "step": "speeds that are solved in any case"}
        ends = {key: speed | {"description": text} for key, text in texts.items()}
        refine["properties"] |= ends
        refine["required"] += list(ends)
        return self.parts.define("RefinedVelocity", refine)

    def _sample(self, keys: list[str]) -> Schema:
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
