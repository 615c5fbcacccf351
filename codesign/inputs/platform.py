"""A platform: components and the links between them, as declared in YAML."""

from __future__ import annotations

import functools
import json
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import Field

from codesign.ground.errors import Fault, SpecError, choose_hint, clip
from codesign.ground.figures import Price
from codesign.ground.models import SpecModel
from codesign.inputs.base import Spec
from codesign.inputs.components import COMPONENTS, AnyComponent, Component, FpgaComponent
from codesign.inputs.document import Document
from codesign.inputs.faults import validate
from codesign.inputs.fields import Day, Name, OwnPriceFigure, PowerFigure, PriceFigure
from codesign.inputs.files import Source, document_of, read_spec, shipped_names
from codesign.inputs.library import PARTS, calibration_state, host_state, name_and_grade
from codesign.inputs.links import LINKS, MAX_ENDS, Link
from codesign.inputs.roles import LINK, ROLE_TYPES, ROLES, Roles, filled_roles, role_faults

_SHOWN = 6
"""Most platforms that a remedy lists."""

MAX_NAMES = 256
"""Components of a platform, and links of a platform."""


class BoardPower(SpecModel):
    """Power at the input of a whole board, as its source measured it: supplies, memories and fans included."""

    idle: PowerFigure = Field(description="While it waits.")
    busy: PowerFigure | None = Field(default=None, description="At the work that its source names.")


class Board(SpecModel):
    """A board that is sold. It changes no result."""

    product: Annotated[str, Field(min_length=1)] = Field(description="Name of the product.")
    maker: str | None = Field(default=None, description="Name of its maker.")
    price: PriceFigure | None = Field(default=None, description="Price of one board; left out where it is not known.")
    power: BoardPower | None = Field(
        default=None,
        description="Power at the input of the whole board, with its source; left out where nobody measured it. hwsw"
        " advise holds it against --power. Without it, that verdict is not sure: components are a part of a board.",
    )
    beside: Name | None = Field(
        default=None,
        description="The shipped platform of a computer that is sold apart, where a component is of it. hwsw advise"
        " adds its price and its power.",
    )


Kind = TypeVar("Kind", bound=AnyComponent)


class Platform(Spec):
    """The hardware: components, and the links between them."""

    entries: ClassVar[Mapping[str, bool]] = {"components": False, "links": False}

    kind: Literal["platform"] = Field(description="This file is a platform.")
    name: Name = Field(description="Name of the platform, which results show.")
    description: str = Field(default="", description="What it is, for readers.")
    components: Annotated[dict[Name, Component], Field(min_length=1, max_length=MAX_NAMES)] = Field(
        description="Components by name, at least one."
    )
    links: Annotated[dict[Name, Link], Field(max_length=MAX_NAMES)] = Field(default={}, description="Links by name.")
    board: Board | None = Field(default=None, description="The board that the platform stands for.")
    roles: Roles = Field(
        default=Roles(),
        description="What a workload means by fabric, host and link. A component or link with the name of a role"
        " fills that role by itself.",
    )

    @property
    def filled(self) -> dict[str, str]:
        """The name of the component or link that fills each role; a role that nothing fills is left out."""
        return filled_roles(dict(self.roles), self.components, self.links)

    def named(self, name: str) -> str:
        """The component or link that a workload means by a name or a role; the name itself where it is no role."""
        return self.filled.get(name, name)

    def of(self, kind: type[Kind]) -> dict[str, Kind]:
        """The components of one kind by name, in the order of the file."""
        return {name: spec for name, spec in self.components.items() if isinstance(spec, kind)}

    def validated_alone(self, section: str, name: str, raw: Any, document: Document) -> SpecModel:  # noqa: ARG002
        """See ``Spec.validated_alone``: a component or link; one of the same content is validated once."""
        return _of_content(section, json.dumps(raw), document.folder, state_behind(raw, document.folder))

    def _identity(self) -> dict[str, Any]:
        chips = [part.chip.model_dump(mode="json", exclude_defaults=True) for part in self.of(FpgaComponent).values()]
        identity = super()._identity()
        del identity["board"]
        for component in identity["components"].values():
            # A platform without calibrations has the digest that it had before there were any.
            if component.get("calibration", "") is None:
                del component["calibration"]
        calibrations = self.calibrations
        return {**identity, "chips": chips, **({"calibrations": calibrations} if calibrations else {})}

    @property
    def calibrations(self) -> dict[str, str]:
        """The digest of each calibration by the name of the FPGA that names it."""
        return {
            name: component.calibrated.digest()
            for name, component in self.of(FpgaComponent).items()
            if component.calibrated is not None
        }


