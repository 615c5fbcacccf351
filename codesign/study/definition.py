"""The definition of a study, from which a store reads it again, and the specs that its points are made of."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codesign.ground.errors import InputError, RunError
from codesign.ground.units import counted
from codesign.inputs import Platform, Workload, load_platform
from codesign.inputs.aggregate import rule_as_written
from codesign.inputs.edit import PLATFORM_AXIS, VARIANT_AXIS
from codesign.inputs.exploration import Exploration
from codesign.inputs.files import kept_document, read_kept
from codesign.study.explored import Explored
from codesign.study.identity import canonical_digest, contents_of, files_read, identity_of
from codesign.study.simulator import grid_for
from codesign.study.space import Space, canonical
from codesign.system.catalog import load_workload
from codesign.system.outcome import provenance_of
from codesign.system.problem_map import grid_of
from codesign.system.results.result import Provenance

if TYPE_CHECKING:
    from codesign.maps import OccupancyGrid

_WHAT = {
    "platform": "a part or a host of the platform",
    "workload": "the workload",
    "map": "the map",
    "files": "a file of goals or starts",
    PLATFORM_AXIS: "a platform",
    VARIANT_AXIS: "a variant",
}
"""The inputs that may have changed, by the name of their digest; an axis that is not listed moves the map."""

CODE_CHANGED = "the study was computed by other code: figures may differ from those of the study"


@dataclass(frozen=True, repr=False)
class Specs:
    """The documents of a study's workload and platforms, and the digests of all that its results depend on.

    - ``text``: the documents as JSON. ``identity``, ``contents``: see ``identity_of`` and ``contents_of``.
    - ``read``: what they are read to, where it is at hand. ``grid``: the map that the points were planned on, alike.
    - ``files``: the digests of the files that points are made of, as of ``files_read``, when the exploration began.
    """

    text: str
    identity: Mapping[str, str]
    contents: Mapping[str, Mapping[str, str]]
    read: Explored | None = field(default=None, compare=False)
    grid: OccupancyGrid | None = field(default=None, compare=False)
    files: Mapping[Path, str] = field(default_factory=dict, compare=False)

    @classmethod
    def of(cls, explored: Explored) -> Specs:
        """The specs of an exploration.

        Raises:
            MapError: the map cannot be read or made.
        """
        files, grid = files_read(explored), grid_of(explored.workload)
        documents = {
            "workload": kept_document(explored.workload.document),
            "platforms": {name: kept_document(each.document) for name, each in explored.platforms.items()},
        }
        text = json.dumps(documents, ensure_ascii=False, allow_nan=False)
        identity = identity_of(explored.single, explored.workload, grid)
        return cls(text, identity, contents_of(explored), explored, grid, files)

    @cached_property
    def explored(self) -> Explored:
        """The workload and its platforms, read again from their documents where they are not at hand.

        Raises:
            SpecError: a file that they name is missing, or is refused by now. InputError: the documents are none.
        """
        if self.read is not None:
            return self.read
        try:
            documents = json.loads(self.text)
            workload = load_workload(read_kept(documents["workload"]))
            platforms = {str(name): load_platform(read_kept(kept)) for name, kept in documents["platforms"].items()}
        except (ValueError, KeyError, TypeError, AttributeError) as wrong:
            raise InputError("the study holds no specs that this version can read") from wrong
        return Explored(workload, platforms)

    def refuse_changes(self) -> None:
        """Refuse to go on where a file that points are made of changed since the exploration began.

        Raises:
            RunError: names the file.
        """
        before, after = self.files, files_read(self.explored)
        for file in {**before, **after}:
            if before.get(file) != after.get(file):
                kinds = {"parts": "part", "hosts": "host"}
                kind = kinds.get(file.parent.name, "map") if file.suffix == ".yaml" else "map"
                what = f"a {kind} file changed while its designs were explored"
                raise RunError(what, str(file), "run again: points finished before are kept")

    def point(self, axes: Mapping[str, Any]) -> tuple[Platform, Workload]:
        """Platform and workload of a point, as they were when the study was computed.

        Raises:
            InputError: a map, part or host file has changed since. SpecError: a file is missing; or the point cannot be
                placed on its platform.
        """
        return self._unless_changed(axes, self._now)

    def point_on_its_map(self, axes: Mapping[str, Any]) -> tuple[Platform, Workload, OccupancyGrid | None]:
        """Platform and workload of a point, and the map that the study was computed on.

        The map is None where it has to be read again: the study was read from a store, or an axis moves the problem. A
        study that this process computed stays sound when the file of its map changes.

        Raises:
            InputError, SpecError: see ``point``.
        """
        if self.read is None or self.grid is None:
            return *self.point(axes), None
        platform, workload = self._unless_changed(axes, self._now_on_its_map)
        return platform, workload, grid_for(workload, self.read.workload, self.grid)

    def _unless_changed(self, axes: Mapping[str, Any], now: Mapping[str, str]) -> tuple[Platform, Workload]:
        changed = self._changed(axes, now)
        if changed:
            hint = "put the file back as it was, or run hwsw explore again: it computes what changed"
            raise InputError(f"{' and '.join(changed)} changed since the study was computed", hint=hint)
        return self.explored.point(axes)

    @cached_property
    def _now(self) -> dict[str, str]:
        explored = self.explored
        return identity_of(explored.single, explored.workload, grid_of(explored.workload))

    @cached_property
    def _now_on_its_map(self) -> dict[str, str]:
        return identity_of(self.explored.single, self.explored.workload, self.grid)

    @cached_property
    def _contents_now(self) -> dict[str, dict[str, str]]:
        return contents_of(self.explored)

    def _changed(self, axes: Mapping[str, Any], now: Mapping[str, str]) -> list[str]:
        """The inputs of a point that differ from what they were, but for the code."""
        changed = [_WHAT[name] for name, digest in self.identity.items() if name in _WHAT and now[name] != digest]
        for axis, digests in self.contents.items():
            value = canonical(axes.get(axis))
            if value in digests and self._contents_now.get(axis, {}).get(value) != digests[value]:
                changed.append(f"{_WHAT.get(axis, 'the map')} ({axis})")
        return changed

    @property
    def note(self) -> str:
        """A sentence where the code differs from the code that computed the study; else ""."""
        return CODE_CHANGED if self._now["code"] != self.identity["code"] else ""


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
