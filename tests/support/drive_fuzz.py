"""Drives for fuzz tests: a sound platform and workload with some values made extreme, and bounds on a run."""

from __future__ import annotations

import copy
import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml
from hypothesis import strategies as st
from mission_specs import KINEMATICS, PLACEMENTS, Ground, rectangle

from codesign.inputs.document import KeyPath

Change = tuple[str, KeyPath, Any]
"""The file (``board`` or ``drive``), the path of a key in it, and the value that is put there."""

WILD: tuple[Any, ...] = (
    None,
    True,
    0,
    -1,
    2**63,
    10**30,
    1e300,
    "",
    "NaN m",
    "nan",
    "-1 m",
    "inf s",
    "1e999 s",
    [],
    {},
    [[]],
    [None],
    {"value": "1 m"},
)
"""Values that few keys accept."""

TIMES = ("0 s", "1 ps", "1 us", "1 ms", "100 ms", "1 s", "1 min", "1000 h", "3.6e18 ps")
LENGTHS = ("0 m", "1e-300 m", "1e-12 m", "1 um", "1 mm", "5 cm", "0.1 m", "0.3 m", "1 m", "40 m", "1 km", "1e9 m")
SPEEDS = ("1e-300 m/s", "1e-12 m/s", "1 mm/s", "0.5 m/s", "1e6 m/s")
ACCELERATIONS = ("1e-300 m/s^2", "1e-9 m/s^2", "0.5 m/s^2", "1e6 m/s^2")
TURN_RATES = ("1e-300 rad/s", "1e-9 rad/s", "2 rad/s", "1e6 rad/s")
FREQUENCIES = ("1 Hz", "7 Hz", "999999937 Hz", "1 MHz", "100 MHz", "1 THz")
COSTS = ("0 s", "1 ps", "100 ns", "1 s", "1000 h")
CELLS = ([0, 0], [1, 1], [14, 13], [15, 15], [2, 7], [16, 0], [2**31, 2**31], [2**64, 0])
COUNTS = (1, 2, 15, 16, 17, 4096)
EXTENTS = (1, 640, 800, 65_536, 65_537, 131_072, 131_073, 10**6, 10**15)

ROBOT = ("components", "robot")
SCENE = ("scenario",)

RECTANGLES = tuple(
    rectangle(row, column, rows, columns)
    for row, column in ((0, 0), (1, 1), (8, 8), (15, 15), (2**40, 0))
    for rows, columns in ((1, 1), (3, 3), (16, 16), (4096, 4096))
)
APPEARING = tuple(
    one | {"at": at} | ({} if until is None else {"until": until})
    for one in RECTANGLES
    for at, until in (("0 s", None), ("1 s", "2 s"), ("1000 h", None), ("1 ps", "2 ps"))
)
MOVING = tuple(
    {"size": [side, side], "route": route, "speed": speed, "begin": begin}
    for side in (1, 4)
    for route in ([[0, 0], [0, 12]], [[5, 5], [5, 5]], [[0, 0], [2**40, 0]], [[1, 1], [9, 9], [1, 1]])
    for speed in SPEEDS
    for begin in ("0 s", "1000 h")
)
RANDOM = tuple(
    {"count": count, "size": size, "end": end, "seed": seed} | more
    for count in (1, 100, 10_000)
    for size in (1, 3, 17)
    for end in ("0 s", "10 s", "1000 h")
    for seed in (0, 2**63 - 1)
    for more in ({}, {"stay": "1 ps"}, {"stay": "1000 h"})
)
MAPS = (
    {"generate": "empty", "rows": 1, "columns": 1},
    {"generate": "empty", "rows": 1, "columns": 40},
    {"generate": "empty", "rows": 30, "columns": 30},
    {"generate": "maze", "rows": 31, "columns": 31, "seed": 3},
    {"generate": "random", "rows": 20, "columns": 20, "density": 0.9, "seed": 1},
    {"generate": "rooms", "rows": 24, "columns": 24, "room": 5, "seed": 2},
    {"generate": "empty", "rows": 300, "columns": 300},
)
DISPLAY = {
    "type": "display",
    "beside": "fpga",
    "pixel_clock": "25 MHz",
    "columns": 640,
    "rows": 480,
    "total_columns": 800,
    "total_rows": 525,
    "pixels_a_word": 1,
}
MEMORY = {
    "type": "memory",
    "technology": "sram",
    "beside": "fpga",
    "capacity": "1 MiB",
    "width": 32,
    "clock": "100 MHz",
    "latency_cycles": 2,
}
SERIAL = ("links", "uart")
BUS = ("links", "pci")

