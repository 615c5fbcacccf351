"""Progress on a terminal that shows plain lines."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click
import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from codesign.ground.errors import InputError

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
    from codesign.ground import kernel_cache

    @contextmanager
    def begins(report: Callable[[int], None]) -> Iterator[None]:
        report(0)
        raise InputError("stopped", "kernel")
        yield

    monkeypatch.setattr(kernel_cache, "compiling_reported", begins)
    assert hwsw(*command.split()).stderr.splitlines()[0] == "compiling kernels, once: about 20 s"


@given(
    st.lists(
        st.tuples(st.floats(0, 8), st.sampled_from(["points", "rows", "levers run, a"]), st.booleans(), st.booleans()),
        max_size=200,
    ),
    st.sampled_from([0.0, 2.0, 5.0]),
)
def test_a_pipe_gets_a_line_each_ten_seconds_at_most(
    steps: list[tuple[float, str, bool, bool]], after_s: float
) -> None:
    """However much is told: phases that follow one another, tenths, what is counted and what is not."""
    from codesign.cli import progress
    from codesign.ground.progress import Advance

    clock, said = [1000.0], list[float]()
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(progress.time, "monotonic", lambda: clock[0])
        patched.setattr(progress.click, "echo", lambda *_, **__: said.append(clock[0]))
        lines = progress.PlainLines(after_s)
        told = []
        for number, (wait, words, counted, brief) in enumerate(steps):
            clock[0] += wait
            lines(Advance(number, len(steps) if counted else None, words, brief=brief))
            told += [] if brief else [clock[0]]
    assert all(later - sooner >= 10 for sooner, later in itertools.pairwise(said))
    assert all(moment >= 1000 + after_s for moment in said)
    for moment in told:
        # Silence of ten seconds ends with the next thing that is told.
        assert moment < 1000 + after_s or any(moment - 10 <= each <= moment for each in said)


def test_compiling_is_announced_once_in_a_command() -> None:
    """In whatever phases, displays and turns with other progress it is reported."""
    from codesign.cli import progress
    from codesign.ground.progress import Advance

    @click.group()
    def group() -> None:
        """One command."""

    @group.command()
    def work() -> None:
        for _ in range(3):
            with progress.progress_shown() as show:
                for done in range(3):
                    show(progress.compiling(done))
                    show(Advance(done, 3, "points"))

    for _ in range(2):
        assert CliRunner().invoke(group, ["work"]).stderr == f"{progress.COMPILING}\n"


def test_work_of_unknown_length_is_announced_once_and_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    from codesign.cli import progress
    from codesign.ground.progress import Advance

    lines = progress.PlainLines(after_s=1000.0)
    for compiled in range(3):
        lines(progress.compiling(compiled))
    lines(Advance(1, 2, "points"))
    assert capsys.readouterr().err == "compiling kernels, once: about 20 s\n"


def test_quiet_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    from codesign.cli import progress
    from codesign.ground.progress import Advance

    with progress.progress_shown(quiet=True) as show:
        show(Advance(0, None, progress.COMPILING))
        show(Advance(2, 2, "points"))
    assert capsys.readouterr().err == ""


def test_lines_have_the_count_and_the_time_left(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from codesign.cli import progress
    from codesign.ground.progress import Advance

    clock = [1000.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    lines = progress.PlainLines()
    for advance in (
        Advance(100, 100, "points read", 0.0),
        Advance(7, 70, "rows written", 4000.0),
        Advance(8, 70, "bits at most"),
        Advance(0, None, "maps drawn"),
    ):
        lines(advance)
        clock[0] += 10.0
    assert capsys.readouterr().err.splitlines() == [
        "100/100 points read, 0 s left",
        "7/70 rows written, 1 h 6 min left",
        "8/70 bits at most",
        "maps drawn",
    ]


def test_of_a_bound_no_time_left_is_told() -> None:
    """A drive or a plan ends long before the most that it could take: a rate says nothing then."""
    from codesign.cli.run import mission_progress
    from codesign.ground.progress import Advance, plan_track, plans_shown
    from codesign.system.scenario import MissionProgress

    shown: list[Advance] = []
    with plans_shown(shown.append), pytest.MonkeyPatch.context() as patched:
        patched.setattr("codesign.ground.progress._SECONDS_BETWEEN", 0.0)
        track = plan_track("bits of all stages", 100)
        for _ in range(5):
            track.step(10)
    mission = mission_progress(shown.append)
    for turns in (1, 50):
        mission(MissionProgress(time=turns * 10**11, limit=10**16, events=turns, most_events=10**6, turns=turns))
    assert len(shown) > 5
    assert {advance.left_s for advance in shown} == {None}


def test_the_time_left_follows_the_recent_pace() -> None:
    from codesign.ground.progress import Pace

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
    from codesign.ground.progress import Advance, tracked

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
    from codesign.ground import progress

    monkeypatch.setattr(progress, "_SECONDS_BETWEEN", 0.0)
    shown: list[progress.Advance] = []
    with progress.plans_shown(shown.append):
        result = codesign.simulate("virtex4-pci", "labyrinth")
    stages = [stage.precision for stage in result.stages]
    assert [advance.done for advance in shown] == [sum(stages[:count]) for count in range(len(stages) + 1)]
    assert {(advance.total, advance.words) for advance in shown} == {(sum(stages), "bits of all stages")}
    codesign.simulate("virtex4-pci", "labyrinth")
    assert len(shown) == len(stages) + 1
