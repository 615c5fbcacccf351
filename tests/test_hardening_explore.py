"""What may go wrong around an exploration: files that change, axes that do not fit, problems without an answer."""

from __future__ import annotations

from pathlib import Path

import pytest

import codesign
from codesign.errors import InputError, RunError, SpecError
from codesign.explore import Progress, explore, load_study
from codesign.spec.locate import parts_folder

Specs = tuple[Path, Path]

AXES = "{relax.iterations: [1, 4]}"
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
    lines = [
        f"  {key}: {new[key]}" if (key := line.strip().partition(":")[0]) in new else line for line in lines
    ]
    specs[1].write_text("\n".join([*lines, f"explore: {{axes: {AXES}}}", ""]), encoding="utf-8")
    return file


def test_a_map_that_changes_meanwhile_leaves_the_points_as_they_were_keyed(specs: Specs) -> None:
    file = put_map(specs)
    platform, workload = codesign.load_platform(specs[0]), codesign.load_workload(specs[1])
    before = explore(platform, workload, workers=1).to_json()
    changed = MAP.replace("@", ".")

    def change(_progress: Progress) -> None:
        file.write_text(changed, encoding="utf-8")

    for workers in (1, 2):
        file.write_text(MAP, encoding="utf-8")
        assert explore(platform, workload, workers=workers, progress=change).to_json() == before
    assert explore(platform, workload, workers=1).to_json() != before


def test_a_part_that_changes_meanwhile_ends_the_run_and_keeps_nothing_of_it(
    specs: Specs, tmp_path: Path
) -> None:
    put_map(specs)
    source = parts_folder() / "XC2V6000.yaml"
    folder = specs[0].parent / "parts"
    folder.mkdir()
    part = folder / "XC2V6000.yaml"
    part.write_bytes(source.read_bytes())
    platform, workload = codesign.load_platform(specs[0]), codesign.load_workload(specs[1])
    store = tmp_path / "points.sqlite"

    def change(_progress: Progress) -> None:
        part.write_bytes(source.read_bytes() + b"# changed\n")

    with pytest.raises(RunError, match="part file changed"):
        explore(platform, workload, workers=1, store=store, progress=change)
    assert len(load_study(store).missing) == 2


def test_faults_of_axes_are_told_at_their_places(specs: Specs) -> None:
    put_map(specs)
    text = specs[1].read_text(encoding="utf-8").replace(AXES, "{fpga.clock: [100 MHz, 3 parsecs]}")
    specs[1].write_text(text, encoding="utf-8")
    with pytest.raises(SpecError, match=r"rooms\.yaml:\d+:\d+: explore\.axes\.fpga\.clock\[1\]"):
        explore(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), workers=1)


def test_more_points_than_memory_allows_are_refused(specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8").partition("explore:")[0]
    values = list(range(1, 501))
    text += f"explore: {{axes: {{relax.iterations: {values}, relax.schedule: {[[n] for n in values]}}}}}\n"
    specs[1].write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="250,000 points"):
        explore(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), workers=1)
