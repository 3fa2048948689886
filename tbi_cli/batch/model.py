"""What crosses what, as the numbers that the integrator asks for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tbi_cli.batch.entries import Entries
from tbi_cli.responses import Channel
from tbi_cli.system.assembly import System
from tbi_cli.timegrid import Pace


@dataclass(frozen=True, eq=False)
class Model:
    """A system with its channels, and their numbers in the integrator's order.  Shared by many scenarios."""

    system: System
    channels: tuple[Channel, ...]
    pace: Pace

    @cached_property
    def matrix(self) -> Entries:
        """A of x'' = A (x, x') on rigid track, (n_dof, 2 n_dof): blocks of the vehicles, and the beams."""
        s = self.system
        nv, n = len(s.coordinates), len(s.beams[0].omega)
        nd = nv + n * len(s.beams)
        blocks = {}
        for one, _ in self._vehicles:
            K, C = (one.K_links, one.C_links) if one.unilateral else (one.K, one.C)
            blocks[one] = [Entries.of(-matrix / one.M[:, None]) for matrix in (K, C)]
        parts = []
        for one, (coordinate, _) in self._vehicles:
            parts += [
                block.moved(coordinate, coordinate + k * nd, 2 * nd) for k, block in enumerate(blocks[one])
            ]
        for b, beam in enumerate(s.beams):
            rows = np.arange(nv + b * n, nv + (b + 1) * n)
            parts += [Entries(rows, rows, -(beam.omega**2), 2 * nd)]
            parts += [Entries(rows, nd + rows, -beam.damping, 2 * nd)]
        return Entries.together(parts)

    @cached_property
    def wheel_rows(self) -> Entries:
        """g of each wheel: the stretch of its suspension on rigid track, (wheels, nv)."""
        nv = len(self.system.coordinates)
        blocks = {one: Entries.of(one.wheel_rows) for one, _ in self._vehicles}
        return Entries.together(
            [blocks[one].moved(wheel, coordinate, nv) for one, (coordinate, wheel) in self._vehicles]
        )

    @property
    def _vehicles(self) -> list[tuple[System, tuple[int, int]]]:
        """Every vehicle by itself, with the train's number of its first coordinate and of its first wheel."""
        coaches = self.system.coaches
        return [(c.system, (c.first_coordinate, c.first_wheel)) for c in coaches] or [(self.system, (0, 0))]

    @cached_property
    def angles(self) -> NDArray[np.float64]:
        """cos and sin of pi offset/L of each axle, shape (axles, 2)."""
        angle = np.pi * self.system.axle_offsets / self.system.length
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)

    @cached_property
    def crawling(self) -> tuple[float, ...]:
        """Largest mid-span deflection (m) of each beam under the same axle loads at crawling speed."""
        s = self.system
        return tuple(
            beam.crawling_deflection(
                s.wheel_load[s.wheel_beam == b], s.axle_offsets[s.wheel_axle[s.wheel_beam == b]]
            )
            for b, beam in enumerate(s.beams)
        )

    @cached_property
    def wheels(self) -> NDArray[np.float64]:
        """k, c, f_g and 2/(mu L) of each wheel, shape (wheels, 4)."""
        s = self.system
        gain = np.array([s.beams[b].gain for b in s.wheel_beam])
        return np.stack([s.wheel_stiffness, s.wheel_damping, s.wheel_load, gain], axis=1)

    @property
    def stations(self) -> NDArray[np.float64]:
        """x/L of each station, and the same but 2 at the end of the beams, shape (stations, 2)."""
        place = np.array(self.system.stations) / self.system.length
        return np.stack([place, np.where(place < 1.0, place, 2.0)], axis=1)
