"""The demand of the state machine: memories, logic and display; and the levers for a shortage.

There are three memories of a word for each address: the cells (obstacle, free, goal, visited), the directions (2 bits)
and the queue (an address each, or as many words as given). A display that has a copy has one of the cells and one of
the directions. Logic is what synthesis counts of the RTL of this package, by family: lines over the bits of an address,
fitted to some sizes and held against others (``planners/breadth_first/measured/laws.yaml``).
"""

from __future__ import annotations

from collections.abc import Mapping

from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part
from codesign.planners.breadth_first import published
from codesign.planners.breadth_first.plan.parameters import (
    Address,
    MemoryPlace,
    MicroArchitecture,
    SearchParameters,
    VgaController,
)
from codesign.planners.breadth_first.styles import timing
from codesign.planners.counted import CountedLaws, index_bits
from codesign.planners.external_memory import ExternalMemoryLaw
from codesign.planners.interface import Problem
from codesign.planners.job import Lever, Line, largest, packed, part_lever

CELL_BITS = 2
DIRECTION_BITS = 2

CONTROLLER_LUT4, CONTROLLER_FLIP_FLOPS = 600, 600
"""The controller of an external dynamic RAM. Assumed."""
SRAM_LUT4 = 60
"""LUT of the controller of an external static RAM: a counter and no refreshing. Each pin takes a flip-flop. Assumed."""
BUFFERS = 2
"""Buffers of an external queue, one at each end; a LUT holds one bit of 16 entries. Assumed."""

PORTS = 2

LARGEST_SIDE = 4096
"""Of the maps that a lever names."""


def address_bits(rows: int, columns: int, address: Address = Address.SIDE_BY_SIDE) -> int:
    """Bits of a cell's address.

    >>> [address_bits(side, side) for side in (30, 100, 130)]
    [10, 14, 16]
    >>> [address_bits(side, side, Address.LINEAR) for side in (30, 100, 130)]
    [10, 14, 15]
    """
    # Side by side, each side is rounded up to a power of two.
    if address is Address.LINEAR:
        return index_bits(timing.cell_words((rows, columns), address))
    return index_bits(rows) + index_bits(columns)


def on_screen(shape: tuple[int, int]) -> bool:
    """True if a map of (rows, columns) has a pixel a cell on its half of the screen."""
    return shape[0] <= published.DISPLAY_ROWS and shape[1] <= published.DISPLAY_COLUMNS // 2


def block_rams(words: int, width: int, part: Part) -> int:
    """The fewest block RAMs of a part that hold ``words`` of ``width`` bits."""
    return _blocks(words, width, part.block_ram_shapes)


