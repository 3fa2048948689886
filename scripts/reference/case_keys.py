"""The keys of a case file, from the models that check it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from scripts.reference.markdown import code, table
from tbi_cli.case.axes import SHORT_NAMES
from tbi_cli.case.bridge import Bridge, Damping
from tbi_cli.case.consist import Vehicles
from tbi_cli.case.fields import Accepts, Quantity
from tbi_cli.case.files import MAX_BYTES
from tbi_cli.case.full_train import BogieOverride
from tbi_cli.case.keys import accepts, fields_of, is_list, part_of
from tbi_cli.case.messages import plain_number
from tbi_cli.case.model import Case
from tbi_cli.case.part import Part
from tbi_cli.case.sample import DISTRIBUTIONS, KINDS
from tbi_cli.case.settings import HERTZ_SPRING, Contact, Histories, Output, Solver
from tbi_cli.case.track import Irregularity, Track
from tbi_cli.case.train import TRAINS
from tbi_cli.case.yaml12 import MAX_ALL_KEYS, MAX_DEPTH, MAX_KEYS, MAX_NODES

_HEAD = """# Keys of a case file

A case file is YAML. Plain numbers are SI; a text may carry a unit (`300 km/h`, `40 t`, `207 GPa`, `0.5 %`).
Units are written as engineers do: `N/mm2`, `N/mm^2` or `N/mm²`, `kN*s/m` or `kNs/m`, `kph`, `µm`.
`110.2e3` and `1e5` are numbers, as in YAML 1.2. An unknown key, a key given twice and a value out of range
are errors; a value outside the column *usual* is a warning, and an error with `--strict`. So is a list, a
range or a distribution with a unit on some of its numbers and none on others (0 needs none): each is read as
it stands, `[20, 40 km/h]` as 20 and 11.1 m/s. Every key with a number can be set by its dotted name,
`--set bridge.right.damping.ratio='1 %'`, and swept by it. What can be given in several forms (a damping,
stations, a range, `csv` or numbers, a `model`) is changed to the form that an option or a study gives.

