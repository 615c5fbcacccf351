"""A result depends on every plug-in that is installed: whatever changes in one changes the digest of results."""

import ast
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from examples import THOROUGH
from small_maps import MAP, Specs, put_map

import codesign
from codesign import study
from codesign.ground.errors import RunError
from codesign.inputs.files import data_folder
from codesign.inputs.library import PARTS
from codesign.planners.registered import GROUP, registered
from codesign.study import Progress, explore, identity, load_study
from codesign.study.advice.candidates import Board, arrangements_of
from codesign.study.advice.needs import ask, parse_needs, problem_section
from codesign.study.advice.trials import Laboratory
from codesign.study.check import check_points
from codesign.study.identity import code_digest, fingerprint, package_digest
from codesign.system import catalog
from codesign.system.problem_map import grid_of


def install(folder: Path, group: str, *, version: str = "1", value: str = "made_up:ALL", source: str = "") -> None:
    """A distribution as pip leaves it, that registers in one group only."""
    (folder / "made_up").mkdir(exist_ok=True)
    (folder / "made_up" / "__init__.py").write_text(f"ALL = OTHERS = ()\n{source}")
    (folder / "made_up" / "deep").mkdir(exist_ok=True)
    (folder / "made_up" / "deep" / "helper.py").write_text("FIGURE = 1\n")
    information = folder / "made_up-0.dist-info"
    information.mkdir(exist_ok=True)
    (information / "METADATA").write_text(f"Metadata-Version: 2.1\nName: made-up\nVersion: {version}\n")
    (information / "entry_points.txt").write_text(f"[{group}]\nmade_up = {value}\n")


def digest() -> str:
    code_digest.cache_clear()
    sys.path_importer_cache.clear()
    try:
        return code_digest()
    finally:
        code_digest.cache_clear()


def test_our_own_planners_are_registered_as_others_are() -> None:
    names = {point.name for point in registered() if point.value.startswith("codesign.")}
    assert names == set(catalog.planners())


def imported(module: str) -> set[str]:
    """The modules directly in ``study`` that one imports when it runs."""
    folder = Path(study.__file__).parent
    tree = ast.parse((folder / f"{module}.py").read_text(encoding="utf-8"))
    typing_only = [
        inner
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        for inner in node.body
    ]
    names = [
        node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node not in typing_only
    ]
    inner = [name.removeprefix("codesign.study.") for name in names if name.startswith("codesign.study.")]
    return {name for name in inner if "." not in name}


