"""A search in a workload: ``explore.search``, and what the command line puts in its place."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from small_search import small_workload

import codesign
from codesign.ground.errors import InputError, SpecError
from codesign.inputs import Workload
from codesign.inputs.exploration import MOST_SEED, SAMPLERS, Searching, asked
from codesign.study import load_study
from codesign.study.budget import Budget

Run = Callable[..., Result]

AXES = "  axes: {relax.iterations: [2, 4], fpga.clock: [60 MHz, 75 MHz, 90 MHz], pci.clock: [66 MHz, 33 MHz]}\n"


def load(folder: Path, search: str) -> Workload:
    small_workload(folder)
    path = folder / "small.yaml"
    path.write_text(f"{path.read_text()}explore:\n{AXES}  search: {search}\n")
    return codesign.load_workload(path)


def written(folder: Path, search: str) -> Searching | None:
    section = load(folder, search).explore
    assert section is not None
    return section.search


def test_a_text_is_a_sampler(tmp_path: Path) -> None:
    for name in SAMPLERS:
        assert written(tmp_path, name) == Searching(sampler=name)  # type: ignore[arg-type]


def test_every_key(tmp_path: Path) -> None:
    search = written(tmp_path, "{sampler: nsga2, points: 40, time: 2min, seed: 3, population: 20}")
    assert search is not None
    assert (search.points, search.seconds, search.seed, search.population) == (40, 120.0, 3, 20)
    search = written(tmp_path, "{sampler: tpe, startup: 5}")
    assert search == Searching(sampler="tpe", startup=5)


@pytest.mark.parametrize(
    ("search", "fault"),
    [
        ("nsga3", "18:11: explore.search: "),
        ("nsga3", "did you mean nsga2"),
        ("{sampler: tpa}", "18:21: explore.search.sampler: "),
        ("{sampler: tpa}", "did you mean tpe"),
        ("{sampler: tpe, point: 3}", "18:26: explore.search.point: unknown key"),
        ("{sampler: tpe, point: 3}", "did you mean points"),
        ("{sampler: tpe, points: 0}", "18:34: explore.search.points: "),
        ("{sampler: tpe, time: 10}", "18:32: explore.search.time: 10 has no unit"),
        ("{sampler: tpe, seed: -1}", "18:32: explore.search.seed: "),
        (f"{{sampler: tpe, seed: {MOST_SEED + 1}}}", "18:32: explore.search.seed: "),
        ("{sampler: tpe, population: 20}", "18:26: explore.search.population: tpe has no population"),
        ("{sampler: bound, startup: 20}", "18:28: explore.search.startup: bound has no startup"),
        ("{points: 20}", "explore.search.sampler: "),
        ("[tpe]", "18:11: explore.search: "),
    ],
)
def test_faults_have_their_place(tmp_path: Path, search: str, fault: str) -> None:
    with pytest.raises(SpecError) as refused:
        load(tmp_path, search)
    assert fault in str(refused.value)


def test_what_is_asked_for_replaces_what_is_written() -> None:
    own = Searching(sampler="nsga2", points=40, seed=3, population=20)
    assert asked(own, None, None) == own
    assert asked(own, "nsga2", 5) == own.model_copy(update={"seed": 5})
    assert asked(own, "tpe", None) == Searching(sampler="tpe", points=40, seed=3)
    assert asked(own, "all", None) is None
    assert asked(None, None, None) is None
    assert asked(None, "bound", None) == Searching(sampler="bound")
    with pytest.raises(InputError, match="there is no search nsga"):
        asked(own, "nsga", None)
    with pytest.raises(InputError, match="of no search"):
        asked(None, None, 4)
    with pytest.raises(InputError, match="is no seed"):
        asked(own, None, -4)


def test_the_workload_says_how_it_is_searched(tmp_path: Path) -> None:
    workload, file = load(tmp_path, "{sampler: random, points: 5, seed: 2}"), tmp_path / "points.sqlite"
    study = codesign.explore("virtex4-pci", workload, store=file)
    assert study.search is not None
    assert [len(trace.designs) for trace in study.search.traces] == [5]
    more = codesign.explore("virtex4-pci", workload, store=file, budget=Budget(points=8), seed=2)
    assert more.search is not None
    assert more.search.traces[0].designs[:5] == study.search.traces[0].designs
    assert len(more.search.traces[0].designs) == 8
    every = codesign.explore("virtex4-pci", workload, store=file, search="all")
    assert every.search is None
    assert not every.missing
    assert load_study(file) == every


def test_a_search_moves_no_point(tmp_path: Path) -> None:
    file = tmp_path / "points.sqlite"
    searched = load(tmp_path, "{sampler: random, points: 12}")
    assert codesign.explore("virtex4-pci", searched, store=file).simulations
    other = load(tmp_path, "{sampler: random, points: 12, seed: 7}")
    assert not codesign.explore("virtex4-pci", other, store=file).simulations


def test_the_command_line_overrides_it(tmp_path: Path, hwsw: Run) -> None:
    load(tmp_path, "{sampler: random, points: 5, seed: 2}")

    def shown(*options: str) -> list[str]:
        ran = hwsw("explore", "virtex4-pci", "small.yaml", "--workers", "1", "--store", "p.sqlite", *options)
        assert ran.exit_code == 0, ran.output
        return [" ".join(line.split()[:3]) for line in ran.stdout.splitlines()]

    assert "random 2 5" in shown()
    assert "random 4 7" in shown("--seed", "4", "--points", "7")
    assert "random 2 4" in shown("--points", "4")
    assert any(re.fullmatch(r"bound \d+ all", line) for line in shown("--search", "bound"))
    every = shown("--search", "all")
    assert not any(line.startswith("random") for line in every)
    refused = hwsw("explore", "virtex4-pci", "small.yaml", "--search", "all", "--seed", "3")
    assert "a seed of 3 is of no search" in refused.output
