"""The definition of a study: the text that a store keeps of it, from which the study is read again."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from codesign.ground.units import counted
from codesign.inputs.aggregate import rule_as_written
from codesign.inputs.exploration import Exploration
from codesign.study.identity import canonical_digest
from codesign.study.space import Space
from codesign.study.specs import Specs
from codesign.system.outcome import provenance_of
from codesign.system.results.result import Provenance

MAX_STUDY_POINTS = 4_000_000
"""Most points of one exploration: a study holds them all in memory."""

OTHER_VERSION = "read it with the version that wrote it, or explore again into another file"
"""The remedy for a text that this version cannot read."""

_MOST_DIGITS = 40
_LONG = re.compile(f"[0-9][0-9]{{{_MOST_DIGITS}}}")
"""More digits. As two parts, so that it is searched by its first character."""


@dataclass(frozen=True)
class StudyDefinition:
    """A study without its entries. ``platform``: see ``platform_text``. ``workload``: its name."""

    platform: str
    workload: str
    space: Space
    section: Exploration
    specs: Specs
    provenance: Provenance

    @classmethod
    def of(cls, section: Exploration, space: Space, specs: Specs) -> StudyDefinition:
        """The definition of an exploration that begins.

        Raises:
            MapError: the map cannot be read or made.
        """
        explored = specs.explored
        platforms = explored.platforms.values()
        platform = platform_text([each.name for each in platforms])
        provenance = provenance_of(platforms, explored.workload, specs.grid)
        return cls(platform, explored.workload.name, space, section, specs, provenance)

    @cached_property
    def text(self) -> str:
        """The definition as JSON, with the specs for a later reader of the file."""
        explored, section = self.specs.explored, self.section
        # Not canonical text: the order of the axes is that of the points, and JSON keeps it only unsorted.
        definition = {
            "platforms": {name: each.model_dump(mode="json") for name, each in explored.platforms.items()},
            "workload": explored.workload.model_dump(mode="json"),
            "provenance": self.provenance.model_dump(mode="json", exclude={"date"}),
            "documents": self.specs.text,
            "identity": dict(self.specs.identity),
            "contents": dict(self.specs.contents),
            "axes": {name: list(values) for name, values in section.axes.items()},
            "when": section.when_as_written,
            "conditions": {name: list(values) for name, values in section.conditions.items()},
            "aggregate": {name: rule_as_written(rule) for name, rule in section.aggregate.items()},
            "figures": {name: figure.as_written for name, figure in section.figures.items()},
            "objectives": [figure.name for figure in section.objectives],
            "constraints": [limit.model_dump(mode="json", exclude_none=True) for limit in section.constraints],
        }
        return json.dumps(definition, ensure_ascii=False, allow_nan=False)


def platform_text(names: Collection[str]) -> str:
    """The platform of a study in words: its name, or how many platforms its axis has.

    >>> platform_text(["zynq"]), platform_text(["zynq", "arty-a7"])
    ('zynq', '2 platforms')
    """
    return next(iter(names)) if len(names) == 1 else counted(len(names), "platform")


def read_definition(text: str) -> StudyDefinition:
    """The definition that ``StudyDefinition.text`` wrote.

    Raises:
        ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError: this version cannot read it.
    """
    definition = read_json(text)
    keys = ("when", "axes", "conditions", "aggregate", "figures", "objectives", "constraints")
    section = Exploration.model_validate({key: definition[key] for key in keys})
    contents = {
        str(axis): {str(value): str(digest) for value, digest in digests.items()}
        for axis, digests in definition.get("contents", {}).items()
    }
    identity = {str(name): str(digest) for name, digest in definition["identity"].items()}
    space = Space(section.every_axis, canonical_digest(identity), contents, section.when)
    names = [str(each["name"]) for each in definition["platforms"].values()]
    if not names:
        raise ValueError("no platform")
    return StudyDefinition(
        platform=platform_text(names),
        workload=str(definition["workload"]["name"]),
        space=space,
        section=section,
        specs=Specs(str(definition["documents"]), identity, contents),
        provenance=Provenance.model_validate(definition["provenance"]),
    )


def read_json(text: str) -> Any:
    """JSON with finite numbers only, as results have.

    Raises:
        ValueError: the text is no such JSON. RecursionError: it is nested too deep.
    """
    return (_CAREFUL if _LONG.search(text) else _PLAIN).decode(text)


def _float(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is not finite")
    return value


def _integer(text: str) -> int:
    if len(text) > _MOST_DIGITS:
        raise ValueError(f"a number of {len(text)} digits")
    return int(text)


_PLAIN = json.JSONDecoder(parse_float=_float, parse_constant=_float)
_CAREFUL = json.JSONDecoder(parse_float=_float, parse_int=_integer, parse_constant=_float)
