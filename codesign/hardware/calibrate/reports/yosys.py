"""The counts of Yosys: the output of ``stat``, as text and as JSON, of one module or of a hierarchy.

Cells are counted as ``rtl.cells`` counts them for ``hwsw synth``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from codesign.hardware.calibrate.reports.engine import Fields, Inside, Kind, Reading, Stage, Text, Tool, added
from codesign.hardware.rtl.cells import COUNTED, Counts

_TITLE = r"^=== (.*) ===$"
_DEEPEST = 256
_MOST_PLACES = 100_000

Modules = dict[str, dict[str, tuple[int, int]]]
"""Of each module, the count and the line of each type of cell, inner modules included."""


def _stat(text: Text) -> Fields:
    """The counts of ``stat``.

    Raises:
        SpecError: it is cut off or no JSON, or has several designs.
    """
    modules, version = _of_json(text) if text.is_json else (_of_text(text), "")
    inner = {name for cells in modules.values() for name in cells if name in modules}
    tops = [name for name in modules if name not in inner]
    if len(tops) != 1:
        listed = ", ".join(_plain(name) for name in tops[:6]) or "none"
        what = f"has {len(tops)} modules at the top: {listed}"
        raise text.fault(0, what, "run stat on one design, after hierarchy -top")
    places = _places(text, modules, tops[0])
    used: Mapping[str, Reading] = {resource: Reading(0.0, 1) for resource in asdict(Counts())}
    for place in places:
        used = added(used, place.used)
    hierarchy = places if len(places) > 1 else ()
    return {"version": version, "top": _plain(tops[0]), "used": used, "hierarchy": hierarchy}


def _plain(name: str) -> str:
    r"""The name of a module as its file has it.

    >>> _plain("$paramod\\node\\W=s32'1"), _plain("\\top"), _plain("$paramod$1a2b\\node")
    ('node', 'top', 'node')
    """
    if name.startswith("$paramod"):
        return name.split("\\")[1] if "\\" in name else name
    return name.removeprefix("\\")


def _of_text(text: Text) -> Modules:
    modules: Modules = {}
    needed: set[str] = set()
    titles = [(line, match.group(1)) for line, match in text.all(_TITLE)]
    for index, (begin, name) in enumerate(titles):
        if name == "design hierarchy":
            continue
        end = titles[index + 1][0] - 1 if index + 1 < len(titles) else len(text.lines)
        modules[name], inner = _cells(text, begin, end)
        needed |= inner
    missing = needed - modules.keys()
    if missing:
        raise text.cut_off(f"module {_plain(min(missing))}")
    return modules


def _cells(text: Text, begin: int, end: int) -> tuple[dict[str, tuple[int, int]], set[str]]:
    """The cells of a section, and the types among them that are modules of the design.

    A line is ``4  CCU2C``, in older versions ``CCU2C  4``. The sum is the line ``cells``.
    """
    cells: dict[str, tuple[int, int]] = {}
    modules: set[str] = set()
    total, inner = 0, None
    seen = False
    for number in range(begin + 1, end + 1):
        line = text.lines[number - 1]
        match = re.match(r"^\s*(?:([\d-]+) +)?(\d+|-)(?: +(?:[\d.eE+-]+))? +(\S+)\s*$", line)
        older = re.match(r"^\s*(\S+?):?\s+(\d+)\s*$", line)
        if re.match(r"^\s*(?:[\d-]+ +)?[\d-]+ cells\s*$|^\s*Number of cells:", line):
            seen = True
            digits = re.findall(r"\d+", line)
            total = int(digits[-1]) if digits else 0
        elif re.match(r"^\s*(?:[\d-]+ +)?[\d-]+ submodules\s*$", line):
            digits = re.findall(r"\d+", line)
            inner = int(digits[-1]) if digits else 0
        elif seen and match:
            modules |= set() if inner is None else {match.group(3)}
            cells[match.group(3)] = (0 if match.group(2) == "-" else int(match.group(2)), number)
        elif seen and older:
            cells[older.group(1)] = (int(older.group(2)), number)
        elif seen and cells:
            break
    if end == len(text.lines) and text.lines[-1].strip():
        raise text.cut_off("the empty line at the end")
    counted = sum(count for count, _ in cells.values())
    if not seen or counted not in (total, total + (inner or 0)):
        what = f"the report is cut off: {counted} of {total} cells of {text.lines[begin - 1]} are listed"
        raise text.fault(min(end, len(text.lines)), what, "write it again")
    return cells, modules


def _of_json(text: Text) -> tuple[Modules, str]:
    tree = text.json()
    modules: Modules = {}
    listed = tree.get("modules")
    for name, module in (listed if isinstance(listed, dict) else {}).items():
        if not isinstance(module, dict):
            raise text.fault(text.line_of(name), f"module {_plain(name)} is no object", "write it again")
        sections = [module.get(key) for key in ("num_cells_by_type", "num_submodules_by_type")]
        cells = {
            kind: (_count(text, kind, count), text.line_of(name))
            for section in sections
            if isinstance(section, dict)
            for kind, count in section.items()
        }
        modules[name] = cells
    version = re.match(r"Yosys (\S+)", str(tree.get("creator", "")))
    return modules, version.group(1) if version else ""


def _count(text: Text, kind: str, count: Any) -> int:
    if isinstance(count, dict):
        hint = "write it with stat -json alone, or as text"
        raise text.fault(text.line_of(kind), "counts inner modules twice: the JSON of stat -hierarchy", hint)
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= 10**9:
        raise text.fault(text.line_of(kind), f"the number of {_plain(kind)} is no count", "write it again")
    return count


def _places(text: Text, modules: Modules, top: str) -> tuple[Inside, ...]:
    """The resources of each place of the design by itself: its cells, times its instances."""
    own = {name: _own(cells, modules) for name, cells in modules.items()}
    places: dict[tuple[str, ...], dict[str, Reading]] = {}
    stack: list[tuple[str, int, tuple[str, ...]]] = [(top, 1, ())]
    for _ in range(_MOST_PLACES):
        if not stack:
            return tuple(Inside(path, used) for path, used in places.items())
        name, times, path = stack.pop()
        places[path] = added(places.get(path, {}), own[name], times)
        if len(path) > _DEEPEST:
            break
        stack += [
            (kind, times * count, (*path, _plain(kind)))
            for kind, (count, _) in modules[name].items()
            if kind in modules and count
        ]
    raise text.fault(0, "has modules that contain themselves, or too many", "write it again")


def _own(cells: Mapping[str, tuple[int, int]], modules: Modules) -> dict[str, Reading]:
    """The resources of a module without the modules inside it. Pins and buffers count as none."""
    used: dict[str, Reading] = {}
    for kind, (count, line) in cells.items():
        counts = next((counts for pattern, counts in COUNTED if pattern.fullmatch(kind)), Counts())
        if kind not in modules and count:
            amounts = {name: Reading(count * each, line) for name, each in asdict(counts).items() if each}
            used = added(used, amounts)
    return used


YOSYS = Tool(
    "Yosys",
    marks=(_TITLE, r"^\s*(?:[\d-]+ +)?(?:[\d-]+ cells$|Number of cells:)"),
    keys=("num_cells_by_type", "modules"),
    kinds=(Kind("", _stat, stage=Stage.SYNTHESISED),),
)
