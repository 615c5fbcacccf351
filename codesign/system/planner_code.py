"""The code of a planner, which any package may bring: its failures are named after it."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from codesign.ground.errors import CodesignError, RunError
from codesign.planners.interface import Planner
from codesign.planners.styles import Step


@contextmanager
def planner_code(planner: Planner) -> Iterator[None]:
    """Around the code of a planner, which any package may bring.

    Raises:
        RunError: the code raised an error that is not of this package; named with the planner.
    """
    try:
        yield
    except CodesignError:
        raise
    except Exception as failed:
        text = " ".join(f"{type(failed).__name__}: {failed}".split())[:200]
        raise RunError(f"planner {planner.name} failed: {text}", planner.name) from failed


def planner_steps(planner: Planner, steps: Iterable[Step]) -> Generator[Step, None, Any]:
    """The steps of a planner's style, with failures of its code named after it."""
    source = iter(steps)
    while True:
        with planner_code(planner):
            try:
                step = next(source)
            except StopIteration as done:
                return done.value
        yield step
