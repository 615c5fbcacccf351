"""The files that are made of a bag: a workload, the map of map_server, and a table of the goals."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from codesign.ground.errors import printable
from codesign.views.bags.drawing import FREE_TO, OCCUPIED_FROM, BagFacts, Given, Measured

_GREY = {0: 254, 100: 0, -1: 205}
"""Pixels of map_saver."""

LONGEST_MISSION_S = 600.0


def file_name(stem: str) -> str:
    """A name for files and the workload, of the name of a bag.

    >>> file_name("2026-11-22 run"), file_name("é")
    ('bag-2026-11-22-run', 'bag')
    """
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", stem).strip("-")[:48]
    return name if name[:1].isalpha() else f"bag-{name}".rstrip("-")


def map_files(facts: BagFacts, name: str) -> dict[str, bytes]:
    """The map as map_saver of Nav2 writes it, but with a ``free_thresh`` that leaves unknown cells unknown."""
    cells = facts.map.cells
    pixels = np.full(cells.shape, _GREY[-1], np.uint8)
    for value, grey in _GREY.items():
        pixels[cells == value] = grey
    rows, columns = cells.shape
    x, y, yaw = facts.map.frame.origin
    text = (
        f"image: {name}-map.pgm\nmode: trinary\nresolution: {facts.map.frame.resolution!r}\n"
        f"origin: [{x!r}, {y!r}, {yaw!r}]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    head = f"P5\n{columns} {rows}\n255\n".encode()
    return {f"{name}-map.pgm": head + pixels.tobytes(), f"{name}-map.yaml": text.encode()}


COLUMNS = ("goal", "given_s", "x_m", "y_m", "row", "column", "answered_after_s", "plans", "reached_s", "in_tour")


def goals_csv(facts: BagFacts) -> bytes:
    """The goals and what the recorded planner made of them, a line each."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for number, each in enumerate(facts.goals, 1):
        places = (f"{each.place[0]:.3f}", f"{each.place[1]:.3f}", *each.cell)
        answered, reached = latency(each), each.reached
        writer.writerow(
            (
                number, f"{each.time:.3f}", *places, "" if answered is None else f"{answered:.6f}", each.plans,
                "" if reached is None else f"{reached:.3f}", "yes" if each.toured else "no",
            )
        )  # fmt: skip
    return out.getvalue().encode()


def latency(goal: Given) -> float | None:
    """Seconds from a goal to the first plan after it."""
    return None if goal.answered is None else goal.answered - goal.time


def settings_of(facts: BagFacts, robot: str = "robot") -> dict[str, str]:
    """The measured figures of the robot as settings of ``hwsw run --set``, for a platform that calls it ``robot``."""
    settings = {}
    if facts.reach.value is not None:
        settings[f"{robot}.sensor.range"] = f"{_number(facts.reach.value)} m"
    if facts.rays.value is not None and facts.rays.value <= 4096:
        settings[f"{robot}.sensor.rays"] = f"{facts.rays.value:.0f}"
    if facts.speed.value is not None:
        settings[f"{robot}.kinematics.speed"] = f"{_number(facts.speed.value)} m/s"
    return settings


def workload_text(facts: BagFacts, name: str, planner: str, mapping: Mapping[str, Any], like: str) -> str:
    """The workload, each figure with its source as a comment."""
    bag, cells = facts.recording, facts.toured
    title = f"The run of the bag {_comment(bag.path.name)}"
    lines = [*_head_lines(facts, name), "kind: workload", f"name: {name}", f"description: {json.dumps(title)}", ""]
    lines += [f"planner: {_word(planner)} # with its mapping as in workload {_comment(like)}", "", "problem:"]
    rule = f"values to {FREE_TO} are free, those from {OCCUPIED_FROM} to 100 occupied"
    lines += [
        f"  # The map of {facts.map.time:.3f} s: {rule}.",
        f"  map: {{file: {name}-map.yaml}}",
        f"  goals: [{list(cells[0])}] # {_comment(facts.goal_source)}",
        f"  starts: [{list(facts.start)}] # {_comment(facts.start_source)}",
        "",
        "scenario:",
        "  type: drive",
        "  known: all",
    ]
    if facts.period.value is not None:
        lines.append(f"  control_period: {_time(facts.period.value)} # {_comment(facts.period.source)}")
    if len(cells) > 1:
        lines += ["  tour:", *(f"    - {list(cell)}" for cell in cells[1:])]
        lines.append("  tour_times: # when each was given, counted from the first goal")
        lines += [f"    - {_time(time)}" for time in _times(facts)[1:]]
    lines += _obstacle_lines(facts)
    limit = math.ceil(max(LONGEST_MISSION_S, 2 * bag.length))
    lines += [f"  limit: {limit} s # twice the bag, at least {LONGEST_MISSION_S:g} s", "", "mapping:"]
    lines += [f"  {_word(task)}: {json.dumps(place)}" for task, place in mapping.items()]
    return "\n".join(lines) + "\n"