KEYS: dict[tuple[str, KeyPath], tuple[Any, ...]] = {
    ("board", (*ROBOT, "radius")): LENGTHS,
    ("board", (*ROBOT, "kinematics")): tuple(
        changes["components"]["robot"]["kinematics"]["="] for changes in KINEMATICS.values() if changes
    ),
    ("board", (*ROBOT, "kinematics", "speed")): SPEEDS,
    ("board", (*ROBOT, "kinematics", "acceleration")): ACCELERATIONS,
    ("board", (*ROBOT, "kinematics", "turn_rate")): TURN_RATES,
    ("board", (*ROBOT, "sensor")): tuple({"type": "radius", "range": length} for length in LENGTHS)
    + tuple({"type": "rays", "range": length, "rays": rays} for length in LENGTHS for rays in (1, 4096)),
    ("board", ("components", "fpga", "clock")): FREQUENCIES,
    ("board", ("components", "fpga", "part")): ("XC3S500E-4", "XC2V6000-6", "XC7A35T-1", "XC9-9"),
    ("board", ("components", "host", "clock")): FREQUENCIES,
    ("board", ("components", "host", "cores")): (1, 1024, 1025),
    ("board", ("components", "screen")): tuple(
        DISPLAY | {key: value, f"total_{key}": value} for key in ("columns", "rows") for value in EXTENTS
    )
    + tuple(DISPLAY | {"pixel_clock": clock} for clock in FREQUENCIES)
    + tuple(DISPLAY | {"total_columns": value} for value in EXTENTS)
    + tuple(DISPLAY | {"pixels_a_word": value} for value in EXTENTS)
    + ({"type": "display"}, DISPLAY | {"beside": "host"}),
    ("board", ("components", "ram")): tuple(
        MEMORY | more
        for more in (
            {},
            {"width": 1},
            {"width": 10**15},
            {"clock": "1 Hz"},
            {"latency_cycles": 10**15},
            {"technology": "dram", "row_words": 1, "row_cycles": 10**15, "refresh_share": 0.999},
        )
    ),
    ("board", (*SERIAL, "baud")): (1, 300, 115_200, 10**12, 10**15),
    ("board", (*SERIAL, "data_bits")): (5, 8, 9),
    ("board", (*SERIAL, "fifo_depth")): (1, 16, 10**15),
    ("board", (*BUS, "width")): (1, 32, 1024, 10**15),
    ("board", (*BUS, "setup_cycles")): (0, 8, 10**15),
    ("board", (*BUS, "burst_words")): (1, 16, 10**15),
    ("board", (*BUS, "clock")): FREQUENCIES,
    **{
        ("board", ("components", "host", "costs", kernel)): COSTS
        for kernel in ("breadth_first_cell", "harmonic_node_update", "relaxation_node_update")
    },
    ("drive", ("problem", "map")): MAPS,
    ("drive", ("problem", "goals")): (*tuple([cell] for cell in CELLS), [[0, 0], [1, 1]], [[0, 0], [0, 0]]),
    ("drive", ("problem", "starts")): (
        *tuple([cell] for cell in CELLS),
        [[0, 0], [1, 1]],
        {"count": 1},
        {"count": 100000, "seed": 2**63 - 1},
    ),
    ("drive", (*SCENE, "purpose")): ("reach", "explore"),
    ("drive", (*SCENE, "known")): ("all", "none"),
    ("drive", (*SCENE, "robot")): ("robot", "fpga", "nobody"),
    ("drive", (*SCENE, "resolution")): LENGTHS,
    ("drive", (*SCENE, "control_period")): TIMES,
    ("drive", (*SCENE, "deadline")): TIMES,
    ("drive", (*SCENE, "limit")): TIMES,
    ("drive", (*SCENE, "patience")): TIMES,
    ("drive", (*SCENE, "tour")): (*tuple([cell] for cell in CELLS), [[1, 1]] * 3, [[14, 13], [1, 1]]),
    ("drive", (*SCENE, "hidden")): tuple([one] for one in RECTANGLES),
    ("drive", (*SCENE, "obstacles", "appearing")): tuple([one] for one in APPEARING),
    ("drive", (*SCENE, "obstacles", "moving")): tuple([one] for one in MOVING),
    ("drive", (*SCENE, "obstacles", "random")): RANDOM,
    ("drive", (*SCENE, "replan", "policy")): ("restart", "lower_bound", "continue"),
    ("drive", (*SCENE, "replan", "trigger")): ("blocked", "change"),
    ("drive", (*SCENE, "replan", "when_busy")): ("finish", "restart"),
    ("drive", ("tasks",)): (
        [{"name": "log", "after": {"command": 128}, "kernel": "log_line"}],
        [{"name": "log", "after": {"display": 128}, "kernel": "log_line"}],
        [{"name": "log", "after": {"command": 10**12}, "kernel": "log_line", "units": 10**12}],
    ),
    ("drive", ("mapping", "display")): tuple({"component": name} for name in ("host", "screen", "fpga", "robot")),
    ("drive", ("scenario",)): ({"type": "plan_once"}, {"type": "fleet"}),
    ("drive", ("mapping", "relax", "block")): ([1, 1], [16, 16], [17, 1], [4096, 4096]),
    ("drive", ("mapping", "relax", "blocks")): ([1, 1], [2, 3], [16, 16], [17, 1]),
    ("drive", ("mapping", "relax", "schedule")): ([1], [1023], [15, 31], {"first": 1, "step": 1, "last": 1023}),
    ("drive", ("mapping", "relax", "iterations")): (1, 1_000_000),
    ("drive", ("mapping", "relax", "termination")): ("sound", "published"),
    ("drive", ("mapping", "relax", "method")): ("gs", "mam", "red_black", "half_sweep_am", "direct"),
    ("drive", ("mapping", "relax", "omega")): (0, 1e-300, 1, 1.999999, 2),
    ("drive", ("mapping", "relax", "tolerance")): (1e-300, 1e-9, 1),
    ("drive", ("mapping", "relax", "max_iterations")): (1, 10**6),
    ("drive", ("mapping", "relax", "style")): ("software_limbs", "two_core", "bit_serial"),
    ("drive", ("mapping", "search", "display")): ("none", "shared", "copy"),
    ("drive", ("mapping", "propagate", "tile")): ([1, 1], [16, 16], [17, 17]),
    ("drive", ("mapping", "propagate", "course")): ("local", "complete"),
    ("drive", ("mapping", "propagate", "steps")): (1, 65_535),
    ("drive", ("mapping", "propagate", "corner_cutting")): (True, False),
    ("drive", ("mapping", "propagate", "penalty")): ({"distance": 65_535, "delay": 1}, {"distance": 1, "delay": 10**6}),
    ("drive", ("mapping", "propagate", "style")): ("adder_comparator", "delay_line", "tiled"),
    **{
        ("drive", ("mapping", task, key)): names
        for task in ("relax", "search", "propagate")
        for key, names in (("external_memory", ("ram", "fpga")), ("component", ("host", "fpga", "robot")))
    },
}
"""The keys that a fuzz test changes, with values that are usual or just in or out of bounds."""