def test_what_a_stored_result_comes_from_is_in_the_digest() -> None:
    modules, new = set[str](), {"evaluation", "blocks", "search_bound"}
    while new:
        modules |= new
        new = set.union(*map(imported, new)) - modules
    assert {f"{module}.py" for module in modules} | {"__init__.py"} == identity._OF_RESULTS


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of what ships, to be changed: what this process runs on stays as it is."""
    root = tmp_path / "shipped"
    sources = {"codesign": Path(codesign.__file__).parent}
    sources |= {name: data_folder(name) for name in ("platforms", "workloads")}
    for name, source in sources.items():
        # In a wheel the data lie in the package.
        ignored = shutil.ignore_patterns("__pycache__", *sources)
        shutil.copytree(source, root / name, ignore=ignored)
    monkeypatch.setattr(identity, "_PACKAGE", root / "codesign")
    monkeypatch.setattr(identity, "data_folder", lambda name: root / name)
    return root


Keys = tuple[str, str, str]


@pytest.fixture
def asked() -> Callable[[], Keys]:
    """The keys of stored answers and of a trial of advice, and what a worker of a cluster is compared by."""
    platform, labyrinth = codesign.load_platform("virtex4-pci"), codesign.load_workload("labyrinth")
    grid, needs, file = grid_of(labyrinth), parse_needs("10 Hz"), data_folder("workloads") / "maps/house.yaml"
    question = ask(needs, problem_section(file, ["133, 144"], (), needs), file)
    arrangement = next(arrangements_of(Board("virtex4-pci", platform), question.problem, question.needs))
    candidate = arrangement.candidate(next(arrangement.families()).chain[0])

    def keys() -> Keys:
        code_digest.cache_clear()
        package_digest.cache_clear()
        try:
            return (fingerprint(platform, labyrinth, grid), Laboratory(question).key(candidate), package_digest())
        finally:
            code_digest.cache_clear()
            package_digest.cache_clear()

    return keys


SHOWN = {"calibrate", "certificates", "cli", "paper", "report", "reproduce", "trace"}
"""Folders, or modules, that show results or make files to be named: no result comes from them."""


def makes_results(name: str) -> bool:
    """True if a result can depend on a shipped file. Of ``study`` another test says it."""
    if not name.startswith("codesign/"):
        return name.startswith(("platforms/parts/", "platforms/hosts/"))
    return SHOWN.isdisjoint(name.split("/")) and not name.startswith("codesign/study/")


def test_every_shipped_file_counts(shipped: Path, asked: Callable[[], Keys]) -> None:
    """Each file is changed by itself. Of the many alike, modules and data of one folder, a part stands for all."""
    for suffix, share in ((".py", 12), (".yaml", 1 if THOROUGH else 4)):
        for number, path in enumerate(sorted(shipped.rglob(f"*{suffix}"))):
            if number % share:
                path.unlink()
    files = sorted(path for path in shipped.rglob("*") if path.is_file())
    assert {".py", ".json", ".v", ".yaml", ".jinja", ".pgm"} <= {path.suffix for path in files}
    before, wrong = asked(), []
    for path in files:
        name, content = path.relative_to(shipped).as_posix(), path.read_bytes()
        path.write_bytes(content + b"\n")
        store, advice, cluster = (new != old for new, old in zip(asked(), before, strict=True))
        if not cluster or advice != store or store < makes_results(name):
            wrong.append((name, store, advice, cluster))
        path.write_bytes(content)
    assert wrong == []
    assert asked() == before


def test_a_file_that_is_new_or_gone_counts(shipped: Path, asked: Callable[[], Keys]) -> None:
    seen = [asked()]
    new = shipped / "codesign" / "planners" / "harmonic" / "measured" / "more.json"
    new.write_text("[]")
    seen.append(asked())
    new.unlink()
    assert asked() == seen[0]
    (shipped / "platforms" / "hosts" / "cortex-a72.yaml").unlink()
    seen.append(asked())
    assert all(len(set(column)) == 3 for column in zip(*seen, strict=True))


@pytest.mark.parametrize(
    ("file", "counts"),
    [
        ("study/partition.py", True),
        ("study/bounds.py", True),
        ("study/blocks.py", True),
        ("study/study.py", False),
        ("study/tally.py", False),
        ("views/report/page.py", False),
        ("views/report/templates/style.css", False),
        ("planners/harmonic/paper/measures.py", False),
        ("planners/__pycache__/plug_in.pyc", False),
        ("planners/.plug_in.swp", False),
    ],
)
def test_what_only_shows_results_leaves_them(shipped: Path, file: str, counts: bool) -> None:
    before, path = digest(), shipped / "codesign" / file
    path.parent.mkdir(exist_ok=True)
    path.write_bytes((path.read_bytes() if path.exists() else b"") + b"# changed\n")
    assert (digest() != before) is counts


def test_a_plug_in_is_part_of_the_digest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    without = digest()
    monkeypatch.syspath_prepend(tmp_path)
    install(tmp_path, GROUP)
    seen = [without, digest()]
    assert digest() == seen[-1]
    install(tmp_path, GROUP, version="2")
    seen.append(digest())
    install(tmp_path, GROUP, version="2", value="made_up:OTHERS")
    seen.append(digest())
    install(tmp_path, GROUP, version="2", value="made_up:OTHERS", source="# mended, and the version forgotten\n")
    seen.append(digest())
    (tmp_path / "made_up" / "deep" / "helper.py").write_text("FIGURE = 2\n")
    seen.append(digest())
    assert len(set(seen)) == len(seen)


def test_the_source_of_a_plug_in_of_one_module_is_part_of_the_digest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    install(tmp_path, GROUP, value="made_up_module:ALL")
    (tmp_path / "made_up_module.py").write_text("ALL = 1\n")
    before = digest()
    (tmp_path / "made_up_module.py").write_text("ALL = 2\n")
    assert digest() != before


def test_in_a_namespace_package_only_the_plug_in_itself_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    install(tmp_path, GROUP, value="made_up_space.ours:ALL")
    for name in ("ours", "theirs"):
        (tmp_path / "made_up_space" / name).mkdir(parents=True)
        (tmp_path / "made_up_space" / name / "__init__.py").write_text("ALL = 1\n")
    before = digest()
    (tmp_path / "made_up_space" / "theirs" / "__init__.py").write_text("ALL = 2\n")
    assert digest() == before
    (tmp_path / "made_up_space" / "ours" / "__init__.py").write_text("ALL = 2\n")
    assert digest() != before


def test_a_plug_in_that_is_not_there_does_not_end_the_digest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    without = digest()
    install(tmp_path, GROUP, value="made_up_nowhere.inside:ALL")
    assert digest() != without


def test_a_map_that_changes_meanwhile_leaves_the_points_as_they_were_keyed(specs: Specs) -> None:
    file = put_map(specs)
    platform, workload = codesign.load_platform(specs[0]), codesign.load_workload(specs[1])
    before = explore(platform, workload, workers=1).to_json()
    changed = MAP.replace("@", ".")

    def change(_progress: Progress) -> None:
        file.write_text(changed, encoding="utf-8")

    for workers in (1, 2):
        file.write_text(MAP, encoding="utf-8")
        study = explore(platform, workload, workers=workers, progress=change)
        # The full result of a priced point is simulated when it is asked for: on the map that was read.
        assert file.read_text(encoding="utf-8") == changed
        assert study.to_json() == before
        assert check_points(study, 4).differences == ()
    file.write_text(changed, encoding="utf-8")
    assert explore(platform, workload, workers=1).to_json() != before


def test_a_part_that_changes_meanwhile_ends_the_run_and_keeps_nothing_of_it(specs: Specs, tmp_path: Path) -> None:
    put_map(specs)
    source = PARTS.shipped / "XC2V6000.yaml"
    folder = specs[0].parent / "parts"
    folder.mkdir()
    part = folder / "XC2V6000.yaml"
    part.write_bytes(source.read_bytes())
    platform, workload = codesign.load_platform(specs[0]), codesign.load_workload(specs[1])
    store = tmp_path / "points.sqlite"

    def change(_progress: Progress) -> None:
        part.write_bytes(source.read_bytes() + b"# changed\n")

    with pytest.raises(RunError, match="a part file changed"):
        explore(platform, workload, workers=1, store=store, progress=change)
    assert len(load_study(store).missing) == 2