def _word(text: str) -> str:
    return text if text.isidentifier() and text.isascii() else json.dumps(text)


def _head_lines(facts: BagFacts, name: str) -> list[str]:
    bag = facts.recording
    lines = [
        f"# Made of the bag {_comment(bag.path.name)}, {bag.length:.1f} s long. The mission begins at"
        f" {facts.begin:.3f} s, with the first goal.",
        *(f"# - {_comment(remark)}." for remark in facts.remarks),
        "#",
        "# The robot is that of the platform. The robot of the bag:",
        f"#   greatest speed: {_source(facts.speed, 'm/s')}",
        f"#   turn rate: {_source(facts.turn_rate, 'rad/s')}",
        f"#   range of the sensor: {_source(facts.reach, 'm')}",
        f"#   rays of a full turn: {_source(facts.rays, '')}",
        f"#   field of view: {_source(facts.view, 'rad')}; sensors of models see the full circle",
    ]
    settings = " ".join(f"--set {key}={value.replace(' ', '')}" for key, value in settings_of(facts).items())
    if settings:
        lines += [
            "# With it, on a platform that calls its robot robot:",
            f"#   hwsw run PLATFORM {name}.yaml {settings}",
        ]
    return lines


def _times(facts: BagFacts) -> list[float]:
    """The times at which the goals of the workload were given, s. Of neighbours that are one cell, the first counts."""
    toured = [each for each in facts.goals if each.toured]
    return [each.time for at, each in enumerate(toured) if not at or each.cell != toured[at - 1].cell]


def _obstacle_lines(facts: BagFacts) -> list[str]:
    drawn, rule = facts.obstacles, facts.obstacles.rule
    if not drawn.obstacles:
        return ["  # The scans show no obstacle that the map does not have."]
    stay = "to the end" if rule.stay is None else f"{rule.stay:g} s after the last hit"
    lines = [
        f"  # {drawn.hits:,} rays met cells that the map has free, more than {rule.margin:g} m from its obstacles.",
        f"  # Slots of {rule.slot:g} s; {rule.least} hits or more; cells within {rule.radius:g} m of the robot are"
        f" open; what is not seen again stays {stay}.",
    ]
    if drawn.left_out:
        lines.append(f"  # {drawn.left_out:,} smaller obstacles are left out.")
    always = [each for each in drawn.obstacles if each.at == 0.0 and each.until is None]
    start = facts.start
    hidden = [each for each in always if not _covers(each, start)]
    others = [each for each in drawn.obstacles if each not in hidden]
    if hidden:
        lines.append("  hidden: # there all the time")
        lines += [f"    - {{{_box(each)}}}" for each in hidden]
    if others:
        lines += ["  obstacles:", "    appearing:"]
        for each in others:
            until = "" if each.until is None else f", until: {_time(each.until)}"
            lines.append(f"      - {{at: {_time(each.at)}, {_box(each)}{until}}}")
    return lines


def _covers(each: Any, cell: tuple[int, int]) -> bool:
    rows, columns = cell[0] - each.row, cell[1] - each.column
    return bool(0 <= rows < each.rows and 0 <= columns < each.columns)


def _box(each: Any) -> str:
    size = "".join(f", {key}: {value}" for key, value in (("rows", each.rows), ("columns", each.columns)) if value > 1)
    return f"row: {each.row}, column: {each.column}{size}"


def _source(figure: Measured, unit: str) -> str:
    if figure.value is None:
        return _comment(f"not known: {figure.source}")
    return _comment(f"{_number(figure.value)} {unit}".rstrip() + f", {figure.source}")


def _comment(text: str) -> str:
    """A text of any origin as a comment or a quoted text: printable, in one line, without ``#`` and quotes."""
    return re.sub(r"[\"'\\#]", "_", printable(text, 300))


def _time(seconds: float) -> str:
    """A time to the microsecond.

    >>> _time(54.49902), _time(0.05), _time(0.0004)
    ('54.49902 s', '50 ms', '400 us')
    """
    whole = max(0, round(seconds * 1e6))
    if whole >= 10**6 or not whole:
        return f"{whole / 1e6:.6f}".rstrip("0").rstrip(".") + " s"
    return f"{whole} us" if whole % 1000 else f"{whole // 1000} ms"


def _number(value: float) -> str:
    return f"{value:.6g}"
