"""docs/tutorial.md, block by block: its files are written, its edits made, its commands run, its excerpts compared."""

from __future__ import annotations

import csv
import json
import re
import shlex
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import pytest
from click.testing import Result
from places import ROOT

DOCS = ROOT / "docs"
PAGE = (DOCS / "tutorial.md").read_text(encoding="utf-8")
FENCED = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
EXIT_CODE = re.compile(r"\s+# exit code (\d+)$")


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, the file that it is of, and what stands in it."""

    language: str
    file: str
    text: str

    @property
    def lines(self) -> list[str]:
        return self.text.splitlines()


BLOCKS = [Block(*found) for found in FENCED.findall(PAGE)]


def words(line: str) -> str:
    """A line without what only its table's width decides."""
    return " ".join(line.split())


def missing_line(shown: list[str], text: str) -> str | None:
    """The first line of an excerpt that ``text`` does not have in this order; lines follow each other but at dots."""
    printed = [line for line in map(words, text.splitlines()) if line and set(line) != {"─"}]
    if not _stands_in([words(line) for line in shown if line.strip()], printed):
        return next(
            (line for line in shown if words(line) != "..." and not any(_same(words(line), it) for it in printed)),
            f"{shown[0]} (in this order)",
        )
    return None


def _stands_in(shown: list[str], printed: list[str]) -> bool:
    """Whether each run of lines between dots stands in ``printed``, each after the one before."""
    place = 0
    for run in _runs(shown):
        starts = range(place, len(printed) - len(run) + 1)
        found = [at for at in starts if all(_same(one, printed[at + index]) for index, one in enumerate(run))]
        if not found:
            return False
        place = found[0] + len(run)
    return True


def _runs(shown: list[str]) -> Iterator[list[str]]:
    ends = [-1, *(index for index, line in enumerate(shown) if line == "..."), len(shown)]
    for begin, end in pairwise(ends):
        if shown[begin + 1 : end]:
            yield shown[begin + 1 : end]


def _same(shown: str, printed: str) -> bool:
    beginning = shown.removesuffix(" ...")
    return printed.startswith(beginning) if beginning != shown else printed == shown


def edited(text: str, change: list[str]) -> str:
    """A file with the lines of a change taken out and put in; each stands in it once, and is all that changes."""
    old = "".join(f"{line[1:]}\n" for line in change if line.startswith("-"))
    new = "".join(f"{line[1:]}\n" for line in change if line.startswith("+"))
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in the file"
    return text.replace(old, new)


def check_columns(shown: list[str], file: Path) -> None:
    """Each row of an excerpt of a CSV file is a row of the file, in the columns that the excerpt has."""
    with file.open(encoding="utf-8", newline="") as opened:
        rows = list(csv.DictReader(opened))
    header, *wanted = csv.reader(shown)
    for row in wanted:
        assert row in [[each[name] for name in header] for each in rows], row


class Reader:
    """Somebody who follows the page in a folder."""

    def __init__(self, folder: Path, hwsw: Callable[..., Result]) -> None:
        self.folder, self.hwsw = folder, hwsw
        self.output = ""

    def follow(self, block: Block) -> None:
        if block.language == "sh":
            self.output = "".join(self.run(line) for line in block.lines)
        elif block.language == "diff":
            name, *change = block.lines
            path = self.folder / name.removeprefix("# ")
            path.write_text(edited(path.read_text(encoding="utf-8"), change), encoding="utf-8")
        elif block.language == "csv":
            check_columns(block.lines, self.folder / block.file)
        elif block.file:
            (self.folder / block.file).write_text(block.text, encoding="utf-8")
        else:
            self.compare(block)

    def run(self, line: str) -> str:
        code = EXIT_CODE.search(line)
        program, *arguments = shlex.split(EXIT_CODE.sub("", line))
        assert program == "hwsw"
        result = self.hwsw(*arguments)
        assert result.exit_code == (int(code[1]) if code else 0), f"{line}\n{result.output}"
        return result.output

    def compare(self, block: Block) -> None:
        shown, text = block.lines, self.output
        if block.language == "yaml":
            name, *shown = shown
            text = (self.folder / name.removeprefix("# from ")).read_text(encoding="utf-8")
        assert (lost := missing_line(shown, text)) is None, f"not printed: {lost}\n{text}"


@pytest.mark.slow
def test_the_page_holds_from_an_empty_folder(
    hwsw: Callable[..., Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))
    reader = Reader(tmp_path, hwsw)
    for block in BLOCKS:
        reader.follow(block)
    assert (tmp_path / "yard.html").stat().st_size > 10_000


def test_the_page_has_what_it_promises() -> None:
    commands = [line.split()[1] for block in BLOCKS if block.language == "sh" for line in block.lines]
    # The question of a board comes first, and its verdict is run.
    assert commands == [
        "map",
        "advise",
        "advise",
        "run",
        "init",
        "check",
        "check",
        "run",
        "run",
        "explore",
        "check",
        "explore",
        "explore",
        "run",
        "run",
        "init",
        "run",
        "list",
        "list",
        "show",
    ]
    assert sum(block.language == "text" and not block.file for block in BLOCKS) >= 10


def test_the_power_of_the_last_paragraph(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    """The ends of the intervals, which the page adds up."""
    hwsw("init")
    reader = Reader(tmp_path, hwsw)
    for block in BLOCKS:
        is_yard = block.file.startswith("yard.") and block.language != "csv"
        if is_yard or block.lines[0] == "# my-platform.yaml":  # the files of the yard, and the clock of the board
            reader.follow(block)

    def interval(*settings: str) -> list[str]:
        options = [text for setting in settings for text in ("--set", setting)]
        power = json.loads(hwsw("run", "my-platform.yaml", "yard.yaml", "--json", *options).stdout)["power"]
        return [f"{power['static'][end] + power['dynamic'][end]:.2f} W" for end in ("low", "high")]

    low, high = interval("fabric.part=XC7A35T-1")
    assert f"it may be {low} or {high}" in words(PAGE)
    assert f"takes at least {interval('relax.block=[24, 40]')[0]}" in words(PAGE)


@pytest.mark.parametrize("shown", [["a 1"], ["a 12", "c 3"], ["b 7", "...", "a 12"], ["b 8 ..."]])
def test_an_excerpt_that_was_not_printed_is_found(shown: list[str]) -> None:
    assert missing_line(shown, "a  12\nb  7 and more\nb   7\nc  3\n") is not None


def test_an_excerpt_that_was_printed_is_found() -> None:
    assert missing_line(["a 12", "b 7 ...", "...", "c 3"], "a  12\n──\nb  7 and more\nb   7\nc  3\n") is None


def test_a_change_of_a_line_that_is_not_there_fails() -> None:
    with pytest.raises(AssertionError, match="0 times"):
        edited("one\n", ["-two", "+three"])


@pytest.mark.parametrize("target", re.findall(r"\]\(((?!http)[^)#]+)[^)]*\)", PAGE))
def test_links_lead_somewhere(target: str) -> None:
    assert (DOCS / target).exists()
