"""A workload on a small map of its own."""

from __future__ import annotations

from pathlib import Path

Specs = tuple[Path, Path]
AXES_TEXT = "{relax.iterations: [1, 4]}"
MAP = "......\n.@..@.\n......\n......\n"


def put_map(specs: Specs, text: str = MAP, *, goals: str = "[[0, 0]]", starts: str = "[[3, 5]]") -> Path:
    """The small workload on a map file of its own."""
    file = specs[1].parent / "small.txt"
    file.write_text(text, encoding="utf-8")
    lines = specs[1].read_text(encoding="utf-8").partition("explore:")[0].splitlines()
    new = {
        "map": "{file: small.txt}",
        "goals": goals,
        "starts": starts,
        "relax": "{component: fpga, block: [2, 2], iterations: 4, schedule: [15]}",
    }
    lines = [f"  {key}: {new[key]}" if (key := line.strip().partition(":")[0]) in new else line for line in lines]
    specs[1].write_text("\n".join([*lines, f"explore: {{axes: {AXES_TEXT}}}", ""]), encoding="utf-8")
    return file