@st.composite
def changes(draw: st.DrawFn, most: int = 4) -> list[Change]:
    """Some changes of the files; one in sixteen values is wild."""
    made: list[Change] = []
    for file, path in draw(st.lists(st.sampled_from(list(KEYS)), max_size=most, unique=True)):
        wild = draw(st.integers(0, 15)) == 15
        made.append((file, path, draw(st.sampled_from(WILD if wild else KEYS[file, path]))))
    return made


placements = st.sampled_from(sorted(PLACEMENTS))


def files(folder: Path, placement: str, made: list[Change], **scenario: Any) -> tuple[Path, Path]:
    """A platform and a workload with the changes put in; a change whose place is not there is left out."""
    board, drive = Ground(folder).files(placement, **scenario)
    for kind, path in (("board", board), ("drive", drive)):
        tree = yaml.safe_load(path.read_text(encoding="utf-8"))
        for file, keys, value in made:
            if file == kind:
                _put(tree, keys, value)
        path.write_text(_text(tree), encoding="utf-8")
    return board, drive


def _put(tree: Any, keys: KeyPath, value: Any) -> None:
    for key in keys[:-1]:
        # A task that this planner does not have is not made up.
        if not isinstance(tree, dict) or (keys[0] == "mapping" and key not in tree):
            return
        tree = tree.setdefault(key, {})
    if isinstance(tree, dict):
        tree[keys[-1]] = copy.deepcopy(value)


def _text(tree: Any) -> str:
    class Plain(yaml.SafeDumper):
        def ignore_aliases(self, data: Any) -> bool:
            return True

    return yaml.dump(tree, Dumper=Plain, sort_keys=False)


@contextmanager
def bounded(seconds: int = 60, gibibytes: int = 3) -> Iterator[None]:
    """Hang and memory end here: no run takes longer than ``seconds``, nor ``gibibytes`` more than there is room for."""

    def give_up(*_: object) -> None:
        raise TimeoutError("the run hangs")

    with open("/proc/self/statm", encoding="ascii") as statm:
        held = int(statm.read().split()[0]) * resource.getpagesize()
    limits = resource.getrlimit(resource.RLIMIT_AS)
    before = signal.signal(signal.SIGALRM, give_up)
    resource.setrlimit(resource.RLIMIT_AS, (held + gibibytes * 2**30, limits[1]))
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
        resource.setrlimit(resource.RLIMIT_AS, limits)