@functools.lru_cache(maxsize=1024)
def _of_content(section: str, text: str, folder: Path, _files: object) -> SpecModel:
    entry = json.loads(text)
    model: type[SpecModel] = (LINKS if section == "links" else COMPONENTS)[entry["type"]]
    return model.model_validate(entry, context={"document": Document("", folder, entry)})


def state_behind(raw: Mapping[str, Any], folder: Path) -> tuple[object, ...]:
    """The states of the files that a raw component names: its part, host and calibration."""
    part, host, calibration = raw.get("part"), raw.get("host"), raw.get("calibration")
    parts = PARTS.state([name_and_grade(part)[0]], (folder / "parts",)) if isinstance(part, str) else ()
    hosts = host_state(host, (folder / "hosts",)) if isinstance(host, str) else ()
    return (*parts, *hosts, *(calibration_state(calibration, folder) if isinstance(calibration, str) else ()))


def _link_faults(document: Document) -> list[Fault]:
    """Links that join what is no component, or one twice, or that go by the name of a component."""
    tree = document.tree if isinstance(document.tree, dict) else {}
    components, links = tree.get("components"), tree.get("links")
    if not isinstance(components, dict) or not isinstance(links, dict):
        return []
    if max(len(components), len(links)) > MAX_NAMES:
        return []
    faults = []
    for name, link in links.items():
        if name in components:
            what, hint = f"{clip(name)} names a component too", "give the link a name of its own"
            faults.append(document.fault(("links", name), what, hint, at_key=True))
        ends = link.get("between") if isinstance(link, dict) else None
        ends = ends[:MAX_ENDS] if isinstance(ends, list) else []
        for index, end in enumerate(ends):
            path = ("links", name, "between", index)
            if not isinstance(end, str):
                continue
            if end not in components:
                hint = choose_hint(clip(end, 60), components)
                faults.append(document.fault(path, f"there is no component {clip(end)!r}", hint))
            elif end in ends[:index]:
                faults.append(document.fault(path, f"{clip(end)} is named twice", "name it once"))
    return faults


_BESIDE = {"memory": ("fpga",), "display": ("fpga", "memory")}
"""The types that a component of each type may stand beside."""


def _beside_faults(document: Document) -> list[Fault]:
    """Memories and displays that stand beside what is no component, or one of the wrong type."""
    tree = document.tree if isinstance(document.tree, dict) else {}
    components = tree.get("components")
    if not isinstance(components, dict) or len(components) > MAX_NAMES:
        return []
    faults = []
    for name, component in components.items():
        kind, beside = (component.get(key) for key in ("type", "beside")) if isinstance(component, dict) else (0, 0)
        if not isinstance(kind, str) or kind not in _BESIDE or not isinstance(beside, str):
            continue
        path, accepted = ("components", name, "beside"), _BESIDE[kind]
        other = components.get(beside)
        if other is None:
            what, hint = f"there is no component {clip(beside)!r}", choose_hint(clip(beside, 60), components)
            faults.append(document.fault(path, what, hint))
        elif isinstance(other, dict) and other.get("type") not in accepted:
            what = f"{clip(beside)} is no {' or '.join(accepted)}"
            faults.append(document.fault(path, what, f"name a component of type {' or '.join(accepted)}"))
    return faults


