"""Regular expressions for the units of each dimension, for editors that check a case file as it is typed.

They know the usual spellings. The reader itself takes any product of known units with the right dimension;
whatever matches here, it takes too (a test draws from these patterns).
"""

from __future__ import annotations

import re

from tbi_cli.case.fields import Quantity

_BASE = {
    "L": r"(?:[umdck]?m|µm|meters?|metres?|in|ft|yd)",
    "M": r"(?:[kM]?g|t|tonnes?|lb)",
    "T": r"(?:m?s|sec|seconds?|min|h|hr)",
    "F": r"(?:[kMG]?N|daN|kgf|tf|lbf|kip)",
    "S": r"[kMG]?Ns",
    "P": r"(?:[kMG]?Pa|psi|ksi)",
    "V": r"(?:mph|kph|kmh)",
    "H": r"k?Hz",
    "R": r"(?:%|‰|percent|permille)",
    "*": r" ?[* ·] ?",
    "/": r" ?/ ?",
    "(": r"\(",
    ")": r"\)",
    "2": r"(?:\^2|\*\*2|²|2)",
    "4": r"(?:\^4|\*\*4|⁴|4)",
}
# SI unit -> spellings of units of the same dimension, in the letters above.
_SPELLINGS = {
    "m": ("L",),
    "kg": ("M",),
    "kg m^2": ("M*L2", "F*L*T2"),
    "N/m": ("F/L", "M/T2"),
    "N s/m": ("F*T/L", "S/L", "F/L*T", "F/(L/T)", "M/T"),
    "Pa": ("P", "F/L2"),
    "m^4": ("L4",),
    "kg/m": ("M/L",),
    "N s/m^2": ("F*T/L2", "S/L2", "F/L2*T", "P*T", "M/(L*T)", "M/L/T"),
    "m/s": ("L/T", "V"),
    "m/s^2": ("L/T2", "L/T/T"),
    "N": ("F", "M*L/T2"),
    "s": ("T",),
    "Hz": ("H",),
    "1": ("R",),
}
_DIGITS = r"(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]{1,2})?"
_NOT_ZERO = r"(?=[0.]*[1-9])"
# A number alone may stand in quotes too.
_SIGNS = {
    "positive": rf"\+?{_NOT_ZERO}{_DIGITS}",
    "not negative": rf"\+?{_DIGITS}",
    "any": rf"[-+]?{_DIGITS}",
}


def unit_pattern(quantity: Quantity) -> str:
    """A pattern (ECMA 262 and Python alike) for a number of this sign with a unit of this dimension."""
    spellings = ("".join(_BASE[letter] for letter in text) for text in _SPELLINGS[quantity.dimension.unit])
    units = "|".join(spellings)
    pattern = rf"^{_SIGNS[quantity.sign]}(?: ?(?:{units}))?$"
    re.compile(pattern)
    return pattern
