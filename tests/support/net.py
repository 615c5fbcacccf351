"""The bytes that the shipped files give, as digests: a change of the structure alone moves none of them.

``python tests/support/net.py`` writes results, traces, pages and studies into ``out/net`` and compares their digests
with those in ``net.json`` beside this file. ``--write`` takes the present ones, which a commit that moves a figure does
and says why.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from click.testing import CliRunner
from shipped_pairs import MISSIONS, PLATFORMS, SHORT, short_study

from codesign.cli import main

PLACE = re.compile(r"\S*/advice/[0-9a-f]{12}")
"""The folder of an answer to a question, whose name depends on where the package is installed."""

ROOT = Path(__file__).parents[2]
KEPT = Path(__file__).with_suffix(".json")
FOLDER = ROOT / "out" / "net"

QUESTION = ("advise", "house", "--goal", "133,144", "--rate", "20Hz", "--boards", "arty-a7,virtex4-pci,nexys2")


def commands() -> Iterator[tuple[str, ...]]:
    """Every command of the net, with files in the present folder."""
    for workload, platform in PLATFORMS.items():
        limit = SHORT if workload in MISSIONS else ()
        files = ("--trace", f"{workload}.mcap", "--html", f"{workload}.html")
        yield ("run", platform, workload, "--no-levers", "--json", *files, *limit)
        yield ("run", platform, workload, "--no-levers", "--verbose", *limit)
        for what in ("show", "stats", "timeline"):
            yield ("trace", what, f"{workload}.mcap")
        for option, ending in (("--perfetto", "json"), ("--vcd", "vcd"), ("--poses", "csv"), ("--html", "html")):
            yield ("trace", "export", f"{workload}.mcap", option, f"{workload}-trace.{ending}")
        study = short_study(workload, Path())
        if study is not None:
            kept = ("--store", f"{workload}.sqlite", "--workers", "1")
            shown = ("--csv", f"{workload}-study.csv", "--html", f"{workload}-study.html")
            yield ("explore", platform, str(study), *kept, *shown, "--json")
            yield ("report", f"{workload}.sqlite", "--verbose")
    yield ("run", PLATFORMS[MISSIONS[0]], MISSIONS[0], "--json")
    yield ("explore", "virtex4-pci", "labyrinth", "--store", "labyrinth-all.sqlite", "--csv", "labyrinth-all.csv")
    yield ("compare", "--html", "compare.html", "--json")
    yield (*QUESTION, "--json")
    yield QUESTION
    yield ("reproduce", "--quick", "--html", "reproduce.html", "--csv", "reproduce.csv", "--json")
    yield ("reproduce", "--quick", "--verbose")
    yield ("list",)
    for what in ("platform", "workload", "part", "result", "study", "advice"):
        yield ("schema", what)


def cast() -> dict[str, str]:
    """Run every command in a new folder, and return the digest of what each printed and of each file, by name."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    digests, runner = {}, CliRunner()
    os.environ.update(COLUMNS="120", SOURCE_DATE_EPOCH="0", CODESIGN_CACHE_DIR=str(FOLDER / "cache"))
    with contextlib.chdir(FOLDER):
        for arguments in commands():
            done = runner.invoke(main, arguments)
            name = " ".join(arguments)
            (FOLDER / f"{len(digests):03}.txt").write_text(f"{name}\n{done.exit_code}\n{done.stdout}", encoding="utf-8")
            said = PLACE.sub("cache", done.stdout)
            digests[name] = digest(f"{done.exit_code}\n{said}".encode())
            if done.exit_code not in (0, 3):
                print(f"{name}: exit code {done.exit_code}\n{done.output[-600:]}", file=sys.stderr)
        for path in sorted(Path().rglob("*")):
            if path.is_file() and path.parts[0] != "cache" and path.suffix not in {".sqlite", ".txt"}:
                digests[str(path)] = digest(path.read_bytes())
    return digests


def digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def differing(kept: dict[str, str], found: dict[str, str]) -> list[str]:
    """What each name that differs lacks or has."""
    names = dict.fromkeys((*kept, *found))
    return [
        f"{name}: {kept.get(name, 'new')} → {found.get(name, 'gone')}"
        for name in names
        if kept.get(name) != found.get(name)
    ]


if __name__ == "__main__":
    found = cast()
    if "--write" in sys.argv:
        KEPT.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    lost = differing(json.loads(KEPT.read_text(encoding="utf-8")), found)
    print("\n".join(lost) or f"{len(found)} files and answers are equal to the byte")
    sys.exit(bool(lost))
