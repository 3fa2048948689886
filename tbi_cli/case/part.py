"""The base of every mapping of a case file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict


class Part(BaseModel):
    """A mapping of a case file: frozen, and unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    #: Keys that may stand together, where those of one form exclude those of another.
    forms: ClassVar[tuple[frozenset[str], ...]] = ()
    #: Key -> another key and the word there without which it means nothing.
    needs: ClassVar[Mapping[str, tuple[str, str]]] = {}

    def replacing(self, name: str, value: object) -> Self:
        """A copy with one field changed, unchecked; quick, and without what was derived from the old one."""
        kind = type(self)
        fields: dict[str, Any] = {key: self.__dict__[key] for key in kind.model_fields}
        fields[name] = value
        copy = kind.__new__(kind)
        object.__setattr__(copy, "__dict__", fields)
        object.__setattr__(copy, "__pydantic_fields_set__", set(fields))
        object.__setattr__(copy, "__pydantic_extra__", None)
        object.__setattr__(copy, "__pydantic_private__", self.__pydantic_private__)
        return copy


def replaced(part: Any, chain: tuple[str | int, ...], value: object) -> Any:
    """`part` with the value at the end of a chain of field names and list positions changed."""
    head, rest = chain[0], chain[1:]
    if isinstance(head, int):
        new = replaced(part[head], rest, value) if rest else value
        return (*part[:head], new, *part[head + 1 :])
    return part.replacing(head, replaced(getattr(part, head), rest, value) if rest else value)
