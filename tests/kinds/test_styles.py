"""What every table of resources says: of the rows that it is fitted to, of the circuits, and of the styles."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from codesign.ground.figures import Status
from codesign.hardware.fidelity.points import variables_of
from codesign.inputs.library import load_part
from codesign.planners.breadth_first.plan.parameters import Address, SearchParameters
from codesign.planners.breadth_first.styles.resources import block_ram_total
from codesign.planners.circuits import CircuitStyle
from codesign.planners.counted import CountedLaws, _tables
from codesign.planners.harmonic.styles.resources import Machine, fits, totals
from codesign.system import catalog

PART = load_part("LFE5U-85F-8")
COUNTED = "synthesis of the RTL of this package"
CIRCUITS = {key: circuit for key, circuit in catalog.circuits().items() if circuit.laws is not None}


def found() -> Iterator[tuple[CountedLaws, CircuitStyle]]:
    """Every table with a circuit that it is of: that of the circuit, and those of the same rows."""
    for circuit in CIRCUITS.values():
        laws = circuit.laws
        assert laws is not None
        for name, table in _tables(laws.room).items():
            same = all(table.get(key) == laws.table.get(key) for key in ("styles", "task"))
            if same:
                yield laws if name == laws.name else replace(laws, name=name), circuit


TABLES = list(found())
each_table = pytest.mark.parametrize(
    ("laws", "circuit"), TABLES, ids=[f"{laws.room}-{laws.name}-{of.style}" for laws, of in TABLES]
)


def words(entry: Any) -> set[str]:
    """The names in all expressions of a part of a table."""
    values = entry.values() if isinstance(entry, dict) else [entry]
    found = (words(value) if isinstance(value, dict) else re.findall(r"\w+", str(value)) for value in values)
    return set().union(*found)


def test_every_table_is_of_a_registered_circuit() -> None:
    rooms = {laws.room for laws, _ in TABLES}
    assert {(laws.room, laws.name) for laws, _ in TABLES} == {(room, name) for room in rooms for name in _tables(room)}


@each_table
def test_a_law_has_a_row_for_every_name_and_term(laws: CountedLaws, circuit: CircuitStyle) -> None:
    """No definition is unused, and no term is 0 in every row: it would have no coefficient."""
    defined = laws.table.get("define", {})
    used = words({key: value for key, value in laws.table.items() if key != "define"}) | words(defined)
    assert set(defined) <= used
    for piece in laws.pieces:
        for resource in laws.resources(piece):
            terms = [laws.terms(piece, resource, row.variables, row.family) for row in laws.rows]
            for length in {len(each) for each in terms}:
                columns = zip(*(each for each in terms if len(each) == length), strict=True)
                assert all(any(column) for column in columns), (piece, resource)


@each_table
def test_the_interval_of_a_law_holds_every_row(laws: CountedLaws, circuit: CircuitStyle) -> None:
    checked = 0
    for row in laws.rows:
        for piece in laws.pieces if row.family in laws.families else ():
            entry = laws.table["pieces"][piece]
            if laws.holds(entry.get("rows", laws.table.get("where", "True")), row.variables):
                for line in laws.lines(row.variables, (row.family, True), piece)[piece]:
                    low, high = line.figure.interval
                    assert low <= row.count(piece, line.resource) <= high, (piece, row.variables)
                    checked += 1
    assert checked


@each_table
def test_a_family_without_rows_has_wider_intervals_and_assumes(laws: CountedLaws, circuit: CircuitStyle) -> None:
    row = next(row for row in laws.rows if row.family == laws.table["similar"] and laws.held_out(row.variables))
    assert laws.family("assumed array chip") == (row.family, False)
    own, other = (laws.lines(row.variables, (row.family, known)) for known in (True, False))
    for piece in laws.pieces:
        for line, assumed in zip(own[piece], other[piece], strict=True):
            assert assumed.amount == line.amount
            assert assumed.figure.status is Status.ASSUMED
            (low, high), (least, most) = line.figure.interval, assumed.figure.interval
            assert least <= low <= high <= most


@each_table
@pytest.mark.parametrize("seed", range(3))
def test_a_style_demands_what_the_table_says_of_its_circuit(
    laws: CountedLaws, circuit: CircuitStyle, seed: int
) -> None:
    """The parameters of the top module alone give the same counts as the layout that the style makes of a job."""
    job = replace(circuit.sample(seed), part=PART)
    if circuit.task:
        style: Any = catalog.task_styles()[circuit.planner, circuit.task, "fpga", circuit.style]
    else:
        style = catalog.architectures()[circuit.planner, circuit.style]
        job = replace(job, parameters=style.settled(job.parameters))
    variables = variables_of(circuit.circuit(job))
    if not laws.holds(laws.table.get("where", "True"), variables):
        return
    family = laws.family(PART.family)
    told = [line for line in style.demand(job).items if line.figure.source.startswith(COUNTED)]
    assert told
    for line in told:
        if line.name in laws.pieces:
            (same,) = (
                each for each in laws.lines(variables, family, line.name)[line.name] if each.resource == line.resource
            )
            assert (same.amount, same.figure.interval) == (line.amount, line.figure.interval), line.name


FPGA_STYLES = [
    (planner, style, "", each)
    for (planner, style), each in catalog.architectures().items()
    if each.component_type == "fpga"
] + [
    (planner, style, task, each)
    for (planner, task, component, style), each in catalog.task_styles().items()
    if component == "fpga"
]


@pytest.mark.parametrize(
    ("planner", "style", "task", "laws"), FPGA_STYLES, ids=["-".join(each[:3]) for each in FPGA_STYLES]
)
def test_a_style_has_a_circuit_or_assumes_its_logic(planner: str, style: str, task: str, laws: Any) -> None:
    if (planner, style, task) in catalog.circuits():
        return
    whole = next(each for (room, _, _), each in catalog.circuits().items() if room == planner)
    lines = laws.demand(replace(whole.sample(0), part=PART)).items
    logic = [line for line in lines if line.resource in ("lut4", "flip_flops", "slices")]
    assert logic
    assert {line.figure.status for line in logic} == {Status.ASSUMED}


@pytest.mark.parametrize("name", ["GW1NR-9-6", "XC3S500E-4", "LFE5U-85F-8"])
@pytest.mark.parametrize("address", list(Address))
def test_demand_never_falls_along_what_is_bisected(name: str, address: Address) -> None:
    """The premise of ``largest``: behind a candidate that does not fit, none fits."""
    part = load_part(name)
    parameters, machine = SearchParameters(address=address), Machine(24, 36, 63)
    maps = [block_ram_total(side, side, parameters, part) for side in range(1, 300)]
    queues = [
        block_ram_total(200, 200, parameters.model_copy(update={"queue_words": 1 << bits}), part)
        for bits in range(4, 17)
    ]
    blocks = [fits(replace(machine, rows=rows, columns=rows * 3 // 2), part) for rows in range(1, 60)]
    lasts = [totals(replace(machine, last=last), part.family)["slices"] for last in range(1, 63)]
    assert maps == sorted(maps)
    assert queues == sorted(queues)
    assert lasts == sorted(lasts)
    assert blocks == sorted(blocks, reverse=True)
