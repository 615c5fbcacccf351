"""Small drives for tests: a platform and a workload from texts, changed key by key."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

import codesign
from codesign.ground.records import Record
from codesign.inputs import Platform, Workload
from codesign.planners.grid_search.styles import KERNELS as GRID_KERNELS
from codesign.system import Result
from codesign.system.build import Machine, build
from codesign.system.scenarios import bind, simulate
from codesign.views.trace import MemoryListener

SECOND = 10**12
"""Picoseconds."""

COSTS = {
    "breadth_first_cell": "100 ns",
    "wavefront_cell": "100 ns",
    "harmonic_node_update": "42 ns",
    "harmonic_decision": "1 us",
    "sparse_solve_cell": "2 us",
    "relaxation_node_update": "10 ns",
    "relaxation_direct_cell": "2 us",
    "log_line": "3 us",
    "render_robot": "0 s",
    # What the costs above hold already.
    **dict.fromkeys(
        (
            "occupancy_cell",
            "way_following",
            "breadth_first_map_cell",
            "breadth_first_wall_cell",
            "wavefront_map_cell",
            "wavefront_time_step",
            "relaxation_map_cell",
            "relaxation_diagonal",
        ),
        "0 s",
    ),
    "relaxation_check_cell": "10 ns",
    **dict.fromkeys((kernel for kernels in GRID_KERNELS.values() for kernel in kernels), "20 ns"),
}

PLATFORM: dict[str, Any] = {
    "kind": "platform",
    "name": "board",
    "components": {
        "fpga": {"type": "fpga", "part": "XC4VLX160-12", "clock": "100 MHz"},
        "host": {"type": "processor", "clock": "1 GHz", "costs": COSTS, "power": {"busy": "3 W", "idle": "1 W"}},
        "robot": {
            "type": "robot",
            "kinematics": {"type": "omnidirectional", "speed": "0.5 m/s", "acceleration": "0.5 m/s^2"},
            "sensor": {"type": "rays", "range": "0.8 m", "rays": 64},
            "power": {"moving": "20 W", "standing": "5 W"},
        },
    },
    "links": {
        "pci": {
            "type": "bus",
            "between": ["host", "fpga"],
            "width": 32,
            "clock": "33 MHz",
            "setup_cycles": 8,
            "burst_words": 16,
            "power": {"busy": "2 W", "idle": "0.5 W"},
        },
        "uart": {
            "type": "serial",
            "between": ["host", "robot"],
            "baud": 115200,
            "fifo_depth": 16,
            "power": {"busy": "0.2 W", "idle": "0.1 W"},
        },
    },
}

IDEAL: dict[str, Any] = {
    "links": {
        "pci": {"=": {"type": "ideal", "between": ["host", "fpga"]}},
        "uart": {"=": {"type": "ideal", "between": ["host", "robot"]}},
    }
}
"""Changes of the platform: links that take no time."""

POINT = {"components": {"robot": {"kinematics": {"=": {"type": "point", "speed": "0.5 m/s"}}}}}
"""Changes of the platform: a robot that starts, stops and turns at once."""

KINEMATICS: dict[str, dict[str, Any]] = {
    "point": POINT,
    "omnidirectional": {},
    "differential": {
        "components": {
            "robot": {
                "kinematics": {
                    "=": {
                        "type": "differential",
                        "speed": "0.5 m/s",
                        "acceleration": "0.5 m/s^2",
                        "turn_rate": "2 rad/s",
                    }
                }
            }
        }
    },
}

RELAX = {
    "component": "fpga",
    "style": "bit_serial",
    "block": [16, 16],
    "iterations": 4,
    "schedule": {"first": 15, "step": 16, "last": 63},
}
SOFTWARE = {
    "component": "host",
    "style": "software",
    "block": [16, 16],
    "iterations": 4,
    "schedule": {"first": 15, "step": 16, "last": 63},
}

PLACEMENTS: dict[str, tuple[str, dict[str, Any]]] = {
    "harmonic": ("harmonic", {"relax": RELAX, "decide": {"component": "fpga"}}),
    "harmonic-decide-on-host": ("harmonic", {"relax": RELAX, "decide": {"component": "host"}}),
    "harmonic-detect-on-host": (
        "harmonic",
        {"relax": RELAX, "detect": {"component": "host"}, "decide": {"component": "fpga"}},
    ),
    "harmonic-warm": (
        "harmonic",
        {"relax": RELAX, "decide": {"component": "fpga"}, "lower_bound": {"component": "host"}},
    ),
    "harmonic-host": ("harmonic", {"relax": SOFTWARE, "decide": {"component": "host"}}),
    "harmonic-host-decide-on-fpga": ("harmonic", {"relax": SOFTWARE, "decide": {"component": "fpga"}}),
    "breadth-first": (
        "breadth_first",
        {"search": {"component": "fpga", "style": "state_machine"}, "track": {"component": "fpga"}},
    ),
    "breadth-first-track-on-host": (
        "breadth_first",
        {"search": {"component": "fpga", "style": "state_machine"}, "track": {"component": "host"}},
    ),
    "breadth-first-host": (
        "breadth_first",
        {"search": {"component": "host", "style": "software"}, "track": {"component": "host"}},
    ),
    "grid-search": ("grid_search", {"search": {"component": "host"}}),
    "grid-search-theta": ("grid_search", {"search": {"component": "host", "method": "theta_star"}}),
    "grid-search-navfn": ("grid_search", {"search": {"component": "host", "method": "navfn"}}),
    "wavefront": (
        "wavefront",
        {
            "propagate": {"component": "fpga", "style": "delay_line", "corner_cutting": False},
            "track": {"component": "fpga"},
        },
    ),
    "wavefront-tiled-track-on-host": (
        "wavefront",
        {
            "propagate": {
                "component": "fpga",
                "style": "tiled",
                "tile": [16, 16],
                "stop": "starts",
                "corner_cutting": False,
            },
            "track": {"component": "host"},
        },
    ),
    "wavefront-host": (
        "wavefront",
        {
            "propagate": {"component": "host", "style": "software", "corner_cutting": False},
            "track": {"component": "host"},
        },
    ),
    "relaxation": ("relaxation", {"relax": {"component": "host", "style": "sequential", "method": "direct"}}),
    "relaxation-sor": (
        "relaxation",
        {"relax": {"component": "host", "style": "sequential", "method": "sor", "omega": 1.8}},
    ),
}
"""Planner and mapping by a name of their own."""

ROOMS = """\
................
................
.......#........
.......#........
####.###...##...
...........#....
...........#....
...........#....
.....#.....#....
.....#######....
.....#..........
.....#..........
.....#.....#####
...........#....
................
................
"""
"""16 × 16 cells, with a way from (1, 1) to (14, 13)."""

Changes = Mapping[str, Any]


def merged(base: Any, changes: Any) -> Any:
    """``base`` with keys changed; a mapping under "=" takes the place of the old one, None takes a key away."""
    if not isinstance(changes, Mapping) or not isinstance(base, Mapping):
        return copy.deepcopy(changes)
    if "=" in changes:
        return copy.deepcopy(changes["="])
    made = dict(copy.deepcopy(base))
    for key, value in changes.items():
        if value is None:
            made.pop(key, None)
        else:
            made[key] = merged(made.get(key, {}), value)
    return made


class _Plain(yaml.SafeDumper):
    """Writes what occurs twice out twice: aliases are not read."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _text(data: Any) -> str:
    return yaml.dump(data, Dumper=_Plain, sort_keys=False)


