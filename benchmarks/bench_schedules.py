"""The schedules of precision on maps of several kinds: all bits at once, the paper's series, the best schedule, early
promotion, and a start from the host.

All plans of a map end with the same bits, at the least precision of the form 8k - 1 that leaves no local maximum.
Cycles are those of phase ``relax`` of ``bit_serial``. The time is that of a plan on the platform with its host: from
the request to the answer, the map sent, and the start solved, sent and written where there is one.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

import yaml

import codesign
from codesign import maps
from codesign.ground.memo import Memo
from codesign.planners.harmonic.plan.precision import required_precision
from codesign.system.results.result import Result
from codesign.system.scenarios import simulate

PLATFORM = "virtex4-pci"
ITERATIONS = 6
FIRST, STEP = 7, 8
SWEEPS = (2, 4, 8, 16, 32, 64)
"""The promotions that are tried: sweeps of a stage but the last."""

MOST_BITS = 255
"""Four blocks have words of this many bits in the block RAMs of the platform."""

MAPS: tuple[tuple[str, Mapping[str, Any]], ...] = (
    ("maze", {"rows": 48, "columns": 48, "corridor": 4, "wall": 1, "seed": 1}),
    ("maze", {"rows": 48, "columns": 48, "corridor": 8, "wall": 1, "seed": 2, "loops": 0.2}),
    ("maze", {"rows": 72, "columns": 96, "corridor": 8, "wall": 2, "seed": 3, "loops": 0.1}),
    ("maze", {"rows": 72, "columns": 96, "corridor": 14, "wall": 2, "seed": 4}),
    ("rooms", {"rows": 48, "columns": 48, "room": (10, 10), "door": 2, "wall": 1, "seed": 5}),
    ("rooms", {"rows": 72, "columns": 96, "room": (14, 14), "door": 3, "wall": 1, "seed": 6}),
    ("rooms", {"rows": 72, "columns": 96, "room": (22, 30), "door": 6, "wall": 2, "seed": 7}),
    ("random", {"rows": 48, "columns": 48, "density": 0.1, "seed": 8}),
    ("random", {"rows": 72, "columns": 96, "density": 0.2, "size": 3, "seed": 9}),
    ("random", {"rows": 72, "columns": 96, "density": 0.3, "size": 6, "seed": 10}),
    ("spiral", {"rows": 48, "columns": 48, "corridor": 8}),
    ("corridor", {"length": 96, "width": 8}),
    ("empty", {"rows": 48, "columns": 48}),
    ("empty", {"rows": 72, "columns": 96}),
)


GROWTH = (0, 1, 4, 7, 10, 12)
"""Maps by number in ``MAPS``: each is planned on at more bits than it needs."""

TIMES_NEEDED = (1, 2, 4, 8)
MOST_BITS_OF_ONE_BLOCK = 1023


@dataclass(frozen=True)
class Case:
    """A map with its goal in a corner, the bits that it needs, and the runs of it by name."""

    name: str
    options: Mapping[str, Any]
    goal: tuple[int, int]
    last: int

    def run(self, name: str, memo: Memo, **relax: Any) -> Result:
        """One plan; ``relax``: what differs from all bits at once."""
        height, width = self.shape
        mapping: dict[str, Any] = {
            "relax": {
                "component": "fpga",
                "block": [-(-height // 2), -(-width // 2)],
                "iterations": ITERATIONS,
                "schedule": [self.last],
                "stop": "schedule_end",
                "pockets": "filled",
                **relax,
            }
        }
        if name == "warm":
            mapping["lower_bound"] = {"component": "host"}
        text = {
            "kind": "workload",
            "name": self.name,
            "planner": "harmonic",
            "problem": {
                "map": {"generate": self.name, **{key: _plain(value) for key, value in self.options.items()}},
                "goals": [list(self.goal)],
                "starts": {"count": 1},
            },
            "mapping": mapping,
        }
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "schedules.yaml"
            file.write_text(yaml.safe_dump(text), encoding="utf-8")
            workload = codesign.load_workload(file)
            result = simulate(codesign.load_platform(PLATFORM), workload, memo=memo)
        assert result.feasible, (self, name, result.reasons)
        assert result.precision == self.last
        return result

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        if "length" in self.options:
            return self.options["width"], self.options["length"]
        return self.options["rows"], self.options["columns"]

    @property
    def series(self) -> dict[str, int]:
        """The paper's series."""
        return {"first": FIRST, "step": STEP, "last": self.last}


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def case_of(name: str, options: Mapping[str, Any]) -> Case:
    """The map with the free cell next to the upper left corner as goal."""
    free = maps.generate(name, **options).free
    goal = maps.nearest_free(free, (2, 2))
    assert goal is not None
    needed = required_precision(free, [goal], limit=MOST_BITS).least
    assert needed is not None, f"{name} {options} needs more than {MOST_BITS} bits"
    return Case(name, options, goal, -(-(needed + 1) // STEP) * STEP - 1)


def seconds(result: Result) -> float:
    """Worst time of a plan, s."""
    assert result.task is not None
    return result.task.plan_time_worst_s


def cycles(result: Result) -> int:
    """Cycles of the relaxation."""
    assert result.cycles is not None
    return result.cycles["relax"]


@dataclass(frozen=True)
class Outcome:
    """The runs of a case by name; the sweeps of the best promotion."""

    case: Case
    runs: Mapping[str, Result]
    sweeps: int

    def gain(self, name: str) -> float:
        """Cycles of all bits at once over those of another schedule."""
        return cycles(self.runs["direct"]) / cycles(self.runs[name])


def outcome_of(case: Case) -> Outcome:
    """All runs of a case. Of the promotions, the one of fewest cycles."""
    memo = Memo()
    promoted = {after: case.run("promoted", memo, schedule=case.series, promote={"after": after}) for after in SWEEPS}
    sweeps = min(promoted, key=lambda after: cycles(promoted[after]))
    runs = {
        "direct": case.run("direct", memo),
        "series": case.run("series", memo, schedule=case.series),
        "optimal": case.run("optimal", memo, schedule={"optimal": {"last": case.last}}),
        "promoted": promoted[sweeps],
        "warm": case.run("warm", memo),
    }
    return Outcome(case, runs, sweeps)


def rows_of(outcome: Outcome) -> dict[str, Any]:
    """The row of one map."""
    case, runs = outcome.case, outcome.runs
    found = runs["optimal"].found["relax.schedule"]
    height, width = case.shape
    detail = next((f"{key} {case.options[key]}" for key in ("corridor", "room", "density") if key in case.options), "")
    milliseconds = [f"{1000 * seconds(run):.2f}" for run in runs.values()]
    return {
        "map": f"{case.name} {height}×{width}{', ' if detail else ''}{detail}",
        "p": case.last,
        "direct, cycles": f"{cycles(runs['direct']):,}",
        "series": f"÷ {outcome.gain('series'):.2f}",
        "optimal": f"÷ {outcome.gain('optimal'):.2f}",
        "optimal stages": ", ".join(map(str, found["precisions"])),  # type: ignore[arg-type]
        "promoted after": f"{outcome.sweeps}: ÷ {outcome.gain('promoted'):.2f}",
        "warm": f"÷ {outcome.gain('warm'):.1f}",
        "ms: direct, series, optimal, promoted, warm": ", ".join(milliseconds),
        "stages run, cut, not begun": f"{found['simulated']}, {found['cut_off']}, {found['bounded_away']}",
    }


def summary(outcomes: list[Outcome]) -> dict[str, Any]:
    """The median of all maps, in the row below them."""
    gains = {name: [each.gain(name) for each in outcomes] for name in outcomes[0].runs}
    return {
        "map": f"median of {len(outcomes)} maps",
        "p": int(median(each.case.last for each in outcomes)),
        "direct, cycles": "",
        "series": f"÷ {median(gains['series']):.2f}",
        "optimal": f"÷ {median(gains['optimal']):.2f}",
        "optimal stages": "",
        "promoted after": f"÷ {median(gains['promoted']):.2f}",
        "warm": f"÷ {median(gains['warm']):.1f}",
        "ms: direct, series, optimal, promoted, warm": "",
        "stages run, cut, not begun": "",
    }


def outcomes() -> Iterator[Outcome]:
    """Every map of the study."""
    for name, options in MAPS:
        yield outcome_of(case_of(name, options))


def run() -> list[dict[str, Any]]:
    """One row for each map, and their median."""
    done = []
    for outcome in outcomes():
        done.append(outcome)
        best = cycles(outcome.runs["optimal"])
        assert all(best <= cycles(outcome.runs[name]) for name in ("direct", "series"))
    return [*map(rows_of, done), summary(done)]


def growth() -> list[dict[str, Any]]:
    """One row for each map of ``GROWTH`` as one block: what series and best schedule gain at more and more bits."""
    rows = []
    for number in GROWTH:
        case = case_of(*MAPS[number])
        row: dict[str, Any] = {"map": f"{case.name} {case.shape[0]}×{case.shape[1]}", "bits needed": case.last}
        for times in TIMES_NEEDED:
            bits = times * (case.last + 1) - 1
            row[f"{times} times"] = "" if bits > MOST_BITS_OF_ONE_BLOCK else _gains(replace(case, last=bits))
        rows.append(row)
    return rows


def _gains(case: Case) -> str:
    memo, one = Memo(), {"block": list(case.shape)}
    # At most 31 candidates.
    step = STEP * -(-(case.last + 1) // (32 * STEP))
    best = {"optimal": {"last": case.last, "candidates": {"first": step - 1, "step": step}}}
    direct = cycles(case.run("direct", memo, **one))
    series = cycles(case.run("series", memo, **one, schedule=case.series))
    return f"÷ {direct / series:.2f}, ÷ {direct / cycles(case.run('optimal', memo, **one, schedule=best)):.2f}"


def main() -> None:
    """Both tables in Markdown."""
    for make in (run, growth):
        table = make()
        sys.stdout.write("| " + " | ".join(table[0]) + " |\n" + "|---" * len(table[0]) + "|\n")
        for row in table:
            sys.stdout.write("| " + " | ".join(map(str, row.values())) + " |\n")
        sys.stdout.write("\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
