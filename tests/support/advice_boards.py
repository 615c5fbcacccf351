"""Small boards and a corridor that questions of ``hwsw advise`` are asked about."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from click.testing import Result

Run = Callable[..., Result]

CELLS = 100
"""Cells of the corridor: a search from one end to the other looks at each of them once."""

PROCESSOR = """\
kind: platform
name: {name}
components:
  cpu:
    type: processor
    clock: 1 GHz
    costs:
      breadth_first_cell: {{value: {cost} us, low: {low} us, high: {high} us, status: assumed, source: a test}}
      breadth_first_map_cell: 0 s
      breadth_first_wall_cell: 0 s
    power: {{busy: {busy} W, idle: {idle} W}}
"""

FABRIC = """\
kind: platform
name: fabric
components:
  fpga: {type: fpga, part: XC2V6000-4, clock: 290 MHz}
  cpu:
    type: processor
    clock: 1 GHz
    costs: {breadth_first_cell: 1 ms, breadth_first_map_cell: 0 s, breadth_first_wall_cell: 0 s}
    power: {busy: 2 W, idle: 1 W}
links:
  bus: {type: bus, between: [cpu, fpga], width: 32, clock: 33 MHz, setup_cycles: 8, burst_words: 16}
"""


def board(folder: Path, name: str, cost: float, *, busy: float = 2.0, idle: float = 1.0) -> Path:
    """A processor with a cost a cell in us, and an interval of half to double."""
    path = folder / f"{name}.yaml"
    text = PROCESSOR.format(name=name, cost=cost, low=cost / 2, high=cost * 2, busy=busy, idle=idle)
    path.write_text(text, encoding="utf-8")
    return path


def asked(hwsw: Run, corridor: Path, boards: list[Path], rate: str, *more: object) -> tuple[int, Any]:
    """The exit code and the JSON of a question from one end of the corridor to the other."""
    names = ",".join(map(str, boards))
    place = ("--goal", "0,0", "--start", f"0,{CELLS - 1}")
    result = hwsw("advise", corridor, *place, "--rate", rate, "--boards", names, *more, "--json")
    assert result.exit_code in (0, 3, 4), result.output
    return result.exit_code, json.loads(result.stdout)


def by_name(answer: Any) -> dict[str, Any]:
    return {each["board"]: each for each in answer["boards"]}


def priced(path: Path, usd: float, beside: str = "") -> Path:
    """The board with a price."""
    more = f", beside: {beside}" if beside else ""
    text = path.read_text(encoding="utf-8")
    price = f"{{value: {usd} USD, status: assumed, source: a test}}"
    path.write_text(f"{text}board: {{product: a product, price: {price}{more}}}\n", encoding="utf-8")
    return path


def powered(path: Path, idle: float) -> Path:
    """The board with a power at its input."""
    power = f"{{idle: {{value: {idle} W, status: measured, source: a test}}}}"
    text = path.read_text(encoding="utf-8")
    path.write_text(f"{text}board: {{product: a product, power: {power}}}\n", encoding="utf-8")
    return path
