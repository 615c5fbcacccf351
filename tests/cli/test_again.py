"""A page says how to make it again in words that make it again, and shows what it cannot hold."""

from __future__ import annotations

import html
import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner
from report_samples import a_result

from codesign.cli import main
from codesign.views.report.result_page import result_html


def again(page: Path) -> str:
    found = re.search(
        r'<pre [^>]*aria-label="The command"><code>(.*?)</code></pre>', page.read_text(encoding="utf-8"), re.S
    )
    assert found
    return html.unescape(found[1])


def test_the_command_of_a_page_on_files_makes_the_same_page_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Names of specs are no paths: with them, the command would look among the shipped files."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "my files"
    begun = CliRunner().invoke(main, ["init", "my files"])
    assert begun.exit_code == 0
    typed = ["run", "my files/my-platform.yaml", "my files/my-workload.yaml"]
    assert shlex.split(begun.stdout.splitlines()[-1]) == ["next:", "hwsw", *typed]
    typed += ["--set", "relax.iterations=16", "--set", "relax.schedule=[7, 15]", "--html", "a page.html"]
    CliRunner().invoke(main, [*typed, "--json"])
    page = tmp_path / "a page.html"
    words = shlex.split(again(page))
    assert words == ["hwsw", *typed]
    first = page.read_bytes()
    page.unlink()
    CliRunner().invoke(main, words[1:])
    assert page.read_bytes() == first
    assert folder.is_dir()


def test_the_command_of_a_reproduction_names_what_was_asked_for(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    typed = ["reproduce", "breadth_first", "--quick", "--html", str(page)]
    assert CliRunner().invoke(main, typed).exit_code == 0
    assert shlex.split(again(page)) == ["hwsw", *typed]


def test_controls_are_shown_as_escapes() -> None:
    """A page with a raw NUL or escape is no HTML, and a mark of direction turns what follows."""
    shown = result_html(a_result(), command="hwsw run a\0\x1b[31m\x9b\u202e\ud800.yaml <b>")
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e\ud800]", shown.split("<main>")[1])
    assert r"a\x00\x1b[31m\x9b\u202e\ud800.yaml &lt;b&gt;" in shown