`tbi schema` prints the same as JSON Schema, by which editors complete and check; see
[how to write a case file](../how-to/train.md#completion-in-an-editor).
"""

_BOUNDS = f"""
## How large a file may be

{MAX_BYTES / 1e6:g} MB, {MAX_NODES} values (what an alias stands for counts each time), {MAX_ALL_KEYS}
keys, {MAX_KEYS} of them in one mapping, nested {MAX_DEPTH} levels deep; each file that it includes as much
again. Tags, merge keys (`<<`) and several documents in one file are not used.

A file that a case names may lie in any folder. Of one outside the folder of the case, links followed,
messages tell line, column and key, but nothing of what is in it: a stranger's case may name files of yours.
"""

_SWEEP = """
## sweep

A mapping from keys to values; the grid of all combinations is solved, the last axis changing fastest. Any key
of this page with a number can be an axis by its dotted name; these have short names:

{short}
The values of an axis:

| form | values |
| --- | --- |
| `[20 t, 40 t, 60 t]` | those |
| `{{from: 2, to: 200, step: 0.5}}` | from the first by steps, to the last one if it lies on a step |
| `{{from: 30, to: 60, count: 4}}` | so many, at equal distances |
| `{{log: {{from: 1, to: 100, count: 5}}}}` | so many, at equal ratios |
| `{{from: 40, to: 120, step: 4, refine: resonance}}` | `velocity` only: by steps, and more near resonance |

Values that follow from others are those that one would write: `{{from: 20, to: 30, step: 0.1}}` has 20.3,
the same number as in a list, and from 100 km/h by 10 km/h there is the value of `150 km/h`. They are computed
exactly and rounded once. The values of a list may stand in any order; results keep it, and reports sort.

Where the last value does not lie on a step, it is left out and a warning names the one before; a refined
velocity is solved there too. It also takes `tolerance` (1 %), by how much a peak may still change (where that
is not reached, [`converged`](results.md#where-a-refined-sweep-has-converged) is 0), and `channels`, those
of the tables that decide (deflection and acceleration of the bridge at mid-span):
[how speeds are added](../TRAINS.md#speeds-that-a-sweep-finds-itself).

Two more keys do not name an axis:

- `zip: [velocity, bridge.length]`, or a list of such lists: axes of this sweep, with as many values each,
  that move together as one axis.
- `sample: {{kind: {kinds}, count: 64, seed: 1, over: {{...}}}}`: a random design, one axis named `sample`.
  Under `over:` each key has a distribution: {distributions}. `within: [low, high]` beside a distribution cuts
  it off. The draws depend on the seed, the kind, the count and the order of the keys alone.

## studies

Several grids in one file, solved as one run and stored as one group each. A mapping from names to what is
different in each study: keys of this page, dotted or nested, on top of the rest of the file. A `sweep` and
a train that says its `model` replace what is outside; null takes a key away. `output.file`
stands outside.

How sweeps and studies are written and read back: [my own sweep](../how-to/sweep.md).
"""


def page() -> str:
    """The page of all keys."""
    parts: list[tuple[str, str, type[Part], str]] = [
        ("bridge", "bridge", Bridge, _BRIDGE),
        ("contact", "contact", Contact, _contact()),
        ("solver", "solver", Solver, ""),
        ("track", "track", Track, "Without `track` the rails are level."),
        ("output", "output", Output, ""),
    ]
    text = _HEAD + "\n## The case\n\n" + _table(_rows_at_the_top())
    text += "\n## train\n\nA built-in name (`tbi list trains`), a file beside the case file, or the mapping "
    text += "itself, of which `model` says what it is:\n\n"
    text += table(
        ["model", ""], ([f"[`{model}`](#train-{model})", _first(part)] for model, part in TRAINS.items())
    )
    for model, part in TRAINS.items():
        text += f"\n### train: {model}\n\n{_first(part)}\n\n" + _table(_rows(part, "train.", model))
        if part is TRAINS["full-31dof"]:
            text += _OVERRIDES
    for heading, key, part, more in parts:
        text += f"\n## {heading}\n\n{_first(part)} {more}".rstrip() + "\n\n"
        text += _table(_rows(part, f"{key}.", None))
    text += _HISTORIES
    distributions = ", ".join(
        code(f"{{{kind}: [{', '.join(names)}]}}") for kind, names in DISTRIBUTIONS.items()
    )
    short = table(
        ["name", "sets"],
        ([code(name), ", ".join(code(path) for path in paths)] for name, paths in SHORT_NAMES.items()),
    )
    return text + _SWEEP.format(short=short, kinds=" | ".join(KINDS), distributions=distributions) + _BOUNDS


_BRIDGE = (
    "A built-in name (`tbi list bridges`), a file beside the case file, or the mapping itself. `left` has "
    "the same keys as `right`. `damping` of a beam is c in N s/m² (a number, or a text with that unit), or "
    "one of the two mappings named below."
)
_OVERRIDES = (
    "\nStiffness and damping of `secondary` are those of one side of one bogie, of `primary` of one wheel. "
    "`front_bogie` and `rear_bogie` may hold any of the keys of `bogie`, and of `secondary` and `primary` "
    "under these names, for what is different at one end.\n"
)
_HISTORIES = (
    "\n`histories` is `none`, `all`, or `{channels: [car_body_y, right_midspan], every: 0.01 s}`; "
    "the names are those of the [channels](channels.md).\n"
)


# Defaults that follow from other keys.
_FILLED_IN = {
    **{
        f"track.irregularity.random.{end}_wavelength": "that of the spectrum"
        for end in ("shortest", "longest")
    },
    **{f"track.irregularity.profile.{key}": "required, or `csv`" for key in ("x", "right")},
    "track.irregularity.profile.left": "as `right`",
    "train.geometry.bogie_distance": "required, or `l_b1` and `l_b2`",
    "train.geometry.wheelbase": "required, or `l_w1` to `l_w4`",
    **{f"train.geometry.l_b{i}": "half of `bogie_distance`" for i in (1, 2)},
    **{f"train.geometry.l_w{i}": "half of `wheelbase`" for i in (1, 2, 3, 4)},
    **{f"contact.{key}": "see above" for key in HERTZ_SPRING},
}


def _contact() -> str:
    values = ", ".join(f"`{key}` {plain_number(value)}" for key, value in HERTZ_SPRING.items())
    return f"The spring is that of `hertz` alone, and is, unless given: {values}."


def _rows_at_the_top() -> Iterator[list[str]]:
    mappings = {
        "train": "the train",
        "bridge": "the bridge",
        "contact": "how wheels stand on the beams",
        "track": "rails that are not level",
        "solver": "time integration",
        "output": "what is stored, and where",
    }
    for key, (_, info) in fields_of(Case).items():
        if key in mappings:
            yield [f"[`{key}`](#{key})", "", _default(info), "", mappings[key]]
        else:
            yield _row(key, info, accepts(info))
    yield ["[`sweep`](#sweep)", "", "none", "", "the swept axes"]
    yield ["[`studies`](#studies)", "", "none", "", "several grids in one file"]


def _rows(part: type[Part], before: str, model: str | None) -> Iterator[list[str]]:
    for key, (_, info) in fields_of(part).items():
        inner = part_of(info, None)
        path = before + key
        if key == "model" and model is not None:
            yield [code(path), code(model), "required", "", "which train this is"]
        elif inner is BogieOverride:
            yield [code(path), "a mapping", "none", "", "what is different at this end"]
        elif inner is Vehicles:
            yield [code(path), "a list of mappings", "required", "", "the vehicles, the first in front"]
            yield from _rows(Vehicles, f"{path}[].", None)
        elif key == "vehicle":
            yield [code(path), "a name, a file or a mapping", "required", "", "one of the other trains"]
        elif inner is Histories:
            yield [code(path), "see below", "`none`", "", "which time histories are stored"]
        elif inner is Damping:
            yield from _damping(path)
        elif inner is not None:
            if part is Bridge and key == "left":
                yield [code(path), "a mapping", "none", "", "the left beam; absent for trains on one beam"]
                continue
            if part in (Irregularity, Track) and inner is not Irregularity:
                yield [code(path), "a mapping", "none", "", _first(inner)]
            yield from _rows(inner, f"{path}.", None)
        else:
            yield _row(path, info, accepts(info))


def _damping(path: str) -> Iterator[list[str]]:
    for form, (_, info) in fields_of(Damping).items():
        leaf = accepts(info)
        assert leaf is not None
        name = path if form == "coefficient" else f"{path}.{form}"
        default = "required" if form == "coefficient" else "or this"
        yield [code(name), _accepted(leaf, info), default, _usual(leaf), _described(leaf)]


def _row(path: str, info: FieldInfo, leaf: Accepts | None) -> list[str]:
    assert leaf is not None, path
    default = _FILLED_IN.get(path, _default(info))
    return [code(path), _accepted(leaf, info), default, _usual(leaf), _described(leaf)]


def _table(rows: Iterator[list[str]]) -> str:
    return table(["key", "value", "default", "usual", "what it is"], rows)


def _accepted(leaf: Accepts, info: FieldInfo) -> str:
    text = leaf.expected()
    if isinstance(leaf, Quantity):
        text = text.partition(", or {")[0]
    return f"a list, each {text}" if is_list(info) else text


def _described(leaf: Accepts) -> str:
    unit = leaf.dimension.unit if isinstance(leaf, Quantity) else "1"
    return leaf.text if unit == "1" else f"{leaf.text} [{unit}]"


def _usual(leaf: Any) -> str:
    bounds = getattr(leaf, "usual", None)
    return " to ".join(plain_number(bound) for bound in bounds) if bounds else ""


def _default(info: FieldInfo) -> str:
    if info.is_required():
        return "required"
    default = info.default
    if default is None or default is PydanticUndefined:
        return "none"
    if isinstance(default, Part):
        return ""
    if isinstance(default, bool):
        return code(str(default).lower())
    if isinstance(default, tuple) and default:
        return code(f"[{', '.join(plain_number(value) for value in default)}]")
    if isinstance(default, int | float):
        return code(plain_number(default))
    return code(str(default)) if default not in ("", ()) else "none"


def _first(part: type[Part]) -> str:
    """The first paragraph of what a mapping is."""
    return " ".join((part.__doc__ or "").partition("\n\n")[0].split())
