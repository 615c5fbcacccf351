"""One object for what equal results have in common, so that a study of many points fits in memory.

The points of an exploration differ in few figures, yet each is read from a text of its own: laws and their sources,
lines of demand, levers and parameters come up thousands of times.
"""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Annotated, Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, TypeAdapter

from codesign.ground.figures import Figure
from codesign.study.definition import read_json
from codesign.system.results.result import ResourceItem, ResourceUse, Result

T = TypeVar("T")

_WHOLE = (ResourceItem, ResourceUse)
_NUMBERS = (int, float)


class Shared:
    """The parts met so far. Results that went through one ``Shared`` hold equal parts as one object."""

    def __init__(self) -> None:
        self._met: dict[Any, Any] = {}

    def result(self, result: Result) -> Result:
        """The same result, of shared parts; ``result`` itself is used up."""
        self._fields(result)
        return result

    def part(self, value: T) -> T:
        """An equal value, of shared parts; ``value`` itself is used up."""
        shared: T = self._part(value)
        return shared

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
        if type(value) in _NUMBERS:
            return value
        if isinstance(value, tuple):
            parts = tuple(map(self._part, value))
            # Numbers of different types may be equal: a tuple is shared whole only where it holds no such number.
            shareable = all(isinstance(part, (str, *_WHOLE)) for part in parts)
            return self._met.setdefault(parts, parts) if shareable else parts
        if isinstance(value, dict):
            return self._first(value, {self._part(key): self._part(part) for key, part in value.items()})
        if isinstance(value, _WHOLE):
            met = self._met.get(value)
            if met is None:
                self._fields(value)
                met = self._met[value] = value
            return met
        if isinstance(value, BaseModel):
            self._fields(value)
        return self._first(value, value) if isinstance(value, Figure) else value

    def _first(self, value: Any, part: T) -> T:
        """The first part with the same text: it is equal to the last digit and in every type."""
        first: T = self._met.setdefault((type(value), repr(value)), part)
        return first


class Parts:
    """The fields of the templates of a study: of equal fields one object, which is found by its JSON text.

    The templates of a study are thousands, and the different values of a field are few. So a text is read, checked and
    taken apart once. The values met last are held as they were given too: designs have many of them in common.
    """

    def __init__(self) -> None:
        self._by_text: dict[str, dict[bytes, Any]] = {name: {} for name in _FIELDS}
        self._text: dict[tuple[str, int], bytes] = {}
        self._shared = Shared()
        self._given: OrderedDict[tuple[str, int], tuple[Any, bytes]] = OrderedDict()
        self._plain = 0

    def shared(self, templates: tuple[Result, ...]) -> tuple[Result, ...]:
        """The results, of shared parts; the first ``_MOST_PLAIN`` as they are, since they fit in memory."""
        self._plain += len(templates)
        return templates if self._plain <= _MOST_PLAIN else self.put(templates)[2]

    def put(self, templates: Sequence[Result]) -> tuple[dict[str, list[bytes]], NDArray[np.int32], tuple[Result, ...]]:
        """Results as texts, and of shared parts.

        Returns the texts of each field by its name, for each result (rows) the number of the text of each field
        (columns), and the results again. A field that is one object in several results is written once.
        """
        texts: dict[str, list[bytes]] = {}
        columns = []
        for name in _FIELDS:
            numbers: dict[bytes, int] = {}
            by_value: dict[int, int] = {}
            values = [template.__dict__[name] for template in templates]
            for template, value in zip(templates, values, strict=True):
                if id(value) not in by_value:
                    text = self._text.get((name, id(value))) or self._written(name, value, template)
                    by_value[id(value)] = numbers.setdefault(text, len(numbers))
            columns.append([by_value[id(value)] for value in values])
            texts[name] = [*numbers]
        while len(self._given) > _MOST_GIVEN:
            self._given.popitem(last=False)
        table = np.array(columns, np.int32).reshape(len(_FIELDS), -1).T
        return texts, table, self.take(texts, table)

    def _written(self, name: str, value: Any, template: Result) -> bytes:
        """The text of a field that is given for the first time, or was given lately."""
        key = name, id(value)
        if key in self._given:
            self._given.move_to_end(key)
            return self._given[key][1]
        plain = template.model_dump(mode="json", include={name})[name]
        text = json.dumps(plain, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
        self._given[key] = value, text
        if text not in self._by_text[name]:
            self._keep(name, text, value)
        return text

    def _keep(self, name: str, text: bytes, value: Any) -> None:
        shared = self._by_text[name][text] = self._shared.part(value)
        # It is held here, so no other object gets its id.
        self._text[name, id(shared)] = text

    def take(self, texts: Mapping[str, Sequence[bytes]], numbers: NDArray[np.int32]) -> tuple[Result, ...]:
        """The results that ``put`` wrote.

        Raises:
            ValueError, KeyError, TypeError: it did not write them, or not in this version.
        """
        if tuple(texts) != _FIELDS:
            raise ValueError("the fields of a block are not those of a result")
        if not len(numbers):
            return ()
        if numbers.min() < 0 or (numbers.max(axis=0) >= [len(texts[name]) for name in _FIELDS]).any():
            raise ValueError("a field of a block has no number")
        same, varying = {}, []
        for place, (name, own) in enumerate(texts.items()):
            met = self._by_text[name]
            for text in own:
                if text not in met:
                    self._keep(name, text, _field(name).validate_python(read_json(text.decode())))
            same[name] = met[own[0]]
            if len(own) > 1:
                varying.append((place, name, [met[text] for text in own]))
        rows = ({name: parts[row[place]] for place, name, parts in varying} for row in numbers.tolist())
        return tuple(_of_parts(same | row) for row in rows)


_FIELDS = tuple(Result.model_fields)
_MOST_GIVEN = 1024
_MOST_PLAIN = 4096
_ALL_SET = set(_FIELDS)
_NONE = ("__pydantic_extra__", None), ("__pydantic_private__", None)


def _of_parts(fields: dict[str, Any]) -> Result:
    """A result of all of its fields; pydantic's own ways go through the fields for defaults, or copy their set."""
    result = Result.__new__(Result)
    for name, value in (("__pydantic_fields_set__", _ALL_SET), *_NONE, ("__dict__", fields)):
        object.__setattr__(result, name, value)
    return result


@cache
def _field(name: str) -> TypeAdapter[Any]:
    """The validator of a field of a result."""
    info = Result.model_fields[name]
    annotation: Any = Annotated[info.annotation, info]
    return TypeAdapter(annotation)
