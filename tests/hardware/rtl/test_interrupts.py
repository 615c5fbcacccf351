"""Tools end with the command that started them, however it ends, and so does what they started themselves."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from processes import gone

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of a terminal")

BOUND_S = 300

BEGIN = """
import os, signal, subprocess, sys
from pathlib import Path
from codesign.ground import interrupts
from codesign.hardware.rtl.tools import run

# A job in the background may have been told to ignore them.
for number in interrupts.SIGNALS:
    signal.signal(number, signal.SIG_DFL)
interrupts.end_on_signals()
"""

SCRIPT = f"""{BEGIN}
work = "echo $$ > child; sleep 600 & echo $! > grandchild; touch begun; wait"
try:
    run(("sh", "-c", work), Path.cwd(), seconds=600)
except KeyboardInterrupt as struck:
    sys.exit(struck.exit_code)
"""


STARTING = f"""{BEGIN}
class Struck(subprocess.Popen):
    def __init__(self, *words, **options):
        super().__init__(*words, **options)
        Path("child").write_text(str(self.pid))
        os.kill(os.getpid(), int(sys.argv[1]))

subprocess.Popen = Struck
try:
    run(("sleep", "600"), Path.cwd(), seconds=600)
except KeyboardInterrupt as struck:
    sys.exit(struck.exit_code)
"""
"""A signal arrives between the start of the tool and the return of the call that starts it."""

CODES = {signal.SIGINT: 130, signal.SIGTERM: 143}
if sys.platform != "win32":
    CODES[signal.SIGHUP] = 143


@pytest.mark.parametrize(("number", "code"), CODES.items())
def test_a_tool_that_is_being_started_ends_with_the_command(tmp_path: Path, number: signal.Signals, code: int) -> None:
    words = [sys.executable, "-c", STARTING, str(int(number))]
    assert subprocess.run(words, cwd=tmp_path, timeout=BOUND_S, check=False).returncode == code
    pid = int((tmp_path / "child").read_text(encoding="utf-8"))
    ended = gone(pid)
    if not ended:
        os.kill(pid, signal.SIGKILL)
    assert ended


@pytest.mark.parametrize(("number", "code"), [*CODES.items(), (signal.SIGKILL, -9)])
def test_tools_end_with_the_command(tmp_path: Path, number: signal.Signals, code: int) -> None:
    with subprocess.Popen([sys.executable, "-c", SCRIPT], cwd=tmp_path) as process:
        try:
            wait_for((tmp_path / "begun").exists)
            process.send_signal(number)
            assert process.wait(BOUND_S) == code
        finally:
            process.kill()
    for name in ("child", "grandchild"):
        pid = int((tmp_path / name).read_text(encoding="utf-8"))
        wait_for(lambda pid=pid: gone(pid))


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait until a condition holds."""
    end = time.monotonic() + BOUND_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_a_tool_that_takes_too_long_is_ended(tmp_path: Path) -> None:
    from codesign.ground.errors import RunError
    from codesign.hardware.rtl.tools import run

    with pytest.raises(RunError, match=r"sh did not end within 0.2 s"):
        run(("sh", "-c", "echo $$ > child; sleep 600"), tmp_path, seconds=0.2)
    child = tmp_path / "child"
    if child.exists() and child.read_text(encoding="utf-8"):
        assert gone(int(child.read_text(encoding="utf-8")))
