"""The works that are left to compute, and what the death of a worker does to them.

Each worker has a seat. What was under way on a seat when its worker died is computed again as a whole, alone on a seat.
Where a worker dies of it again, its points are computed one by one, and a point of which a worker dies has failed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Iterable, Iterator, Sequence

from codesign.exploration.dealing import SOME_SEAT, Dealer
from codesign.exploration.evaluation import Done, Evaluator
from codesign.exploration.partition import Alone, Work
from codesign.exploration.store import Entry, EntryState

DEATH_HINT = (
    "use fewer workers if memory ran out (SIGKILL); in a script, explore below `if __name__ == '__main__':`, as workers"
    " import it"
)


class WorkQueue:
    """The works to come: those under suspicion first, each alone; then the others, as ``Dealer`` deals them.

    - ``workers``: how many compute; points that are simulated by themselves are dealt out to so many.
    - ``suspects``: works that were under way when a worker died.
    """

    def __init__(self, works: Iterable[Work], evaluate: Evaluator, workers: int) -> None:
        self.workers = workers
        self.suspects: deque[Work] = deque()
        self._dealer = works if isinstance(works, Dealer) else Dealer(works)
        self._evaluate = evaluate
        self._trials: list[Work] = []

    def next(self, busy: Sequence[Work], seat: Hashable = SOME_SEAT) -> Work | None:
        """The next work for a seat on which ``busy`` is under way; None: none for now."""
        if any(map(self.on_trial, busy)) or (self.suspects and busy):
            return None
        if self.suspects:
            self._trials.append(self.suspects.popleft())
            return self._trials[-1]
        return self._dealer.draw(seat)

    def on_trial(self, work: Work) -> bool:
        """Whether a work is computed alone, as a worker died while it was under way before."""
        return any(work is trial for trial in self._trials)

    def is_empty(self) -> bool:
        """Whether no work is left that is not under way."""
        return not self.suspects and self._dealer.is_empty()

    def take(self, done: Done) -> Iterator[Done]:
        """Give what came in, or put its points into the queue where they are to be computed apart."""
        self._ended(done.work)
        if done.apart:
            self._dealer.add(self._evaluate.alone(done.work, self.workers))
        else:
            yield done

    def put_back(self, works: Sequence[Work], seat: Hashable = SOME_SEAT) -> None:
        """Take back works that nothing came of on a seat, through no fault of theirs: they are next."""
        tried = [work for work in works if self._ended(work)]
        self.suspects.extendleft(reversed(tried))
        self._dealer.put_back([work for work in works if not any(work is each for each in tried)], seat)

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
