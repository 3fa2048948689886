"""A swept axis: which keys it sets, to which values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from tbi_cli.case.refinement import Refinement

# Short names of the paper's axes and of ensembles, and the keys that they set.
SHORT_NAMES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "velocity": ("velocity",),
        "car_body_mass": ("train.car_body.mass",),
        "span": ("bridge.length",),
        "damping": ("bridge.right.damping", "bridge.left.damping"),
        "modes": ("bridge.modes",),
        "sampling": ("solver.sampling",),
        "seed": ("track.irregularity.random.seed",),
    }
)


@dataclass(frozen=True)
class Axis:
    """One axis of the grid.

    key: as written in the case file; name: of the dimension in the results file; paths: the dotted keys that
    it sets; values: in SI; units: of the values, "1" for none; long_name: for people; whole: the values are
    whole numbers; chains: the same paths as fields of a Case; given: how the case file gives the values, if
    not as a list.

    Of a refined axis `values` are all that there may be, see `Refinement`.

    An axis on which several keys move together has them as `members`, each with as many values; its own
    values are then 0, 1, 2, ...
    """

    key: str
    name: str
    paths: tuple[str, ...]
    values: tuple[float, ...]
    units: str
    long_name: str
    whole: bool = False
    chains: tuple[tuple[str | int, ...], ...] = field(default=(), repr=False)
    given: Mapping[str, object] | None = field(default=None, compare=False, repr=False)
    members: tuple[Axis, ...] = ()
    refinement: Refinement | None = None

    def __len__(self) -> int:
        return len(self.values)

    def settings(self, value: float) -> list[tuple[tuple[str | int, ...], float | int]]:
        """Chains of fields, and what each is set to, where the axis has this value."""
        if self.members:
            return [pair for member in self.members for pair in member.settings(member.values[int(value)])]
        number = int(value) if self.whole else float(value)
        return [(chain, number) for chain in self.chains]


def joined(key: str, name: str, members: tuple[Axis, ...], long_name: str) -> Axis:
    """The axis on which `members`, which have as many values each, move together."""
    return Axis(
        key=key,
        name=name,
        paths=tuple(path for member in members for path in member.paths),
        values=tuple(float(i) for i in range(len(members[0]))),
        units="1",
        long_name=long_name,
        members=members,
    )


def resolved_sweep(axes: tuple[Axis, ...]) -> dict[str, object]:
    """The axes as under `sweep:` of a case file, in SI."""
    sweep: dict[str, object] = {}
    zipped: list[list[str]] = []
    for axis in axes:
        columns = axis.members if axis.members and not axis.given else (axis,)
        if len(columns) > 1:
            zipped.append([column.key for column in columns])
        for column in columns:
            sweep[column.key] = dict(column.given) if column.given else list(column.values)
    return sweep | ({"zip": zipped} if zipped else {})
