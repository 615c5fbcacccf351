"""One object for what equal results have in common, so that a study of many points fits in memory.

The points of an exploration differ in few figures, yet each is read from a text of its own: laws and their sources,
lines of demand, levers and parameters come up thousands of times.
"""

from __future__ import annotations

from typing import Any, TypeVar

from pydantic import BaseModel

from codesign.figures import Figure
from codesign.results.result import ResourceItem, ResourceUse, Result

T = TypeVar("T")

_WHOLE = (ResourceItem, ResourceUse)


class Shared:
    """The parts met so far. Results that went through one ``Shared`` hold equal parts as one object."""

    def __init__(self) -> None:
        self._met: dict[Any, Any] = {}

    def result(self, result: Result) -> Result:
        """The same result, of shared parts; ``result`` itself is used up."""
        self._fields(result)
        return result

    def _fields(self, model: BaseModel) -> None:
        # Frozen models are changed here by equal values only: no reader sees a difference.
        for name, value in model.__dict__.items():
            model.__dict__[name] = self._part(value)
        fields = frozenset(model.model_fields_set)
        object.__setattr__(model, "__pydantic_fields_set__", self._met.setdefault(fields, set(fields)))

    def _part(self, value: Any) -> Any:
        # Text only: a word of an enumeration equals its text, and must stay what it is.
        if type(value) is str:
            return self._met.setdefault(value, value)
        if isinstance(value, tuple):
            parts = tuple(map(self._part, value))
            # Numbers of different types may be equal: a tuple is shared whole only where it holds no such number.
            shareable = all(isinstance(part, (str, *_WHOLE)) for part in parts)
            return self._met.setdefault(parts, parts) if shareable else parts
        if isinstance(value, dict):
            return self._first(value, {self._part(key): self._part(part) for key, part in value.items()})
        if isinstance(value, BaseModel):
            self._fields(value)
            if isinstance(value, _WHOLE):
                return self._met.setdefault(value, value)
            return value
        return self._first(value, value) if isinstance(value, Figure) else value

    def _first(self, value: Any, part: T) -> T:
        """The first part with the same text: it is equal to the last digit and in every type."""
        first: T = self._met.setdefault((type(value), repr(value)), part)
        return first
