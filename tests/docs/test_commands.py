"""Every command ``hwsw ...`` that a page quotes exists, and has the options that stand beside it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from places import ROOT

from codesign.cli import main as cli

PAGES = sorted(
    path.relative_to(ROOT)
    for pattern in (
        "*.md",
        "docs/**/*.md",
        "docs/*.ipynb",
        "codesign/hardware/rtl/templates/*",
        "workloads/*",
        "platforms/**/*.yaml",
    )
    for path in ROOT.glob(pattern)
    # What changed names what is gone, and may.
    if path.is_file() and path.name != "CHANGELOG.md"
)
QUOTED = re.compile(r"`(?:\$ )?hwsw ([^`]+)`")
LINE = re.compile(r"^[ \t>#]*(?:\$ |\"|!)?(?:uv run |\.venv/bin/)?hwsw (.+?)(?:\\n)?\"?,?$", re.MULTILINE)
FENCE = re.compile(r"^ *```.*?^ *```|^(?: {4}.*\n)+", re.MULTILINE | re.DOTALL)
CONTINUED = re.compile(r" \\\n\s*")
WORD = re.compile(r"[a-z][a-z-]*")
OPTION = re.compile(r"(?<![\w\"'-])(--[a-z][a-z0-9-]*|-[a-z])(?![\w-])")
END = re.compile(r"\s(?:#|&&|>|;)\s|\s\|\s+(?!\w+\s*(?:\||$)|-)")


def quoted(text: str, *, blocks: bool = True) -> Iterator[str]:
    """The commands in backticks, and the lines of blocks of code that are one."""
    text = CONTINUED.sub(" ", text)
    yield from (" ".join(each.split()) for each in QUOTED.findall(text))
    for block in FENCE.findall(text) if blocks else [text]:
        yield from LINE.findall(block)


def options_of(command: click.Command) -> set[str]:
    named = {name for each in command.params for name in (*each.opts, *each.secondary_opts)}
    return {"--help", *named}


def fault(text: str) -> str | None:
    """Why there is no such command; None where there is. ``A | B`` are commands of one group."""
    text = END.split(f"{text} ")[0].strip().strip("\"'")
    command: click.Command = cli
    words = text.split()
    while isinstance(command, click.Group) and words:
        word = words.pop(0).rstrip(".,;:)")
        if word.startswith("-"):
            if word not in options_of(command):
                return f"hwsw has no {word}"
        elif not WORD.fullmatch(word):
            break  # COMMAND, ..., {this, that}
        else:
            names = [word]
            while words[:1] == ["|"]:
                names.append(words[1])
                words = words[2:]
            with click.Context(command) as context:
                found = [command.get_command(context, name) for name in names]
            for name, each in zip(names, found, strict=True):
                if each is None:
                    return f"no command {name}"
            last = found[-1]
            assert last is not None
            command = last
    accepted = options_of(command)
    given = OPTION.findall(re.sub(r"\"[^\"]*\"|'[^']*'", "", " ".join(words)))
    unknown = [each for each in given if each not in accepted]
    return f"{command.name} has no {', '.join(unknown)}" if unknown else None


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_commands_of_pages_exist(page: Path) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    faults = [f"hwsw {each}: {why}" for each in quoted(text, blocks=page.suffix == ".md") if (why := fault(each))]
    assert faults == []


def test_pages_quote_most_commands() -> None:
    """So that a reader of pages that finds nothing is noticed."""
    text = "\n".join((ROOT / page).read_text(encoding="utf-8") for page in PAGES if page.suffix == ".md")
    found = [each.split()[0] for each in quoted(text)]
    assert len(found) > 300
    with click.Context(cli) as context:
        assert set(cli.list_commands(context)) <= set(found)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("`hwsw export`", "no command export"),
        ("see `hwsw run --tracing x` there", "run has no --tracing"),
        ("```sh\n$ hwsw trace shows a.mcap\n```", "no command shows"),
        ("```sh\nhwsw explore a b \\\n  --pints 3  # many\n```", "explore has no --pints"),
        ("    hwsw trace stats | diffs\n", "no command diffs"),
        ("`hwsw --bug`", "hwsw has no --bug"),
        ('```sh\nhwsw run a b --set x="--y" -o z | head -3 --foreign\n```', "run has no -o"),
    ],
)
def test_a_command_that_is_none_is_noticed(text: str, why: str) -> None:
    assert [fault(each) for each in quoted(text)] == [why]
