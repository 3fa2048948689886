"""Writes plain values as YAML that this package (YAML 1.2) and PyYAML (1.1) read alike."""

from __future__ import annotations

import json
from typing import Any


def emit_yaml(value: dict[str, Any], indent: int = 0) -> str:
    """Block mappings, flow lists, one key a line, lines never wrapped, strings always in double quotes."""
    lines = []
    for key, item in value.items():
        start = " " * indent + key + ":"
        if isinstance(item, dict) and item:
            lines.append(f"{start}\n{emit_yaml(item, indent + 2)}")
        else:
            lines.append(f"{start} {_flow(item)}\n")
    return "".join(lines)


def _flow(value: Any) -> str:
    if isinstance(value, float):
        # 1e+16 is a number in YAML 1.2 only; 1.0e+16 is one everywhere.
        mantissa, sign, exponent = repr(value).partition("e")
        return f"{mantissa}{'' if '.' in mantissa else '.0'}e{int(exponent):+03d}" if sign else mantissa
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_flow(item) for item in value) + "]"
    return json.dumps(value, ensure_ascii=False)