def _name_faults(document: Document) -> list[Fault]:
    return _link_faults(document) + _beside_faults(document) + role_faults(document)


def load_platform(source: Source) -> Platform:
    """The platform with a shipped name (``virtex4-pci``), in a file, in YAML text or in a dict; see ``read_spec``.

    Its parts are looked for in the folder ``parts`` beside the file first (of text and dict: in the current folder),
    then among the shipped ones.

    Raises:
        InputError: no shipped platform of that name.
        SpecError: all the faults of the file.
    """
    document = read_spec(source, "platforms")
    return validate(Platform, document, also=_name_faults).with_document(document)


@functools.cache
def shipped_with(role: str) -> tuple[str, ...]:
    """Names of the shipped platforms that fill a role."""
    return tuple(name for name in list_platforms() if role in load_platform(name).filled)


def no_such(name: str, platform: Platform, kind: str, names: Iterable[str]) -> tuple[str, str]:
    """The fault of a workload that names what a platform does not have, and the remedy.

    Args:
        name: of a component or link, or a role that nothing fills.
        kind: what is looked for, such as ``component``. ``names``: the names that there are.
    """
    if name not in ROLES:
        return f"platform {platform.name} has no {kind} {clip(name)!r}", choose_hint(clip(name, 60), names)
    kind = "link between host and fabric" if name == LINK else f"component of type {ROLE_TYPES[name]}"
    filling = shipped_with(name)
    more = f" or one of {len(filling) - _SHOWN} more (hwsw list)" if len(filling) > _SHOWN else ""
    hint = f"give it roles: {{{name}: NAME}}, a {kind}; or take {', '.join(filling[:_SHOWN])}{more}"
    return f"platform {platform.name} has no {name}", hint


def list_platforms() -> list[str]:
    """Names of the shipped platforms."""
    return shipped_names("platforms")


class PricesFile(Spec):
    """A file of prices: ``hwsw advise --prices`` takes them in place of what platforms declare."""

    kind: Literal["prices"] = Field(description="This file is a list of prices.")
    date: Day = Field(description="The day, month or year of prices that name none of their own.")
    description: str = Field(default="", description="Whose prices they are, for readers.")
    prices: Annotated[dict[Name, OwnPriceFigure], Field(min_length=1)] = Field(
        description="Price of each board, by the name of its platform. In full form only the value is required."
    )

    @property
    def dated(self) -> dict[str, Price]:
        """The prices by platform, each with its date."""
        return {name: replace(price, date=price.date or self.date) for name, price in self.prices.items()}


def load_prices(source: Source, own: Collection[str] = ()) -> PricesFile:
    """The prices of a file, of YAML text, or of a dict. ``own``: names of platforms of the user's own.

    Raises:
        SpecError: all the faults of the file, boards that are none among them.
    """

    document = document_of(source, "prices", lambda file: (Path(file), str(file)))
    tree = document.tree if isinstance(document.tree, dict) else {}
    if tree.get("kind") in ("platform", "workload", "part", "host", "calibration"):
        # All its other keys would be faults too.
        what = f"this is a {tree['kind']}, and prices are asked for"
        raise SpecError([document.fault(("kind",), what, "name a file with kind: prices")])
    return validate(PricesFile, document, also=lambda read: _no_boards(read, own)).with_document(document)


def _no_boards(document: Document, own: Collection[str]) -> list[Fault]:
    """The names that are no platform."""
    tree = document.tree if isinstance(document.tree, dict) else {}
    prices = tree["prices"] if isinstance(tree.get("prices"), dict) else {}
    names = sorted({*list_platforms(), *own})
    unknown = [name for name in prices if isinstance(name, str) and name not in names]
    return [
        document.fault(
            ("prices", name), f"there is no platform {clip(name)!r}", choose_hint(clip(name, 60), names), at_key=True
        )
        for name in unknown
    ]
