"""A file of prices: what the user pays for boards, in place of what their platforms declare."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from codesign.ground.errors import Fault, SpecError, choose_hint, clip
from codesign.ground.figures import Price
from codesign.inputs.base import Spec
from codesign.inputs.document import Document
from codesign.inputs.faults import validate
from codesign.inputs.fields import Day, Name, OwnPriceFigure
from codesign.inputs.files import Source, document_of
from codesign.inputs.platform import list_platforms


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
