"""The bar of progress on a terminal: a pseudo terminal as standard error of the real command."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

import pytest

pty = pytest.importorskip("pty", reason="pseudo terminals are of POSIX")

HIDE, SHOW = "\x1b[?25l", "\x1b[?25h"

SLOW = """
import sys, time
from codesign.ground import interrupts
from codesign.__main__ import main
import codesign.cli
import codesign.cli.progress
from codesign.cli.progress import progress_shown
from codesign.ground.progress import tracked

import click

@click.command()
@click.argument("how")
def slow(how):
    # Its end comes before the bar is due, however busy the machine is.
    codesign.cli.progress._BAR_AFTER_S = 1e6 if how == "brief" else 1.0
    with progress_shown(quiet=how == "quiet") as show:
        for number in tracked(range(40), show, "things done", 40):
            if how == "brief":
                time.sleep(0.001)
            elif how == "kernel" and number == 5:
                while True:
                    try:
                        time.sleep(0.01)
                    except BaseException:
                        pass
            else:
                time.sleep(0.06)
    click.echo("the answer")

codesign.cli.main.add_command(slow)
sys.argv = ["hwsw", "slow", *sys.argv[1:]]
main()
"""


@dataclass
class Ran:
    code: int
    out: str
    terminal: str


HANGS_S = 300
"""A command that ends only then hangs. No test that passes waits for it."""


def on_terminal(how: Sequence[str], interrupt_at: str | None = None) -> Ran:
    """Run the slow command with a terminal as its standard error; Ctrl-C once it shows ``interrupt_at``."""
    ours, its = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "100"}
    with subprocess.Popen(
        [sys.executable, "-c", SLOW, *how], stdout=subprocess.PIPE, stderr=its, env=environment
    ) as process:
        os.close(its)
        terminal, until = "", time.monotonic() + HANGS_S
        while time.monotonic() < until:
            if select.select([ours], [], [], 0.1)[0]:
                try:
                    data = os.read(ours, 65536)
                except OSError:
                    break
                if not data:
                    break
                terminal += data.decode()
            if interrupt_at is not None and interrupt_at in terminal:
                process.send_signal(signal.SIGINT)
                interrupt_at = None
        if time.monotonic() >= until:
            process.kill()
        assert process.stdout is not None
        out = process.stdout.read().decode()
    os.close(ours)
    return Ran(process.returncode, out, terminal)


def test_a_bar_shows_what_is_done_and_the_time_left_and_leaves_nothing() -> None:
    ran = on_terminal(["long"])
    assert ran.out == "the answer\n"
    assert ran.code == 0
    assert "things done" in ran.terminal
    assert re.search(r"\d+/40", ran.terminal)
    assert re.search(r"\d s left", ran.terminal)
    assert ran.terminal.rindex(SHOW) > ran.terminal.rindex(HIDE)
    # The line is erased: the last thing that is written.
    assert ran.terminal.endswith("\x1b[2K")


@pytest.mark.parametrize("how", ["brief", "quiet"])
def test_a_brief_or_quiet_command_writes_nothing(how: str) -> None:
    assert on_terminal([how]) == Ran(0, "the answer\n", "")


@pytest.mark.parametrize("how", ["long", "kernel"])
def test_ctrl_c_leaves_the_terminal_clean(how: str) -> None:
    """At once, and where the main thread does not answer, so that the watcher of signals ends the process."""
    ran = on_terminal([how], interrupt_at="/40")
    assert ran.code == 130
    assert ran.out == ""
    assert ran.terminal.rindex(SHOW) > ran.terminal.rindex(HIDE)
    last = ran.terminal[ran.terminal.rindex("things done") :]
    assert last.index("\x1b[2K") < last.index("interrupted")
    assert last.endswith("interrupted\r\n")