def platform_text(*changes: Changes) -> str:
    """The YAML text of the platform, with ``changes`` one after another."""
    made: Any = PLATFORM
    for change in changes:
        made = merged(made, change)
    return _text(made)


class Ground:
    """Writes platforms, maps and workloads into a folder, and runs them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def files(
        self,
        placement: str = "breadth-first",
        *,
        platform: Sequence[Changes] | Changes = (),
        text: str = ROOMS,
        goals: Sequence[Sequence[int]] = ((14, 13),),
        start: Sequence[int] = (1, 1),
        mapping: Changes | None = None,
        workload: Changes | None = None,
        **scenario: Any,
    ) -> tuple[Path, Path]:
        """The two files; further keywords are keys of the scenario."""
        planner, tasks = PLACEMENTS[placement]
        board, plan, drawn = (self.folder / name for name in ("board.yaml", "drive.yaml", "drawn.txt"))
        changes = [platform] if isinstance(platform, Mapping) else platform
        board.write_text(platform_text(*changes), encoding="utf-8")
        drawn.write_text(text, encoding="utf-8")
        made = {
            "kind": "workload",
            "name": placement,
            "planner": planner,
            "problem": {"map": {"file": drawn.name}, "goals": [list(goal) for goal in goals], "starts": [list(start)]},
            "scenario": {"type": "drive", "resolution": "0.1 m", "limit": "3 min"} | scenario,
            "mapping": merged(tasks, mapping or {}),
        }
        plan.write_text(_text(merged(made, workload or {})), encoding="utf-8")
        return board, plan

    def point(self, placement: str = "breadth-first", **settings: Any) -> tuple[Platform, Workload]:
        """Platform and workload, loaded."""
        board, plan = self.files(placement, **settings)
        return codesign.load_platform(board), codesign.load_workload(plan)

    def run(self, placement: str = "breadth-first", *, granularity: str = "run_ahead", **settings: Any) -> Result:
        """The result of a drive that fits."""
        result = simulate(*self.point(placement, **settings), granularity=granularity)
        assert result.feasible, result.reasons
        return result

    def watched(
        self, placement: str = "breadth-first", *, granularity: str = "run_ahead", **settings: Any
    ) -> tuple[Result, list[Record]]:
        """The result of a drive, and its records."""
        listener = MemoryListener()
        point = self.point(placement, **settings)
        result = simulate(*point, granularity=granularity, listeners=(listener,))
        assert result.feasible, result.reasons
        return result, listener.records

    def machine(self, placement: str = "breadth-first", listeners: Sequence[Any] = (), **settings: Any) -> Machine:
        """The machine of a drive, at time 0."""
        from codesign.components import Granularity

        return build(bind(*self.point(placement, **settings)), tuple(listeners), Granularity.RUN_AHEAD)


def rectangle(row: int, column: int, rows: int = 1, columns: int = 1, **more: Any) -> dict[str, Any]:
    """A rectangle as YAML has it."""
    return {"row": row, "column": column, "rows": rows, "columns": columns, **more}


OPEN = "\n".join(["." * 16] * 16) + "\n"
ENDS = {"goals": [(10, 10)], "start": (1, 1)}
