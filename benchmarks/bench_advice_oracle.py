"""Whether a design that is drawn at random, whatever bounds and families say, contradicts an answer about boards.

Each question is asked, then designs are drawn for every board that costs less than the recommended one, or for all
where none suffices: any tile, block, schedule, method and placement, at the fastest clock that it reaches. A drawn
design that meets every need, on a board of which the answer says that none does, is a contradiction. Half of them are
in the space that the answer speaks of, the others are free of it: what these find stands in a column of its own.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from inspect import isclass
from itertools import chain
from pathlib import Path
from random import Random
from typing import Any, get_args
from unittest.mock import Mock

from codesign import maps
from codesign.ground.errors import CodesignError
from codesign.ground.memo import Memo
from codesign.inputs import design_point
from codesign.inputs.components import FpgaComponent
from codesign.inputs.workload import PLACE_KEYS
from codesign.planners.grid_search.plan.parameters import SearchParameters
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.styles.designs import FIRST, LAST, STEP, VISITS
from codesign.study import advice
from codesign.study.advice.certainty import shortfalls_of
from codesign.study.advice.needs import Question, workload_tree
from codesign.study.advice.trials import as_asked, trial_of
from codesign.system import catalog
from codesign.system.scenarios import simulate

TIMES = 10
"""Designs that are drawn for each one that the answer tried."""

LEAST_DRAWN = 200

MOST_S = 60.0
"""Seconds of processor time after which no further design of a question is drawn."""

REAL = Path(__file__).parents[1].parent / "shared" / "maps" / "movingai"


@dataclass(frozen=True)
class Asked:
    """A question: a map by its generator or its file, what is asked, and of which boards."""

    kind: str
    side: int
    rate: str
    boards: tuple[str, ...]
    limits: Mapping[str, str] = field(default_factory=dict)
    file: Path | None = None

    def __str__(self) -> str:
        name = f"{self.kind} {self.side}×{self.side}" if self.file is None else self.file.stem
        more = "".join(f", {key} {value}" for key, value in self.limits.items())
        return f"{name}, {self.rate}{more}"

    def question(self, folder: Path, starts: int = 2) -> Question:
        """The question, with a goal in a corner and starts drawn far from each other."""
        file = self.file
        if file is None:
            shape = {"rows": self.side, "columns": self.side}
            more = {"random": {"density": 0.2, "seed": self.side}, "maze": {"corridor": 2, "seed": self.side}}
            grid = maps.generate(self.kind, **shape, **more.get(self.kind, {}))
            file = folder / f"{self.kind}-{self.side}.txt"
            lines = ("".join("." if cell else "#" for cell in row) + "\n" for row in grid.free)
            file.write_text("".join(lines), encoding="utf-8")
        free = maps.read_map(file).free
        goal = maps.nearest_free(free, (0, 0))
        cells = [tuple(map(int, each)) for each in zip(*maps.reachable(free, [goal]).nonzero(), strict=True)]
        chosen = Random(self.side).sample(cells, min(starts, len(cells)))
        needs = advice.parse_needs(self.rate, self.limits.get("power"), self.limits.get("price"))
        detour = self.limits.get("detour")
        on: Any = self.limits.get("on")
        needs = advice.limited(needs, detour=None if detour is None else float(detour), on=on)
        places = [f"{row},{column}" for row, column in chosen]
        section = advice.problem_section(file, [f"{goal[0]},{goal[1]}"], places, needs, reach=0.0)
        return advice.ask(needs, section, file)


SMALL = "pico-2", "esp32-s3-devkitc", "nucleo-h743zi", "icesugar", "tang-nano-20k"
FABRICS = "pynq-z2", "kv260", "ultra96-v2", "icebreaker", "cmod-a7-35t", "arty-a7-spi", "tang-nano-9k", "basys-3"
HOSTS = "pico", "raspberry-pi-3", "raspberry-pi-4", "raspberry-pi-5", "teensy-4-1"


def questions() -> Iterator[Asked]:
    """Forty questions whose answers are boards of different kinds, or none."""
    mixed = (*SMALL[:3], *FABRICS[:4], "raspberry-pi-4", "zcu104")
    for number, kind in enumerate(("empty", "random", "maze")):
        for side, rates in (
            (20, ("200Hz", "20kHz", "200kHz", "1MHz")),
            (60, ("500Hz", "30kHz", "200kHz")),
            (200, ("50Hz", "6kHz", "100kHz")),
        ):
            for place, rate in enumerate(rates):
                boards = (mixed, (*FABRICS, "raspberry-pi-4"), (*HOSTS, *SMALL, "zcu104"))[(number + place) % 3]
                yield Asked(kind, side, rate, boards)
    yield Asked("empty", 40, "20kHz", mixed, {"power": "5W"})
    yield Asked("maze", 40, "20kHz", mixed, {"price": "200USD"})
    yield Asked("random", 40, "2kHz", mixed, {"detour": "1.05"})
    yield Asked("random", 80, "20kHz", mixed, {"on": "fabric"})
    files = ("cities/Berlin_0_256", "dao/arena", "rooms/16room_000", "mazes/maze512-32-0")
    for place, name in enumerate(files):
        file = REAL / f"{name}.map"
        if file.exists():
            yield Asked("file", 256, ("4kHz", "50kHz", "200Hz", "400Hz")[place], mixed, file=file)
    yield Asked("empty", 100, "40kHz", mixed, {"on": "fabric", "power": "6W"})
    yield Asked("maze", 100, "10kHz", FABRICS)


# Designs at random: of a planning task, any value of any of its parameters.


def _tile(rng: Random, rows: int, columns: int) -> list[int]:
    """Sides of a tile or of a block: any, or nearly equal ones, or as wide as the map."""
    row = rng.randint(1, rng.choice([rows, min(rows, 40)]))
    column = rng.choice([rng.randint(1, columns), min(columns, max(1, row + rng.randint(-3, 3))), columns])
    return [row, column]


DECLARED = "memory", "display"
"""Parameters that state what is soldered beside a part. A designer has no choice of them."""


def parameters_of(planner: str, style: str, rows: int, columns: int, rng: Random) -> dict[str, Any]:
    """Parameters of a planning task, drawn; what the model refuses is refused when it is run."""
    of = catalog.planners()[planner]
    chosen: dict[str, Any] = {}
    for name, each in of.tasks[of.planning_task].model_fields.items():
        values: list[Any] = [True, False] if each.annotation is bool else list(get_args(each.annotation))
        if isclass(each.annotation) and issubclass(each.annotation, StrEnum):
            values = [str(value) for value in each.annotation]
        if name not in DECLARED and rng.random() < 0.5 and all(type(value) in (bool, int, str) for value in values):
            chosen |= {name: rng.choice(values)} if values else {}
    if planner == "wavefront":
        if style == "tiled":
            chosen["tile"] = _tile(rng, rows, columns)
        elif style != "software":
            chosen["element_cells"] = 2 ** rng.randint(0, 5)
        if rng.random() < 0.2:
            chosen["register_bits"] = rng.randint(4, 16)
    if planner == "relaxation":
        method = chosen.get("method", "am")
        if "sor" in method or "am" in method:
            chosen["omega"] = rng.uniform(1.0, 1.95)
        if "am" in method:
            chosen["r"] = rng.uniform(1.0, 2.0)
        if method != "direct" and rng.random() < 0.5:
            chosen["tolerance"] = 10 ** rng.uniform(-9, -1)
    if planner == "harmonic":
        chosen["block"] = _tile(rng, rows, columns)
        chosen["iterations"] = rng.choice([1, 1, 2, 3, 6, 12, 40])
        chosen["schedule"] = sorted(rng.sample(range(3, 60), rng.randint(1, 3)))
        chosen["pipeline"] = rng.randint(0, 1)
    return chosen


AT_DEFAULT = {
    "breadth_first": ("address", "queue_words", "external_cycles"),
    "harmonic": ("pipeline", "digit_bits", "promote", "termination", "stop", "pockets", "start"),
    "wavefront": ("paths", "course", "steps", "delays", "penalty"),
}
"""Parameters that the space of an answer holds at their defaults; see ``Architecture.beyond``."""


def inside(planner: str, chosen: dict[str, Any], rng: Random) -> dict[str, Any]:
    """A drawn design of a circuit, moved into the space of an answer."""
    kept = {key: value for key, value in chosen.items() if key not in AT_DEFAULT.get(planner, ())}
    if planner == "wavefront":
        kept["corner_cutting"] = False
    if planner == "harmonic":
        kept |= {"iterations": rng.choice(VISITS), "schedule": {"first": FIRST, "step": STEP, "last": rng.choice(LAST)}}
    return kept


def is_beyond(planner: str, style: str, chosen: Mapping[str, Any]) -> bool:
    """True if the statement of an answer is not about a design."""
    of = catalog.planners()[planner]
    architecture, model = catalog.architectures()[planner, style], of.tasks[of.planning_task]
    own = model.model_validate(dict(chosen))
    if isinstance(own, SearchParameters):
        return own.cuts
    if architecture.component_type != "fpga":
        # A program has few designs, and each is tried.
        proposed = chain.from_iterable(architecture.designs(Mock()))
        return own not in [model.model_validate(dict(each)) for each in proposed]
    plain = model.model_validate(inside(planner, dict(chosen), Random(0)))
    if isinstance(own, RelaxParameters):
        if own.iterations not in VISITS or own.precisions not in LADDERS:
            return True
        plain = plain.model_copy(update={"iterations": own.iterations, "schedule": own.schedule})
    return own != plain


LADDERS = [(*range(FIRST, last, STEP), last) for last in LAST]

SHARES = {"wavefront": 12, "breadth_first": 4, "grid_search": 4, "harmonic": 2, "relaxation": 1}
"""The shares of the planners among the designs: those that a second simulates many of have most."""


def drawn(board: advice.Board, question: Question, rng: Random) -> tuple[str, dict[str, dict[str, Any]], str] | None:
    """A planner, a mapping and the planning component, drawn; None where the component has no style."""
    name, spec = rng.choice([each for each in board.platform.components.items() if each[1].plans])
    styles = [(of, style) for (of, style), each in catalog.architectures().items() if each.component_type == spec.type]
    styles = [each for each in styles if catalog.planners()[each[0]].problem_model is None]
    planner, style = rng.choices(styles, [SHARES[of] for of, _ in styles])[0]
    of = catalog.planners()[planner]
    chosen = parameters_of(planner, style, question.problem.rows, question.problem.columns, rng)
    if isinstance(spec, FpgaComponent) and rng.random() < 0.5:
        chosen = inside(planner, chosen, rng)
    mapping: dict[str, dict[str, Any]] = {of.planning_task: {"component": name, "style": style, **chosen}}
    others = [task for task in of.tasks if task not in (of.planning_task, "load")]
    elsewhere = [other for other in board.platform.components if other != name]
    if others and elsewhere and rng.random() < 0.3:
        mapping[rng.choice(others)] = {"component": rng.choice(elsewhere)}
    memories = [memory for memory, each in board.platform.components.items() if each.type == "memory"]
    if memories and rng.random() < 0.2:
        mapping[of.planning_task]["external_memory"] = rng.choice(memories)
    on_fabric = isinstance(spec, FpgaComponent)
    placement = "split" if len(mapping) > 1 else "fabric" if on_fabric else "host"
    return (planner, mapping, name) if question.needs.on in (None, placement) else None


def suffices(
    board: advice.Board, question: Question, planner: str, mapping: Mapping[str, Any], component: str, memo: Memo
) -> bool:
    """Whether a design meets every need at the fastest clock that its circuit reaches."""
    workload = catalog.load_workload(workload_tree(planner, question.section, mapping))
    result = simulate(board.platform, workload, memo=memo, grid=question.grid)
    clock = result.clock
    if clock is not None and all(reason.kind == "clock" for reason in result.reasons):
        step = 1_000_000 if clock.limit.value >= 10_000_000 else 1_000
        fastest = {f"{component}.clock": f"{int(clock.limit.value) // step * step // 1000} kHz"}
        result = simulate(*design_point(board.platform, workload, fastest), memo=memo, grid=question.grid)
    trial = trial_of(as_asked(result, question.needs.share))
    return trial.time_s is not None and not shortfalls_of(trial, board, question.needs)


@dataclass
class Outcome:
    """What drawing came to. ``finds``: designs that suffice on a board of which the answer says that none does.

    ``beyond``: those that suffice and are outside of the space that the answer speaks of.
    """

    drawn: int = 0
    ran: int = 0
    finds: list[str] = field(default_factory=list)
    beyond: list[str] = field(default_factory=list)


def hunt(
    answer: advice.Advice,
    question: Question,
    boards: Sequence[advice.Board],
    *,
    count: int,
    seed: int = 0,
    most_s: float = MOST_S,
) -> Outcome:
    """Draw ``count`` designs of the boards that an answer says do not suffice, the cheaper ones or all."""
    price = next((each.price_usd for each in answer.boards if each.board == answer.recommended), None)
    cheaper = [
        board
        for board in boards
        if answer.recommended is None or (board.price_usd is not None and price is not None and board.price_usd < price)
    ]
    rng, memo, outcome, end = Random(seed), Memo(), Outcome(), time.process_time() + most_s
    while cheaper and outcome.drawn < count and time.process_time() < end:
        board = rng.choice(cheaper)
        outcome.drawn += 1
        design = drawn(board, question, rng)
        if design is None:
            continue
        try:
            found = suffices(board, question, *design, memo)
        except CodesignError:
            continue
        outcome.ran += 1
        if found:
            planner, mapping, _ = design
            planning = mapping[catalog.planners()[planner].planning_task]
            chosen = {key: value for key, value in planning.items() if key not in PLACE_KEYS}
            finds = outcome.beyond if is_beyond(planner, planning["style"], chosen) else outcome.finds
            finds.append(f"{board.name} ({board.price_usd} USD): {planner} {mapping}")
    return outcome


def run() -> Iterator[dict[str, Any]]:
    """The rows of the benchmark."""
    with tempfile.TemporaryDirectory() as folder:
        for asked in questions():
            begun = time.process_time()
            question, boards = asked.question(Path(folder)), advice.boards_of(asked.boards)
            answer = advice.advise(question, boards)
            spent, tried = time.process_time() - begun, answer.simulated + answer.kept
            outcome = hunt(answer, question, boards, count=max(LEAST_DRAWN, TIMES * tried))
            proved = answer.proof.state != "not proved"
            for find in outcome.beyond:
                print("beyond the space:", asked, answer.recommended, find, flush=True)
            for find in outcome.finds:
                print("CONTRADICTION" if proved else "find", asked, answer.recommended, find, flush=True)
            yield {
                "question": str(asked),
                "answer": answer.recommended or "none",
                "state": answer.proof.state,
                "boards": answer.proof.boards,
                "tried": tried,
                "drawn": outcome.drawn,
                "ran": outcome.ran,
                "contradictions": len(outcome.finds) if proved else 0,
                "finds, not proved": 0 if proved else len(outcome.finds),
                "finds beyond the space": len(outcome.beyond),
                "s asked": f"{spent:.1f}",
            }
