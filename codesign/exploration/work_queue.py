"""The works that are left to compute, and what the death of a worker does to them.

Workers stand on seats. What stands on a seat dies together: the whole pool of local processes is one seat, and each
worker of a cluster is one. What was under way on a seat when it died is computed again as a whole, alone on its seat.
Where the seat dies of it again, its points are computed one by one, and a point of which a worker dies has failed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence

from codesign.exploration.evaluation import Done, Evaluator
from codesign.exploration.partition import Alone, Work
from codesign.exploration.store import Entry, EntryState

DEATH_HINT = (
    "use fewer workers if memory ran out (SIGKILL); in a script, explore below `if __name__ == '__main__':`, as workers"
    " import it"
)


class WorkQueue:
    """The works to come: those under suspicion first, each alone on its seat; then those that were put back or parted.

    - ``workers``: how many compute; points that are simulated by themselves are dealt out to so many.
    - ``suspects``: works that were under way when a worker died.
    - ``compiled``: a plan was computed before.
    """

    def __init__(self, works: Iterator[Work], evaluate: Evaluator, workers: int) -> None:
        self.workers = workers
        self.suspects: deque[Work] = deque()
        self.compiled = False
        self._works, self._evaluate = works, evaluate
        self._first: deque[Work] = deque()
        self._trials: list[Work] = []

    def next(self, busy: Sequence[Work]) -> Work | None:
        """The next work for a seat on which ``busy`` is under way; None: none for now."""
        if any(map(self.on_trial, busy)) or (self.suspects and busy):
            return None
        if self.suspects:
            self._trials.append(self.suspects.popleft())
            return self._trials[-1]
        return self._first.popleft() if self._first else next(self._works, None)

    def on_trial(self, work: Work) -> bool:
        """Whether a work is computed alone, as a worker died while it was under way before."""
        return any(work is trial for trial in self._trials)

    def is_empty(self) -> bool:
        """Whether no work is left that is not under way."""
        if not self.suspects and not self._first:
            self._first.extend([work] if (work := next(self._works, None)) is not None else [])
        return not self.suspects and not self._first

    def take(self, done: Done) -> Iterator[Done]:
        """Give what came in, or put its points into the queue where they are to be computed apart."""
        self._ended(done.work)
        self.compiled = self.compiled or done.ran
        if done.apart:
            self._first.extend(self._evaluate.alone(done.work, self.workers))
        else:
            yield done

    def put_back(self, works: Sequence[Work]) -> None:
        """Take back works of which nothing came, through no fault of theirs: they are next."""
        for work in reversed(works):
            (self.suspects if self._ended(work) else self._first).appendleft(work)

    def after_death(self, works: Iterable[Work], cause: str) -> Iterator[Done]:
        """What has failed of the works on a seat that died; the others are under suspicion.

        ``cause``: how it died, such as `` by SIGKILL``; "" where it is not known.
        """
        for work in works:
            if not self._ended(work):
                self.suspects.append(work)
                continue
            points = tuple(self._evaluate.points(work))
            if len(points) > 1:
                self.suspects.extendleft(Alone((point,)) for point in reversed(points))
                continue
            message = f"a worker process died{cause} twice while it computed this point"
            entries = tuple(
                Entry(point.key, EntryState.FAILED, f"{message}\n  hint: {DEATH_HINT}") for point in points
            )
            yield Done(Alone(points), entries=entries)

    def _ended(self, work: Work) -> bool:
        """End the trial of a work; whether it was on trial."""
        before = len(self._trials)
        self._trials = [trial for trial in self._trials if trial is not work]
        return len(self._trials) < before
