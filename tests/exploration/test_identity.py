"""A result depends on every plug-in that is installed: whatever changes in one changes the digest of results."""

import ast
import shutil
import sys
from pathlib import Path

import pytest
from small_maps import MAP, Specs, put_map

import codesign
from codesign import exploration
from codesign.errors import RunError
from codesign.exploration import Progress, explore, identity, load_study
from codesign.exploration.check import check_points
from codesign.exploration.identity import code_digest
from codesign.inputs.part_file import PARTS
from codesign.planners.plug_in import GROUP
from codesign.system import catalog


def install(
    folder: Path, group: str, *, version: str = "1", value: str = "made_up:ALL", source: str = ""
) -> None:
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
    names = {point.name for point in catalog.registered() if point.value.startswith("codesign.")}
    assert names == set(catalog.planners())


def imported(module: str) -> set[str]:
    """The modules of ``exploration`` that one imports when it runs."""
    folder = Path(exploration.__file__).parent
    tree = ast.parse((folder / f"{module}.py").read_text(encoding="utf-8"))
    typing_only = [
        inner
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        for inner in node.body
    ]
    names = [
        node.module or ""
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node not in typing_only
    ]
    return {
        name.removeprefix("codesign.exploration.")
        for name in names
        if name.startswith("codesign.exploration.")
    }


def test_what_a_stored_result_comes_from_is_in_the_digest() -> None:
    modules, new = set[str](), {"evaluation", "blocks", "search_bound"}
    while new:
        modules |= new
        new = set.union(*map(imported, new)) - modules
    assert {f"{module}.py" for module in modules} | {"__init__.py"} == identity._OF_RESULTS


@pytest.mark.parametrize(
    ("file", "counts"),
    [
        ("exploration/partition.py", True),
        ("exploration/bounds.py", True),
        ("exploration/blocks.py", True),
        ("pricing/price.py", True),
        ("planners/harmonic/plan/relax.py", True),
        ("exploration/study.py", False),
        ("exploration/pace.py", False),
        ("report/page.py", False),
        ("planners/harmonic/paper/speed.py", False),
    ],
)
def test_a_change_of_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file: str, counts: bool) -> None:
    package = tmp_path / "codesign"
    shutil.copytree(
        Path(codesign.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__", "*.json")
    )
    monkeypatch.setattr(identity, "files", lambda _name: package)
    before = digest()
    (package / file).write_bytes((package / file).read_bytes() + b"# changed\n")
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
    install(
        tmp_path, GROUP, version="2", value="made_up:OTHERS", source="# mended, and the version forgotten\n"
    )
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


def test_in_a_namespace_package_only_the_plug_in_itself_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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


def test_a_plug_in_that_is_not_there_does_not_end_the_digest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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


def test_a_part_that_changes_meanwhile_ends_the_run_and_keeps_nothing_of_it(
    specs: Specs, tmp_path: Path
) -> None:
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
