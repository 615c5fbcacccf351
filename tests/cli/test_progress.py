"""Progress on a terminal that shows plain lines."""

from __future__ import annotations

import pytest


def test_progress_is_told_by_time_too(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from codesign.cli import progress
    from codesign.progress import Advance

    clock = [1000.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    lines = progress.PlainLines()
    for done, now in ((0, 1000.0), (1, 1001.0), (2, 1011.0), (3, 1012.0)):
        clock[0] = now
        lines(Advance(done, 1000, "points"))
    assert [line.split()[0] for line in capsys.readouterr().err.splitlines()] == ["0/1000", "2/1000"]


def test_work_of_unknown_length_is_announced_once_and_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    from codesign.cli import progress
    from codesign.progress import Advance

    lines = progress.PlainLines(after_s=1000.0)
    for compiled in range(3):
        lines(Advance(compiled, None, progress.COMPILING))
    lines(Advance(1, 2, "points"))
    assert capsys.readouterr().err == "compiling kernels, once: about 20 s\n"


def test_quiet_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    from codesign.cli import progress
    from codesign.progress import Advance

    with progress.progress_shown(quiet=True) as show:
        show(Advance(0, None, progress.COMPILING))
        show(Advance(2, 2, "points"))
    assert capsys.readouterr().err == ""
