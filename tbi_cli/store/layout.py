"""What a results file holds: its dimensions, its variables and its root attributes."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tbi_cli.printable import one_line
from tbi_cli.store.errors import StoreError

FORMAT = "tbi-results"
#: Of a file whose groups are the roots of such files, one for each study.
STUDIES_FORMAT = "tbi-studies"
FORMAT_VERSION = 1

#: The table groups, in the order of the file, with what each holds.
TABLES: Mapping[str, str] = {
    "peak": "largest absolute value",
    "max": "largest value",
    "min": "smallest value",
    "rms": "root mean square",
    "time_of_peak": "time of the largest absolute value",
}

#: The variable that says where a refined sweep reached its tolerance.
CONVERGED = "converged"

#: Two runs that differ in one of these may not be mixed in one results file.
IDENTITY = ("case_sha256", "tbi_version", "shard")

#: Root attributes that hold names, separated by spaces, in the order that HDF5 itself does not keep.
NAME_LISTS = ("dimensions", "channels", "history_channels", "daf")

#: Root attributes that are summed over the files that hold the cases: what the solution cost.
TOTALS = ("solve_seconds", "case_steps")

#: More cases than in any grid that can be solved; as many as there is memory for to read their status.
MOST_CASES = 100_000_000

Scalar = str | int | float


@dataclass(frozen=True)
class Variable:
    """A name, its units (``"1"`` where there is none) and the words for it in figures."""

    name: str
    units: str
    long_name: str


@dataclass(frozen=True, eq=False)
class Dim:
    """A swept axis: its netCDF name, its coordinate values (n,) in SI, their units and its long name.

    Where several keys move together along it, ``members`` are these, each with as many values.
    """

    name: str
    values: NDArray[np.float64]
    units: str
    long_name: str
    members: tuple[Dim, ...] = ()


#: The dynamic amplification factors; a vehicle on one beam has the right ones only.
DAF: Mapping[str, Variable] = {
    v.name: v
    for v in (
        Variable(
            "right", "1", "dynamic amplification factor of the right beam, over the train's whole weight"
        ),
        Variable("left", "1", "dynamic amplification factor of the left beam, over the train's whole weight"),
        Variable(
            "right_static", "1", "dynamic amplification factor of the right beam, over its static crossing"
        ),
        Variable(
            "left_static", "1", "dynamic amplification factor of the left beam, over its static crossing"
        ),
    )
}


@dataclass(frozen=True, eq=False)
class Layout:
    """Everything about a results file but its numbers.

    ``dims`` in the order of the grid; ``channels`` of the five tables; ``history_channels``, empty if no
    histories are kept; ``daf``, the names of the amplification factors; ``attributes``, for the root of the
    file (see `tbi_cli.store.provenance`): ``case`` (YAML), ``case_sha256`` and ``tbi_version`` are needed to
    resume and to merge.
    """

    dims: tuple[Dim, ...]
    channels: tuple[Variable, ...]
    history_channels: tuple[Variable, ...] = ()
    daf: tuple[str, ...] = tuple(DAF)
    attributes: Mapping[str, Scalar] = field(default_factory=dict)

    @property
    def shape(self) -> tuple[int, ...]:
        """The grid's shape."""
        return tuple(len(dim.values) for dim in self.dims)

    @property
    def size(self) -> int:
        """The number of cases in the grid."""
        return math.prod(self.shape)

    def columns(self, group: str) -> tuple[Variable, ...]:
        """The variables of one table group, with the units and long names that they have there."""
        if group == "daf":
            return tuple(DAF[name] for name in self.daf)
        if group == "time_of_peak":
            return tuple(Variable(c.name, "s", f"time of the peak of {c.long_name}") for c in self.channels)
        return self.channels

    def check(self) -> None:
        """Raise `StoreError` for names that cannot be those of variables, and for a grid beyond all measure.

        A layout that was read may be a stranger's: a name with a slash in it would lead out of its group.
        """
        names = [one.name for dim in self.dims for one in (dim, *dim.members)]
        for name in [*names, *(one.name for one in (*self.channels, *self.history_channels))]:
            if not name.isprintable() or re.search(r"[\s/]", name) or name in ("", ".", ".."):
                raise StoreError(f"names a variable {name[:60]!r}")
        if self.size > MOST_CASES:
            raise StoreError(f"has a grid of {self.size:.3g} cases, expected at most {MOST_CASES}")

    @property
    def name_lists(self) -> dict[str, str]:
        """The root attributes of `NAME_LISTS`."""
        lists = ([d.name for d in self.dims], _names(self.channels), _names(self.history_channels), self.daf)
        return {key: " ".join(names) for key, names in zip(NAME_LISTS, lists, strict=True)}

    @property
    def groups(self) -> tuple[str, ...]:
        """The table groups of the file."""
        return (*TABLES, "daf")

    def point(self, index: int) -> dict[str, float]:
        """The axis values of the case with flat index ``index``."""
        at = np.unravel_index(index, self.shape)
        columns = [
            (column, i) for dim, i in zip(self.dims, at, strict=True) for column in (dim, *dim.members)
        ]
        return {column.name: float(column.values[i]) for column, i in columns}

    def to_json(self, **extra: Scalar) -> str:
        """The layout as text, exact to the bit; ``extra`` is kept beside it."""
        return json.dumps(
            {
                "format": f"{FORMAT}-layout",
                "format_version": FORMAT_VERSION,
                **extra,
                "dims": [_to_plain(dim) for dim in self.dims],
                "channels": [asdict(c) for c in self.channels],
                "history_channels": [asdict(c) for c in self.history_channels],
                "daf": list(self.daf),
                "attributes": dict(self.attributes),
            },
            indent=1,
        )

    @classmethod
    def from_json(cls, text: str) -> tuple[Layout, dict[str, Any]]:
        """The layout in ``text`` and what was kept beside it.

        Raises `StoreError` for anything that `to_json` of this format version does not write.
        """
        try:
            data = json.loads(text)
            if data["format"] != f"{FORMAT}-layout" or data["format_version"] != FORMAT_VERSION:
                raise StoreError("is not a layout of this version of tbi")
            dims = tuple(_from_plain(d) for d in data.pop("dims"))
            for values in (one.values for dim in dims for one in (dim, *dim.members)):
                if not (values.ndim == 1 and len(values) and np.isfinite(values).all()):
                    raise StoreError("has a dimension without values, or with such as are not finite")

            def variables(key: str) -> tuple[Variable, ...]:
                return tuple(
                    Variable(*(one_line(str(v[word])) for word in ("name", "units", "long_name")))
                    for v in data.pop(key)
                )

            attributes = data.pop("attributes")
            if not all(map(_is_scalar, attributes.values())):
                raise StoreError("has attributes of an unknown kind")
            daf = tuple(str(name) for name in data.pop("daf"))
            if not set(daf) <= set(DAF):
                raise StoreError("names unknown amplification factors")
            layout = cls(dims, variables("channels"), variables("history_channels"), daf, attributes)
            layout.check()
        except (KeyError, TypeError, ValueError, AttributeError, RecursionError, OverflowError) as error:
            raise StoreError("is not a layout written by tbi") from error
        return layout, data


def _is_scalar(value: object) -> bool:
    return isinstance(value, str | int) or (isinstance(value, float) and math.isfinite(value))


def _to_plain(dim: Dim) -> dict[str, Any]:
    plain = {"name": dim.name, "values": dim.values.tolist(), "units": dim.units, "long_name": dim.long_name}
    return plain | ({"members": [_to_plain(member) for member in dim.members]} if dim.members else {})


def _from_plain(plain: dict[str, Any]) -> Dim:
    values = np.array(plain["values"], dtype=np.float64)
    members = tuple(_from_plain({**member, "members": []}) for member in plain.get("members", []))
    if any(member.values.shape != values.shape for member in members):
        raise StoreError("has members of a dimension that are not as long as it")
    name, units, long_name = (one_line(str(plain[word])) for word in ("name", "units", "long_name"))
    return Dim(name, values, units, long_name, members)


def _names(variables: tuple[Variable, ...]) -> list[str]:
    return [variable.name for variable in variables]
