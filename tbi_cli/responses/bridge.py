"""The channels of the bridge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Bridge
from tbi_cli.responses.channel import DERIVATIVES, Channel, Terms, derivatives
from tbi_cli.system.assembly import System
from tbi_cli.system.trains import SIDES


def midspan_channels(system: System) -> list[Channel]:
    """Deflection at mid-span of each beam, with its derivatives."""
    made: list[Channel] = []
    nv = len(system.coordinates)
    for b, beam in enumerate(system.beams):
        n = len(beam.omega)
        shape = [(nv + b * n + i, float(np.sin((i + 1) * np.pi / 2))) for i in range(0, n, 2)]
        terms: dict[str, Terms] = {
            kind: tuple(((kind, row), round(s)) for row, s in shape) for kind in DERIVATIVES
        }
        made += derivatives(
            f"{SIDES[b]}_midspan",
            "m",
            f"mid-span deflection of the {SIDES[b]} beam",
            terms,
        )
        name = f"{SIDES[b]}_midspan_acceleration"
        long_name = f"mid-span acceleration of the {SIDES[b]} beam"
        made += _low_passed(name, long_name, terms["a"], b, beam.low_pass)
    return made


def station_channels(bridge: Bridge, system: System) -> list[Channel]:
    """Deflection, acceleration, bending moment and shear force at every station of each beam.

    Moment and shear are those of the forces that act on the beam: the wheels' by the influence lines of the
    beam at rest, inertia and damping by its modes.  So no more is lost with the modes left out than their
    inertia, and the shear force jumps under a wheel.  A sagging moment is positive, and so is a shear force
    with which the beam before the station pushes up the beam behind it.
    """
    made: list[Channel] = []
    nv, n, count = len(system.coordinates), len(system.beams[0].omega), len(system.stations)
    order = np.arange(1, n + 1)
    # In words that hold for every span of a grid.
    places = [f"{share:g} L" for share in bridge.stations.fractions] or [f"{x:g} m" for x in system.stations]
    for b, beam in enumerate(system.beams):
        rows = [nv + b * n + i for i in range(n)]
        for s, x in enumerate(system.stations):
            angle = order * np.pi * x / beam.length
            shape = tuple(float(value) for value in np.sin(angle))
            inertia = beam.mass_per_length * (beam.length / (order * np.pi)) ** 2 * np.sin(angle)
            slope = beam.mass_per_length * beam.length / (order * np.pi) * np.cos(angle)
            name, place = f"{SIDES[b]}_station_{s + 1}", f"of the {SIDES[b]} beam at {places[s]}"
            terms = {
                kind: tuple(((kind, row), value) for row, value in zip(rows, shape, strict=True))
                for kind in DERIVATIVES
            }
            made += [
                Channel(f"{name}_deflection", "m", f"deflection {place}", terms["x"]),
                Channel(f"{name}_velocity", "m/s", f"velocity {place}", terms["v"], in_tables=False),
                Channel(f"{name}_acceleration", "m/s2", f"acceleration {place}", terms["a"]),
                *_low_passed(f"{name}_acceleration", f"acceleration {place}", terms["a"], b, beam.low_pass),
                Channel(
                    f"{name}_moment",
                    "N m",
                    f"bending moment {place}",
                    ((("M", b * count + s), beam.length), *_inertial(rows, inertia, beam.damping)),
                ),
                Channel(
                    f"{name}_shear",
                    "N",
                    f"shear force {place}",
                    ((("V", b * count + s), 1.0), *_inertial(rows, slope, beam.damping)),
                ),
            ]
    return made


def _inertial(rows: list[int], factor: NDArray[np.float64], damping: NDArray[np.float64]) -> Terms:
    """What inertia and damping of the modes add: factor (x'' + damping x')."""
    accelerations = [(("a", row), float(value)) for row, value in zip(rows, factor, strict=True)]
    velocities = [(("v", row), float(value)) for row, value in zip(rows, factor * damping, strict=True)]
    return (*accelerations, *velocities)


def _low_passed(name: str, long_name: str, terms: Terms, beam: int, cut_off: float) -> list[Channel]:
    """The low-passed acceleration beside an acceleration, where a cut-off (Hz) is given."""
    if not cut_off:
        return []
    return [Channel(f"{name}_low_pass", "m/s2", f"{long_name}, low-passed", terms, low_pass=beam)]


def mode_channels(system: System) -> list[Channel]:
    """The paper's modal coordinates q_i of Eq. (2), from the amplitudes A_i = sqrt(2/L) q_i."""
    nv = len(system.coordinates)
    return [
        Channel(
            f"{SIDES[b]}_mode_{i + 1}",
            "m1.5",
            f"modal coordinate {i + 1} of the {SIDES[b]} beam",
            ((("x", nv + b * len(beam.omega) + i), float(np.sqrt(beam.length / 2))),),
            in_tables=False,
        )
        for b, beam in enumerate(system.beams)
        for i in range(len(beam.omega))
    ]
