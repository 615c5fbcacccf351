"""The size and the shape of ``codesign/`` in figures: ``python -m docs.count_house`` prints the table of house.md.

Most figures are counted on the syntax trees of the package. One run of ``hwsw run`` counts the modules of a run.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import networkx as nx

PACKAGE = Path(__file__).parents[1] / "codesign"
SUBORDINATE = re.compile(r"(What|Whether|Where|When|How|Why|Which|Who|While|If|As|Until|Unless)\b")


@cache
def trees() -> dict[str, ast.Module]:
    """The syntax tree of every module, by its dotted name."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = ast.parse(path.read_text(encoding="utf-8"))
    return found


def lines() -> int:
    """Lines of Python."""
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in PACKAGE.rglob("*.py"))


def namers(word: str) -> int:
    """Files that name a word."""
    return sum(word in path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py"))


def classes(*modules: str) -> set[str]:
    """The names of the classes of some modules."""
    return {
        node.name
        for name, tree in trees().items()
        if any(name == f"codesign.{each}" or name.startswith(f"codesign.{each}.") for each in modules)
        for node in tree.body
        if isinstance(node, ast.ClassDef)
    }


def type_tests(names: set[str]) -> int:
    """Calls of isinstance, and class patterns of match, that name one of these classes."""
    count = 0
    for tree in trees().values():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
                asked: ast.AST = node.args[1]
            elif isinstance(node, ast.MatchClass):
                asked = node.cls
            else:
                continue
            count += any(last_name(each) in names for each in ast.walk(asked))
    return count


def last_name(node: ast.AST) -> str:
    """The last part of a dotted name; "" of anything else."""
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


def late_imports() -> int:
    """Statements of import inside functions."""
    return sum(
        isinstance(inner, ast.Import | ast.ImportFrom)
        for tree in trees().values()
        for node in outermost_functions(tree)
        for inner in ast.walk(node)
    )


def outermost_functions(tree: ast.AST) -> Iterator[ast.AST]:
    """The functions and methods that stand in no other."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node
        else:
            yield from outermost_functions(node)


def group_bys() -> int:
    """Groups made by hand: dicts of lists or sets, groupby, unique with its inverse."""
    count = 0
    for tree in trees().values():
        for node in ast.walk(tree):
            if not isinstance(node, ast.Call):
                continue
            called, words = last_name(node.func), {word.arg for word in node.keywords}
            collects = bool(node.args) and last_name(node.args[-1]) in {"list", "set", "dict"}
            empty = bool(node.args) and isinstance(node.args[-1], ast.List | ast.Dict | ast.Call)
            count += (
                called == "groupby"
                or (called == "defaultdict" and collects)
                or (called == "setdefault" and empty)
                or (called == "unique" and bool(words & {"return_inverse", "return_index"}))
            )
    return count


RUN = """
import sys
used, loading = set(), 0
def profile(frame, event, argument):
    global loading
    if event not in ("call", "return"):
        return
    if frame.f_code.co_name == "<module>":
        loading += 1 if event == "call" else -1
    elif event == "call" and not loading:
        used.add(frame.f_globals.get("__name__", ""))
sys.setprofile(profile)
from codesign.cli import main
sys.argv = ["hwsw", "run", "virtex4-pci", "labyrinth", "-q"]
try:
    main()
except SystemExit:
    pass
sys.setprofile(None)
ours = lambda names: sum(name.split(".")[0] == "codesign" for name in names)
print(ours(sys.modules), ours(used), file=sys.stderr)
"""


@cache
def modules_of_a_run() -> tuple[int, int]:
    """Modules that a plain run loads, and those of them with a function that runs."""
    done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, check=True)
    loaded, ran = map(int, done.stderr.split()[-2:])
    return loaded, ran


@cache
def arrows() -> nx.DiGraph:
    """Which module imports which, wherever the import stands."""
    known, graph = set(trees()), nx.DiGraph()
    for name, tree in trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                targets = [alias.name for alias in node.names]
            elif (
                isinstance(node, ast.Call) and last_name(node.func) == "late" and isinstance(node.args[0], ast.Constant)
            ):
                targets = [str(node.args[0].value)]
            elif isinstance(node, ast.ImportFrom):
                targets = [
                    whole if (whole := f"{node.module}.{alias.name}") in known else str(node.module)
                    for alias in node.names
                ]
            else:
                continue
            graph.add_edges_from((name, target) for target in targets if target in known - {name})
    return graph


def circles() -> int:
    """Circles of modules that import each other, imports for types included."""
    return sum(len(group) > 1 for group in nx.strongly_connected_components(arrows()))


def modules_in_circles() -> int:
    """Modules that import each other."""
    return sum(len(group) for group in nx.strongly_connected_components(arrows()) if len(group) > 1)


def rooms() -> int:
    """Packages at the top level."""
    return sum(path.is_dir() and any(path.glob("*.py")) for path in PACKAGE.iterdir())


def docstrings() -> Iterator[str]:
    """The docstrings of all modules, classes and functions."""
    for tree in trees().values():
        for node in ast.walk(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                yield ast.get_docstring(node) or ""


def subordinate() -> int:
    """Docstrings that begin with a subordinate clause."""
    return sum(bool(SUBORDINATE.match(text)) for text in docstrings())


def pronouns() -> int:
    """Places where docstrings say “that of” or “those of”."""
    return sum(len(re.findall(r"\b(?:that|those) of\b", text)) for text in docstrings())


FIGURES: dict[str, tuple[Callable[[], int], int]] = {
    "lines of Python": (lines, 82_000),
    "files that name `BusLink`, a kind of link": (lambda: namers("BusLink"), 3),
    "places that test the type of a component or link": (
        lambda: type_tests(classes("inputs.components", "inputs.links", "components")),
        10,
    ),
    "places that test the type of a record": (lambda: type_tests(classes("ground.records") - {"Record"}), 10),
    "imports inside functions": (late_imports, 60),
    "groupings written by hand": (group_bys, 10),
    "modules that a plain run loads": (lambda: modules_of_a_run()[0], 250),
    "modules with a function that a plain run calls": (lambda: modules_of_a_run()[1], 110),
    "circles of imports, imports for types included": (circles, 0),
    "modules in such circles": (modules_in_circles, 0),
    "packages at the top level": (rooms, 12),
    "docstrings that begin with a subordinate clause": (subordinate, 40),
    "“that of”, “those of” in docstrings": (pronouns, 30),
}
"""What is counted, and the most that it may be."""


def main() -> None:
    """Print the table."""
    print("| figure | now | at most | met |\n|---|---|---|---|")
    for name, (count, most) in FIGURES.items():
        found = count()
        print(f"| {name} | {found:,} | {most:,} | {'yes' if found <= most else 'no'} |", flush=True)


if __name__ == "__main__":
    main()
