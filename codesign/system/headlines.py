"""The headlines of what ships and of what is installed, read without building any model that they do not need."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from codesign import inputs as spec
from codesign.ground.figures import Price, label
from codesign.ground.late import late
from codesign.ground.models import Part
from codesign.inputs.fields import PriceFigure
from codesign.inputs.files import data_folder, shipped_names, shown
from codesign.inputs.library import HOSTS, all_parts
from codesign.inputs.yaml_tree import read_document
from codesign.planners.registered import kept_headlines, registered

catalog = late("codesign.system.catalog")


class _Board(BaseModel):
    price: PriceFigure | None = None


class _Component(BaseModel):
    type: str
    part: Any = None


class _Head(BaseModel):
    """The head of a platform or of a workload: the keys of their models that a list shows."""

    model_config = ConfigDict(strict=True)

    kind: Literal["platform", "workload"]
    description: str = ""
    components: dict[str, _Component] = {}
    board: _Board | None = None


def _head(name: str, folder: str) -> _Head:
    """The head of a shipped file. One that cannot be read is read whole.

    Raises:
        SpecError: all the faults of a file with a faulty head.
    """
    path = data_folder(folder) / f"{name}.yaml"
    document = read_document(path, shown(path))
    try:
        head = _Head.model_validate(document.tree)
    except ValidationError:
        head = None
    if head is None or document.faults:
        spec.load_platform(name) if folder == "platforms" else catalog.load_workload(name)
    assert head is not None
    return head


def at_hand() -> dict[str, dict[str, str]]:
    """Names and one-line descriptions of what ships or is installed, by kind."""
    platforms = {name: _board(_head(name, "platforms")) for name in shipped_names("platforms")}
    hosts = {name: HOSTS.find(name).description for name in sorted(HOSTS.names())}
    workloads = {name: _head(name, "workloads").description for name in shipped_names("workloads")}
    parts = {name: _budgets(part) for name, part in all_parts().items()}
    names: dict[str, dict[str, str]] = {
        "platforms": platforms,
        "workloads": workloads,
        "parts": parts,
        "hosts": hosts,
        "planners": {},
        "tasks": {},
        "styles": {},
    }
    points, kept = registered(), kept_headlines()
    # What others registered is loaded: nothing else says what it is, or that it is broken.
    foreign = any(point.value not in kept for point in points)
    for point in points:
        for kind, lines in (kept.get(point.value) or catalog.headlines_of(point)).items():
            names[kind] |= lines
    broken = {f"{plug_in.name} ({plug_in.value})": plug_in.why for plug_in in (catalog.broken() if foreign else ())}
    return {**names, "broken plug-ins": broken} if broken else names


def _board(platform: _Head) -> str:
    """Its description, and its part and price where it has them."""
    chips = [each.part for each in platform.components.values() if each.type == "fpga"]
    price = platform.board.price if platform.board is not None else None
    facts = [*chips, *([] if price is None else [f"{price.value:,g} {price.unit}{_seen(price)}, {price.status}"])]
    return f"{platform.description} [{'; '.join(facts)}]" if platform.board and facts else platform.description


def _seen(price: Price) -> str:
    return f" of {price.date}" if price.date else ""


def _budgets(part: Part) -> str:
    budgets = (f"{int(figure.value):,} {label(name)}" for name, figure in part.resources.items())
    return f"{part.family}: {', '.join(budgets)}"
