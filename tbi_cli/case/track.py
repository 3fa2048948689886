"""The track before, on and after the bridge, and what of its rails is not level; every number in SI."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import model_validator

from tbi_cli.case.fields import LENGTH, AtMost, Choice, Quantity, Text, Whole, rejected
from tbi_cli.case.messages import plain_number
from tbi_cli.case.part import Part

# The wavelengths (m) for which each spectrum holds; tbi_cli.track.spectra has the formulas and the sources.
VALID_WAVELENGTHS = {
    "german-low": (3.0, 150.0),
    "german-high": (3.0, 150.0),
    **{f"fra-{grade}": (1.524, 304.8) for grade in range(1, 7)},
}
_ANY_BAND = (3.0, 150.0)  # beside a spectrum that there is not
COHERENCES = ("same", "independent", "cross-level")
SIDES = ("both", "right", "left", "opposite")
MOST_POINTS = 10_000
MOST_INTERVALS = 100_000
# The share of an approach, at its far end, in which what goes on all along the track grows from nothing.
TAPER = 0.25
LEAST_WAVELENGTH = 0.05
NARROWEST_BAND = 0.9
# Intervals of the cubics of which the rails are made: in an analytic shape or its wavelength, and in the
# shortest wavelength of a random profile at least.
INTERVALS_IN_SHAPE = 64
INTERVALS_IN_WAVE = 20


def _signed(text: str, example: str, usual: tuple[float, float] | None = None) -> Quantity:
    """A length of any sign, next to zero too: where there is a calculation behind it."""
    return Quantity(text, LENGTH, example, "any", usual=usual, smallest=0.0)


_AT = _signed("where it begins; the bridge begins at 0", "20 m", (-1000, 1000))
_LONG = Quantity("its length", LENGTH, "5 m", usual=(0.05, 200))
_RISE = _signed("its height, upward", "3 mm", (-0.1, 0.1))
Sides = Annotated[
    Literal["both", "right", "left", "opposite"],
    Choice("rails that have it; opposite: upside down on the left one", SIDES),
]


class Ramp(Part):
    """A straight rise to a level that the rail keeps from there on."""

    at: Annotated[float, _AT]
    length: Annotated[float, _LONG]
    height: Annotated[float, _RISE]
    rails: Sides = "both"


class Dip(Part):
    """A smooth hollow, one wave of the cosine: r = -depth/2 (1 - cos(2 pi (x - at)/length))."""

    at: Annotated[float, _AT]
    length: Annotated[float, _LONG]
    depth: Annotated[float, _signed("its depth, downward", "3 mm", (-0.1, 0.1))]
    rails: Sides = "both"


class HalfSine(Part):
    """A bump of half a wave: r = height sin(pi (x - at)/length), with corners at its ends."""

    at: Annotated[float, _AT]
    length: Annotated[float, _LONG]
    height: Annotated[float, _RISE]
    rails: Sides = "both"


class Harmonic(Part):
    """Sine waves all along the track: r = amplitude sin(2 pi (x - at)/wavelength)."""

    at: Annotated[float, _signed("where a wave rises through zero", "0 m", (-1000, 1000))] = 0.0
    wavelength: Annotated[float, Quantity("wavelength", LENGTH, "10 m", usual=(0.05, 300))]
    amplitude: Annotated[
        float, Quantity("amplitude, half of the height of a wave", LENGTH, "2 mm", usual=(1e-6, 0.1))
    ]
    rails: Sides = "both"


class Random(Part):
    """A random profile of a given spectrum; the same seed gives the same rails at the same place."""

    spectrum: Annotated[
        Literal["german-low", "german-high", "fra-1", "fra-2", "fra-3", "fra-4", "fra-5", "fra-6"],
        Choice("spectrum of the irregularity", tuple(VALID_WAVELENGTHS)),
    ]
    seed: Annotated[int, Whole("number of the realisation", 0, 2**32 - 1)] = 1
    coherence: Annotated[
        Literal["same", "independent", "cross-level"],
        Choice("how the rails go together; cross-level: by a spectrum of its own", COHERENCES),
    ] = "same"
    shortest_wavelength: Annotated[float, Quantity("shortest wavelength", LENGTH, "3 m", largest=1e3)]
    longest_wavelength: Annotated[float, Quantity("longest wavelength", LENGTH, "150 m", largest=1e3)]

    @model_validator(mode="before")
    @classmethod
    def _band(cls, values: Any) -> Any:
        """The band is that of the spectrum, unless told otherwise."""
        if not isinstance(values, dict):
            return values
        shortest, longest = VALID_WAVELENGTHS.get(str(values.get("spectrum")), _ANY_BAND)
        return {"shortest_wavelength": shortest, "longest_wavelength": longest} | values


PLACES = _signed("places along the track, rising; the bridge begins at 0, or at start", "-10 m")
# Measured levels are in mm more often than not.
LEVELS = replace(
    _signed("level of the rail at each place, upward", "1 mm", (-0.2, 0.2)),
    dimension=replace(LENGTH, forgotten="mm"),
)


class Profile(Part):
    """Rails as measured: levels at places along the track, listed here or read from a CSV file.

    Without `left` both rails are the same. `csv` is read where the case is: in a Case, `x`, `right` and
    `left` hold what the file says.
    """

    forms = (frozenset({"csv"}), frozenset({"x", "right", "left"}))

    csv: Annotated[str, Text("CSV file beside this one: x, right and left", 1000)] | None = None
    start: (
        Annotated[float, _signed("x at which the bridge begins, as the points count it", "123.4 km")] | None
    ) = None
    x: Annotated[tuple[Annotated[float, PLACES], ...], AtMost(MOST_POINTS)]
    right: Annotated[tuple[Annotated[float, LEVELS], ...], AtMost(MOST_POINTS)]
    left: Annotated[tuple[Annotated[float, LEVELS], ...], AtMost(MOST_POINTS)] = ()

    @property
    def points(self) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
        """Places (m), rising, the bridge beginning at 0, and the levels (m) of both rails there."""
        begin, order = self.start or 0.0, slice(None, None, -1 if self.x[-1] < self.x[0] else 1)
        places = tuple(x - begin for x in self.x[order])
        return places, self.right[order], (self.left or self.right)[order]

    @property
    def ends(self) -> tuple[float, float]:
        """The first and the last place (m), the bridge beginning at 0."""
        first, last = sorted((self.x[0], self.x[-1]))
        return first - (self.start or 0.0), last - (self.start or 0.0)

    @model_validator(mode="after")
    def _consistent(self) -> Profile:
        given = ("right", "left") if self.left else ("right",)
        for name in given:
            levels = getattr(self, name)
            if len(levels) != len(self.x):
                raise rejected(
                    f"expected one level in {name} for each of the {len(self.x)} places, got {len(levels)}"
                )
        if len(self.x) < 2:
            raise rejected(f"expected 2 to {MOST_POINTS} places, got {len(self.x)}")
        falling = self.x[-1] < self.x[0]
        for number, (before, after) in enumerate(pairwise(self.x), 1):
            if before <= after if falling else after <= before:
                text = "expected places that rise from point to point, or fall, each of them once, "
                text += f"got {plain_number(after)} after {plain_number(before)}"
                raise rejected(text, "x", number)
        self._expect_points_close_enough()
        return self

    def _expect_points_close_enough(self) -> None:
        """Cubics between points that are far and near by turns swing out between the far ones."""
        import numpy as np
        from scipy.interpolate import CubicSpline

        places, *rails = self.points
        x, levels = np.array(places), np.array(rails)
        between = np.concatenate([x[:-1] + share * np.diff(x) for share in (0.25, 0.5, 0.75)])
        low, high = levels.min(axis=1, keepdims=True), levels.max(axis=1, keepdims=True)
        found = CubicSpline(x, levels, axis=1, bc_type="clamped")(between)
        beyond = np.maximum(found - high, low - found) - (high - low)
        worst = int(np.argmax(beyond.max(axis=0)))
        if beyond[:, worst].max() > 1e-9:
            k = int(np.searchsorted(x, between[worst])) - 1
            level = found[int(np.argmax(beyond[:, worst])), worst]
            begin = self.start or 0.0
            ends = f"{plain_number(x[k] + begin)} and {plain_number(x[k + 1] + begin)} m"
            there = plain_number(level)
            text = f"expected closer points between {ends}: a smooth rail through them goes to {there} m"
            raise rejected(text)


class Irregularity(Part):
    """What of the rails is not level: whatever is given here is added up."""

    ramp: Ramp | None = None
    dip: Dip | None = None
    half_sine: HalfSine | None = None
    harmonic: Harmonic | None = None
    random: Random | None = None
    profile: Profile | None = None

    @model_validator(mode="after")
    def _some(self) -> Irregularity:
        names = list(type(self).model_fields)
        if all(getattr(self, name) is None for name in names):
            raise rejected(f"expected one or more of {', '.join(names)}, got none of them")
        return self

    @property
    def shapes(self) -> dict[str, Ramp | Dip | HalfSine]:
        """The shapes that stand at one place, by their keys."""
        shapes = {"ramp": self.ramp, "dip": self.dip, "half_sine": self.half_sine}
        return {key: shape for key, shape in shapes.items() if shape is not None}

    @property
    def everywhere(self) -> tuple[Harmonic | Random | Profile, ...]:
        """What goes on all along the track."""
        return tuple(part for part in (self.harmonic, self.random, self.profile) if part is not None)


class Track(Part):
    """Rails that are not level, on the bridge and on an approach before and after it."""

    irregularity: Irregularity
    approach: Annotated[
        float,
        Quantity(
            "length of the track before and after the bridge",
            LENGTH,
            "100 m",
            "not negative",
            usual=(20, 2000),
            largest=1e4,
        ),
    ] = 100.0

    @property
    def shortest_wave(self) -> float:
        """The shortest wavelength (m) that there is to speak of."""
        irregularity = self.irregularity
        waves = [shape.length for shape in irregularity.shapes.values()]
        if irregularity.harmonic is not None:
            waves.append(irregularity.harmonic.wavelength)
        if irregularity.random is not None:
            waves.append(irregularity.random.shortest_wavelength)
        if irregularity.profile is not None:
            first, last = irregularity.profile.ends
            waves.append(4 * (last - first) / (len(irregularity.profile.x) - 1))
        return min(waves)

    def contradictions(self, span: float) -> Iterator[tuple[str, str]]:
        """Key and message for numbers that do not go together, on a bridge of this span (m)."""
        irregularity, random = self.irregularity, self.irregularity.random
        if random is not None:
            shortest, longest = random.shortest_wavelength, random.longest_wavelength
            low, high = LEAST_WAVELENGTH, NARROWEST_BAND * longest
            if not low <= shortest <= high:
                text = (
                    f"expected {plain_number(low)} to {plain_number(high)} m, 0.9 of the longest wavelength"
                )
                yield (
                    "track.irregularity.random.shortest_wavelength",
                    f"{text}, got {plain_number(shortest)} m",
                )
        if self.approach == 0 and irregularity.everywhere:
            text = "expected more than 0, as waves and measured rails begin level on the approach, got 0"
            yield "track.approach", text
        for name, shape in irregularity.shapes.items():
            if shape.at < -self.approach:
                text = f"expected a place on the approach, {plain_number(-self.approach)} m, or after it"
                yield f"track.irregularity.{name}.at", f"{text}, got {plain_number(shape.at)} m"
        ends = [shape.at + shape.length for shape in irregularity.shapes.values()]
        waves = []
        if irregularity.harmonic is not None:
            waves.append((irregularity.harmonic.wavelength, INTERVALS_IN_SHAPE))
        if random is not None:
            waves.append((random.shortest_wavelength, INTERVALS_IN_WAVE))
        length = max(span + self.approach, *ends, 0.0) + self.approach
        for wave, intervals in waves:
            most = MOST_INTERVALS * wave / intervals
            if length > most:
                text = (
                    f"expected at most {plain_number(most)} m of track with waves of {plain_number(wave)} m"
                )
                yield "track", f"{text} on it, got {plain_number(length)} m"
                return

    def oddities(self) -> Iterator[tuple[str, str]]:
        """Key and message where a spectrum is used beyond the wavelengths for which it holds."""
        random = self.irregularity.random
        if random is None:
            return
        shortest, longest = VALID_WAVELENGTHS[random.spectrum]
        for name in ("shortest_wavelength", "longest_wavelength"):
            value = getattr(random, name)
            if not shortest <= value <= longest:
                holds = f"{plain_number(shortest)} to {plain_number(longest)} m"
                text = f"{plain_number(value)} m is outside the {holds} for which {random.spectrum} holds"
                yield f"track.irregularity.random.{name}", text