def _blocks(words: int, width: int, shapes: tuple[tuple[int, int], ...]) -> int:
    # ⌈words / depth⌉ · ⌈bits / width⌉ for each shape that a block can take.
    return min(-(-words // depth) * -(-width // wide) for depth, wide in shapes)


def memories(rows: int, columns: int, parameters: SearchParameters) -> dict[str, tuple[int, int]]:
    """(words, bits a word) of every memory on the chip."""
    bits = address_bits(rows, columns, parameters.address)
    words = 1 << bits
    shapes = {}
    if parameters.memory is not MemoryPlace.EXTERNAL:
        shapes["cells"] = words, CELL_BITS
    if parameters.display is VgaController.COPY:
        shapes["copy of the cells"] = words, CELL_BITS
        shapes["copy of the directions"] = words, DIRECTION_BITS
    if parameters.memory is MemoryPlace.BLOCK_RAM:
        shapes["directions"] = words, DIRECTION_BITS
        shapes["queue"] = parameters.queue_words or words, bits
    return shapes


def held(shape: tuple[int, int], parameters: SearchParameters, part: Part) -> dict[str, tuple[str, int]]:
    """The kind of RAM of every memory on the chip, "" for block RAM, and its blocks.

    Where the block RAM is short, the largest memories move to other RAM that has ports and blocks enough. The queue and
    the cells are read and written in one cycle. The directions are written by the search and read by Path alone.
    """
    words = memories(*shape, parameters)
    placed = {name: ("", block_rams(*each, part)) for name, each in words.items()}
    left = {kind: int(ram.count.value) for kind, ram in part.other_rams.items()}
    for name in sorted(placed, key=lambda name: -placed[name][1]):
        if _of_kind(placed, "") <= part.resources["block_rams"].value:
            break
        ports = 1 if name == "directions" and parameters.display is not VgaController.SHARED else PORTS
        for kind, ram in part.other_rams.items():
            need = _blocks(*words[name], ram.shapes)
            if ram.ports >= ports and need <= left[kind]:
                placed[name], left[kind] = (kind, need), left[kind] - need
                break
    return placed


def _of_kind(placed: Mapping[str, tuple[str, int]], wanted: str) -> int:
    return sum(blocks for kind, blocks in placed.values() if kind == wanted)


RAM_BLOCKS = "RAM blocks"
"""The unit of a demand for other RAM."""


def other_rams(shape: tuple[int, int], parameters: SearchParameters, part: Part) -> tuple[Line, ...]:
    """Blocks of each kind of other RAM that holds a memory."""
    placed, words = held(shape, parameters, part), memories(*shape, parameters)
    lines = []
    for kind, ram in part.other_rams.items():
        inside = [name for name, (each, _) in placed.items() if each == kind]
        if inside:
            of = ", ".join(f"{name} of {words[name][0]:,} words of {words[name][1]} bits" for name in inside)
            law = f"{of}; no circuit was synthesised with it"
            lines.append(Line.bound(kind, _of_kind(placed, kind), ram.count, RAM_BLOCKS, Status.ASSUMED, law))
    return tuple(lines)


def ram_clock(shape: tuple[int, int], parameters: SearchParameters, part: Part) -> Figure:
    """The fastest clock of all kinds of RAM that hold a memory."""
    kinds = {kind for kind, _ in held(shape, parameters, part).values() if kind}
    return min((part.block_ram_clock, *(part.other_rams[kind].clock for kind in kinds)), key=lambda clock: clock.value)


def controller(external: ExternalMemoryLaw | None) -> tuple[int, int]:
    """LUT and flip-flops of the controller of an external memory; None: of a dynamic RAM that the platform omits."""
    if external is None or external.technology == "dram":
        return CONTROLLER_LUT4, CONTROLLER_FLIP_FLOPS
    return SRAM_LUT4, 2 * external.width + external.words.bit_length()


LAWS = CountedLaws(
    "breadth_first",
    "machine",
    {
        "side_bits": index_bits,
        "CELL_BITS": CELL_BITS,
        "PIPELINED_CYCLES": timing.EXPANSION_CYCLES[MicroArchitecture.PIPELINED],
    },
)
"""The logic of the ``state machine`` and of the ``display``."""


def counted(piece: str, shape: tuple[int, int], parameters: SearchParameters, part: Part) -> tuple[Line, ...]:
    """LUT and flip-flops of the ``state machine`` or the ``display``."""
    bits = address_bits(*shape, parameters.address)
    design = {
        "ADDRESS_BITS": bits,
        "QUEUE_WORDS": parameters.queue_words or 1 << bits,
        "LINEAR": int(parameters.address is Address.LINEAR),
        "CYCLES": timing.EXPANSION_CYCLES[parameters.micro_architecture],
        "SHOWN": int(parameters.display is not VgaController.NONE),
    }
    return LAWS.lines(design, LAWS.family(part.family), piece)[piece]


def items(
    problem: Problem, parameters: SearchParameters, part: Part, external: ExternalMemoryLaw | None = None
) -> tuple[Line, ...]:
    """The demand of a design, item by item."""
    bits = address_bits(*problem.shape, parameters.address)
    shown = parameters.display is not VgaController.NONE
    logic = [
        counted(piece, problem.shape, parameters, part)
        for piece in (("state machine", "display") if shown else ("state machine",))
    ]
    if parameters.memory is not MemoryPlace.BLOCK_RAM:
        kind = external.technology if external else "dram"
        source = f"the order of a controller of {kind}; the paper has none"
        logic.append(_assumed("memory controller", *controller(external), source))
        if external is not None:
            logic.append(_assumed("queue buffers", BUFFERS * bits, BUFFERS * bits, "two of 16 entries, in LUT"))
    lines = [line for piece in logic for line in (packed(piece), *piece)]
    words = memories(*problem.shape, parameters)
    for name, (other, blocks) in held(problem.shape, parameters, part).items():
        if not other:
            law = f"{words[name][0]:,} words of {words[name][1]} bits, as synthesis counts the RTL of this package"
            lines.append(Line.item(name, "block_rams", blocks, Status.MEASURED, law))
    return tuple(lines)


def _assumed(name: str, lut4: int, flip_flops: int, source: str) -> tuple[Line, Line]:
    """LUT and flip-flops that nobody counted."""
    return (
        Line.item(name, "lut4", lut4, Status.ASSUMED, source),
        Line.item(name, "flip_flops", flip_flops, Status.ASSUMED, source),
    )


def block_ram_total(rows: int, columns: int, parameters: SearchParameters, part: Part) -> int:
    """Block RAMs of a design."""
    return _of_kind(held((rows, columns), parameters, part), "")


def largest_side(parameters: SearchParameters, part: Part) -> int:
    """Side of the largest square map that fits the block RAMs of the part; 0: not even one cell."""
    budget = part.resources["block_rams"].value
    sides = range(1, LARGEST_SIDE + 1)
    return largest(sides, lambda side: block_ram_total(side, side, parameters, part) <= budget) or 0


def levers(problem: Problem, parameters: SearchParameters, part: Part) -> dict[str, tuple[Lever, ...]]:
    """The levers for a lack of block RAMs, each with its figure."""
    budget = int(part.resources["block_rams"].value)
    shape = problem.shape
    need = block_ram_total(*shape, parameters, part)
    if need <= budget:
        return {}
    advice = []
    dropped = {} if parameters.display is VgaController.NONE else {"display": VgaController.NONE}
    for changes in (
        dropped if parameters.display is VgaController.COPY else {},
        {"address": Address.LINEAR},
        {"memory": MemoryPlace.PROCESS_EXTERNAL},
        {"memory": MemoryPlace.EXTERNAL, **dropped},
    ):
        changed = parameters.model_copy(update=changes)
        total = block_ram_total(*shape, changed, part)
        if total < need:
            (name, value), *others = changes.items()
            also = "".join(f", with {other} {word}" for other, word in others)
            text = "" if total <= budget else ", still too many"
            axes = {f"search.{key}": str(word) for key, word in changes.items()}
            advice.append(Lever(f"search.{name}", f"{value}{also}: {total:,} block RAMs{text}", axes=axes))
    queue = _largest_queue(shape, parameters, part, budget)
    if queue:
        text = f"at most {queue:,} words fit; a search that needs more is refused"
        advice.append(Lever("search.queue_words", text, axes={"search.queue_words": queue}))
    side = largest_side(parameters, part)
    advice.append(Lever("problem.map", f"at most {side} × {side} cells fit {part.name} with these parameters"))
    advice.append(part_lever("block_rams", need))
    return {"block_rams": tuple(advice)}


def _largest_queue(shape: tuple[int, int], parameters: SearchParameters, part: Part, budget: int) -> int:
    """Words of the largest circular queue, a power of two, that fits with the other memories; 0: none."""
    if parameters.memory is not MemoryPlace.BLOCK_RAM:
        return 0

    def fits(words: int) -> bool:
        changed = parameters.model_copy(update={"queue_words": words})
        return block_ram_total(*shape, changed, part) <= budget

    return largest([1 << bits for bits in range(4, address_bits(*shape, parameters.address))], fits) or 0


def bounds(problem: Problem, parameters: SearchParameters, queue_depth: int | None) -> tuple[Line, ...]:
    """Ports of the cells' memory, words of the queue, pixels of the display.

    ``queue_depth``: the cells that the search of this problem puts into a queue shorter than the map.
    """
    lines = []
    if parameters.memory is not MemoryPlace.EXTERNAL or parameters.display is VgaController.SHARED:
        lines.append(_ports(parameters))
    if parameters.queue_words is not None and queue_depth is not None:
        enough = 1 << max(0, queue_depth - 1).bit_length()
        lines.append(
            Line.bound(
                "words of the queue",
                queue_depth,
                parameters.queue_words,
                "cells",
                Status.MEASURED,
                "the search of this problem, exact",
                (
                    Lever(
                        "search.queue_words",
                        f"at least {queue_depth:,}; {enough:,} is the next power of two",
                        axes={"search.queue_words": enough},
                    ),
                ),
            )
        )
    if parameters.display is not VgaController.NONE:
        pixels = f"{published.PAPER}, section 3.2: map and directions side by side on 800×600 pixels"
        none = {"search.display": str(VgaController.NONE)}
        advice = (Lever("search.display", "none: the map is larger than the screen", axes=none),)
        for name, demand, limit in (
            ("rows on the screen", problem.rows, published.DISPLAY_ROWS),
            ("columns on the screen", problem.columns, published.DISPLAY_COLUMNS // 2),
        ):
            lines.append(Line.bound(name, demand, limit, "cells", Status.PUBLISHED, pixels, advice))
    return tuple(lines)


def _ports(parameters: SearchParameters) -> Line:
    on_chip = parameters.memory is not MemoryPlace.EXTERNAL
    search = timing.SEARCH_ADDRESSES[parameters.micro_architecture] if on_chip else 0
    none = {"search.display": str(VgaController.NONE)}
    text = "copy: the display reads a copy of its own; none: it is left out"
    levers = [Lever("search.display", text, axes={"search.display": str(VgaController.COPY)})]
    if not on_chip:
        inside = {"search.memory": str(MemoryPlace.PROCESS_EXTERNAL)}
        levers.append(Lever("search.memory", "process_external: the cells stay on the chip", axes=inside))
    elif search == PORTS:
        text, axis = "two_cycles or three_cycles: the search takes one port", "search.micro_architecture"
        levers.append(Lever(axis, text, axes={axis: "two_cycles"}))
        text = "none, and a display of the platform beside the FPGA: it stalls the search"
        levers.append(Lever("search.display", text, axes=none))
    return Line.bound(
        name="ports of the cells' block RAM",
        demand=search + (parameters.display is VgaController.SHARED),
        limit=PORTS if on_chip else 0,
        unit="addresses a cycle",
        status=Status.MEASURED,
        source="dual-port block RAM: pipelined, the search reads one neighbour while it marks another; external cells"
        " leave none to the display",
        levers=tuple(levers),
    )
