"""Progress on a terminal that shows plain lines."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from click.testing import Result

from codesign.errors import InputError

COMPUTING = [
    "run virtex2pro breadth-first",
    "run zynq office-harmonic --no-levers",
    "run nexys2-serial robots-8-fleet",
    "advise house --goal 0.0,-0.5 --rate 10Hz",
    "explore virtex4-pci labyrinth",
    "explain virtex2pro breadth-first",
    "compare virtex2pro:breadth-first",
    "plot map virtex2pro breadth-first -o map.png",
    "verify virtex2pro breadth-first",
    "verify --all --points 1",
    "rtl virtex2pro breadth-first -o circuit",
    "synth virtex2pro breadth-first",
    "fidelity --quick",
    "reproduce wavefront --quick",
    "calibrate host",
]


@pytest.mark.parametrize("command", COMPUTING)
def test_each_command_that_computes_says_when_kernels_are_compiled(
    hwsw: Callable[..., Result], monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """A kernel begins to compile, and the command is stopped there: nothing is computed."""
    from codesign import kernel_cache

    @contextmanager
    def begins(report: Callable[[int], None]) -> Iterator[None]:
        report(0)
        raise InputError("stopped", "kernel")
        yield

    monkeypatch.setattr(kernel_cache, "compiling_reported", begins)
    assert hwsw(*command.split()).stderr.splitlines()[0] == "compiling kernels, once: about 20 s"


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
        lines(progress.compiling(compiled))
    lines(Advance(1, 2, "points"))
    assert capsys.readouterr().err == "compiling kernels, once: about 20 s\n"


def test_quiet_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    from codesign.cli import progress
    from codesign.progress import Advance

    with progress.progress_shown(quiet=True) as show:
        show(Advance(0, None, progress.COMPILING))
        show(Advance(2, 2, "points"))
    assert capsys.readouterr().err == ""


def test_a_line_begins_anew_with_each_phase(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from codesign.cli import progress
    from codesign.progress import Advance, doing

    clock = [1000.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    lines = progress.PlainLines()
    lines(Advance(100, 100, "points read", 0.0))
    doing(lines, "comparing designs")
    clock[0] += 1.0
    lines(Advance(0, 70, "rows written"))
    lines(Advance(7, 70, "rows written", 4000.0))
    assert capsys.readouterr().err.splitlines() == [
        "100/100 points read, 0 s left",
        "0/70 rows written",
        "7/70 rows written, 1 h 6 min left",
    ]


def test_lines_wait_until_a_command_takes_long(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from codesign.cli import progress
    from codesign.progress import tracked

    clock = [1000.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    lines = progress.PlainLines(progress.LATER_S)
    for _ in tracked(range(10), lines, "rows", 10, clock=lambda: clock[0]):
        clock[0] += 0.5
    said = capsys.readouterr().err.splitlines()
    assert said[0].startswith("4/10 rows, 3 s left")
    assert said[-1] == "10/10 rows, 0 s left"


def test_the_time_left_follows_the_recent_pace() -> None:
    from codesign.progress import Pace

    now = 0.0
    pace = Pace(1000, lambda: now)
    assert pace.left_s(0) is None
    for done in range(1, 500):
        now += 1.0
        left = pace.left_s(done)
        assert left == pytest.approx(1000 - done)
    for done in range(500, 600):
        now += 10.0
        left = pace.left_s(done)
    assert left == pytest.approx(10 * (1000 - 599))


def test_tracked_counts_what_is_done_and_gives_every_item() -> None:
    from codesign.progress import Advance, tracked

    now, shown = 0.0, list[Advance]()

    def clock() -> float:
        return now

    items = tracked(["ab", "c", "def"], shown.append, "letters", 6, size=len, clock=clock)
    for number, item in enumerate(items):
        assert shown[-1].done == (0, 2, 3)[number]
        assert item in {"ab", "c", "def"}
        now += len(item)
    assert [(each.done, each.total, each.left_s) for each in shown] == [
        (0, 6, None),
        (2, 6, 4.0),
        (3, 6, 3.0),
        (6, 6, 0.0),
        (6, 6, 0.0),
    ]


def test_a_plan_reports_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    import codesign
    from codesign import progress

    monkeypatch.setattr(progress, "_SECONDS_BETWEEN", 0.0)
    shown: list[progress.Advance] = []
    with progress.plans_shown(shown.append):
        result = codesign.simulate("virtex4-pci", "labyrinth")
    stages = [stage.precision for stage in result.stages]
    assert [advance.done for advance in shown] == [sum(stages[:count]) for count in range(len(stages) + 1)]
    assert {(advance.total, advance.words) for advance in shown} == {(sum(stages), "bits of all stages")}
    assert shown[-1].left_s == 0.0
    codesign.simulate("virtex4-pci", "labyrinth")
    assert len(shown) == len(stages) + 1
