"""The gallery: its commands are commands, its pictures are there and small, and the commands make the pictures."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import click
import pytest
from browser import needs_browser
from PIL import Image
from places import ROOT

from codesign.cli import main
from docs.make_gallery import MOST_BYTES, PAGE, WIDEST, Shown, gallery, kept, run_commands, small

TEXT = PAGE.read_text(encoding="utf-8")
PICTURES = gallery(TEXT)
COMMANDS = list(dict.fromkeys(each for picture in PICTURES for each in picture.commands))


def test_each_picture_has_its_commands() -> None:
    assert len(PICTURES) == TEXT.count("![") == TEXT.count("```sh") >= 15
    assert len({picture.file for picture in PICTURES}) == len(PICTURES)
    assert all(len(picture.alt) > 20 for picture in PICTURES)


def test_every_kind_of_plot_is_shown() -> None:
    group = main.get_command(click.Context(main), "plot")
    assert isinstance(group, click.Group)
    assert set(group.commands) == {found for found in re.findall(r"^hwsw plot (\w+)", TEXT, re.MULTILINE)}


def parsed(arguments: list[str]) -> click.Context:
    """The innermost command of a line with its options, as click understands them."""
    context = main.make_context("hwsw", arguments)
    while isinstance(context.command, click.Group):
        rest = [*context._protected_args, *context.args]
        name, command, rest = context.command.resolve_command(context, rest)
        assert command is not None
        context = command.make_context(name, rest, parent=context)
    return context


@pytest.mark.parametrize("command", [each for each in COMMANDS if each.startswith("hwsw ")])
def test_a_command_of_the_page_is_one(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for line in COMMANDS[: COMMANDS.index(command)]:
        for written in re.findall(r"(?:--store|--trace) (\S+)", line):
            (tmp_path / written).touch()
    assert parsed(shlex.split(command)[1:]).params


def test_what_is_no_command_is_refused() -> None:
    with pytest.raises(click.UsageError):
        parsed(["plot", "front", "--never", "x"])


@pytest.mark.parametrize("picture", PICTURES, ids=lambda picture: picture.file)
def test_the_picture_is_there_and_small(picture: Shown) -> None:
    file = PAGE.parent / picture.file
    assert file.stat().st_size <= (MOST_BYTES if file.suffix == ".png" else 4 * MOST_BYTES)
    if file.suffix == ".png":
        with Image.open(file) as image:
            assert image.width <= WIDEST + 200
            assert not picture.own or image.mode == "P"


def test_all_pictures_together_are_small_and_shown_somewhere() -> None:
    pages = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs").glob("*.md"))
    files = sorted((PAGE.parent / "pictures").iterdir())
    assert sum(file.stat().st_size for file in files) <= 1_500_000
    assert [file.name for file in files if f"pictures/{file.name}" not in pages] == []


def test_a_picture_of_a_paper_keeps_its_colours() -> None:
    import io

    image = Image.effect_noise((400, 300), 80).convert("RGB")
    image.paste((26, 152, 80), (10, 10, 13, 13))
    out = io.BytesIO()
    image.save(out, "png")
    with Image.open(io.BytesIO(small(out.getvalue()))) as quantised:
        red, green, blue = quantised.convert("RGB").getpixel((11, 11))
    assert abs(red - 26) + abs(green - 152) + abs(blue - 80) < 12


@pytest.mark.slow
def test_the_commands_make_the_pictures(tmp_path: Path) -> None:
    needs_browser()
    own = [picture for picture in PICTURES if picture.own]
    run_commands(own, tmp_path)
    names = []
    for name, data in kept(own, tmp_path):
        names.append(name)
        assert len(data) <= MOST_BYTES, name
    assert names == [Path(picture.file).name for picture in own]
