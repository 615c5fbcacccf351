"""docs/questions.md: every question is asked, and answered with the sentences and the command of the page."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from places import ROOT

from codesign.ground.errors import EXIT_NO

Run = Callable[..., Result]

PAGE = (ROOT / "docs" / "questions.md").read_text(encoding="utf-8")
QUESTIONS: list[tuple[str, str]] = re.findall(r"^```console\n\$ hwsw (.*?)\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
(GENERATOR,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


@pytest.fixture(autouse=True)
def places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cache of its own, and a folder with the map of the page."""
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("COLUMNS", "160")
    monkeypatch.chdir(tmp_path)
    exec(GENERATOR, {})


def assert_answered(hwsw: Run, command: str, shown: str) -> None:
    result = hwsw(*shlex.split(command))
    question, verdict, *rest = shown.splitlines()
    assert result.stdout.splitlines()[:2] == [question, verdict]
    assert result.exit_code == (0 if rest else EXIT_NO), result.output
    if rest:
        assert rest == ["...", result.stdout.splitlines()[-1]]


@pytest.mark.slow
def test_the_questions_have_the_answers_of_the_page(hwsw: Run) -> None:
    """One cache: only the first question on a map is costly. Each has a certificate that is accepted, and its page."""
    assert len(QUESTIONS) >= 12
    for command, shown in QUESTIONS:
        assert_answered(hwsw, command, shown)
        hwsw(*shlex.split(command), "--certify", "answer.cert", "--html", "answer.html", "--force")
        checked = hwsw("verify-advice", "answer.cert")
        assert checked.exit_code == 0, (command, checked.output)
        assert "<svg" in Path("answer.html").read_text(encoding="utf-8")


def test_the_first_question_among_three_boards(hwsw: Run) -> None:
    """The winner of the page is the winner among some of its boards, with the same sentence."""
    command, shown = QUESTIONS[0]
    assert_answered(hwsw, f"{command} --boards pico,pico-2,raspberry-pi-4,pynq-z2", shown)


def test_the_memory_of_a_microcontroller_excludes_it(hwsw: Run) -> None:
    command, shown = next((command, shown) for command, shown in QUESTIONS if "detour" in command)
    result = hwsw(*shlex.split(command), "--boards", "teensy-4-1")
    assert result.exit_code == EXIT_NO
    pattern = r"memory of the processor: .*? against .*?bytes"
    found = re.findall(pattern, result.stdout.splitlines()[1])
    assert found
    assert set(found) <= set(re.findall(pattern, shown))


def test_every_answer_says_why() -> None:
    sections = PAGE.split("\n## ")[1:]
    assert len(sections) == len(QUESTIONS)
    assert all("**Why" in section for section in sections)
