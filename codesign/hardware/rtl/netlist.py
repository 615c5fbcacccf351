"""Netlists of Yosys as JSON: modules counted, and their hierarchy walked."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from codesign.hardware.rtl.cells import Counts, counts_of

Cells = dict[str, dict[str, Any]]


def verilog_name(module: str) -> str:
    r"""The name of a module in its source: Yosys adds the parameters or their digest.

    >>> verilog_name(r"$paramod$317dc02e\ram_1w1r"), verilog_name(r"$paramod\node\PIPELINE=s32'01"), verilog_name("top")
    ('ram_1w1r', 'node', 'top')
    """
    return module.split("\\")[1] if module.startswith("$paramod") else module.lstrip("\\")


@dataclass(frozen=True, eq=False)
class Netlist:
    """A hierarchy of mapped modules. ``modules``: of the JSON, without the cell library; ``top``: one name."""

    modules: Mapping[str, dict[str, Any]]
    top: str

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Netlist:
        """The netlist of what ``write_json`` wrote."""
        modules = {
            name: module
            for name, module in document["modules"].items()
            if not _is_set(module, "blackbox") and not _is_set(module, "whitebox")
        }
        return cls(modules, next(name for name, module in modules.items() if _is_set(module, "top")))

    def cells(self, module: str) -> Cells:
        """The cells of a module by name: cells of the library, and the modules in it."""
        cells: Cells = self.modules[module]["cells"]
        return cells

    @cached_property
    def own(self) -> dict[str, Counts]:
        """The resources of each module by itself, without the modules in it."""
        return {
            name: sum(
                (
                    counts_of(kind) * times
                    for kind, times in Counter(cell["type"] for cell in self.cells(name).values()).items()
                    if kind not in self.modules and not kind.startswith("$")
                ),
                Counts(),
            )
            for name in self.modules
        }

    @cached_property
    def inside(self) -> dict[str, Counter[str]]:
        """The modules that stand in each module, with how often."""
        return {
            name: Counter(cell["type"] for cell in self.cells(name).values() if cell["type"] in self.modules)
            for name in self.modules
        }

    def instances(self) -> Counter[str]:
        """The number of instances of each module in the whole design."""
        often: Counter[str] = Counter()

        def add(module: str, times: int) -> None:
            often[module] += times
            for name, number in self.inside[module].items():
                add(name, times * number)

        add(self.top, 1)
        return often

    def paths(self) -> Iterator[tuple[str, str]]:
        """Every instance with its path, ``nodes[3].node``, and its module in the source, the outermost first."""

        def below(module: str, path: str) -> Iterator[tuple[str, str]]:
            for name, cell in self.cells(module).items():
                if cell["type"] in self.modules:
                    whole = f"{path}{name}"
                    yield whole, verilog_name(cell["type"])
                    yield from below(cell["type"], f"{whole}.")

        return below(self.top, "")

    def by_piece(self, pieces: Mapping[str, tuple[str, ...]]) -> dict[str, Counts]:
        """The counts of each piece, ``Circuit.pieces``; what stands in none under "".

        A module that is in no piece is counted with the module that contains it.
        """
        piece_of = {module: piece for piece, names in pieces.items() for module in names}
        sums: dict[str, Counts] = {piece: Counts() for piece in pieces}

        def add(module: str, around: str, times: int) -> None:
            piece = piece_of.get(verilog_name(module), around)
            sums[piece] = sums.get(piece, Counts()) + self.own[module] * times
            for name, number in self.inside[module].items():
                add(name, piece, times * number)

        add(self.top, "", 1)
        return sums


def _is_set(module: Mapping[str, Any], attribute: str) -> bool:
    return any(digit == "1" for digit in str(module.get("attributes", {}).get(attribute, "")))
