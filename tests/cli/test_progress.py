"""Progress on a terminal that shows plain lines."""

from __future__ import annotations

import pytest


def test_progress_is_told_by_time_too(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from codesign.cli import progress

    clock = [1000.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    lines = progress.PlainLines()
    for done, now in ((0, 1000.0), (1, 1001.0), (2, 1011.0), (3, 1012.0)):
        clock[0] = now
        lines(progress.Advance(done, 1000, "points"))
    assert [line.split()[0] for line in capsys.readouterr().err.splitlines()] == ["0/1000", "2/1000"]
