"""An option of a command is one field of its request: its help, its page and what is asked follow."""

from __future__ import annotations

from pathlib import Path

from recipes import Recipe

ASKED = """
import click
from codesign.cli import main
from codesign.cli.request import command_of, fields_of
from codesign.cli.requests import COMMANDS, Show
from docs.make_reference.python_pages import commands_page
command = command_of("show", COMMANDS)
context = command.make_context("show", ["labyrinth", "--times", "3"])
print(context.params["times"], command.make_context("show", ["labyrinth"]).params["times"], Show(name="a").times)
print("Print it so often." in command.get_help(context), any("`--times`" in line for line in commands_page()))
"""


def test_a_new_option_is_one_field(tmp_path: Path) -> None:
    recipe = Recipe(tmp_path, "a CLI option")
    field = '    times: int = option("Print it so often.", default=2)\n'
    recipe.edit("cli/requests.py", ("    path_only: bool", field))
    assert recipe.python("-c", ASKED).split() == ["3", "2", "2", "True", "True"]
