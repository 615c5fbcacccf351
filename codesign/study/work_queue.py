"""The works that are left to compute, and what the death of a worker does to them.

Each worker has a slot. What was under way on a slot when its worker died is computed again as a whole, alone on a slot.
Where a worker dies of it again, its points are computed one by one, and a point of which a worker dies has failed.

Works that share most of what they compute go to the same worker. Each worker keeps costly answers for the works that
follow (``Memo``), and works of the same *affinity* share most of them (``Together.affinity``). The worker that began an
affinity gets its other works too, so that no other one computes the same again. The order of the works is kept, but for
this: a work whose affinity another worker has begun waits for that one, and at most ``MOST_WAITING`` works wait. Beyond
them, and at the end, a worker with nothing to do takes over works that wait for another one. The most works that wait
for it and are of one affinity, at most half of all, are taken.

Works go out in batches, sized by what works took before. To hand a work over takes a pool of processes about a
millisecond, and the scheduler of a cluster some. What a worker sends back holds priced outcomes as the block that the
store keeps (``Packing``). To write a block takes most of what keeping takes. So the workers write it, side by side.
"""

from __future__ import annotations

import time
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from codesign.ground.kernel_cache import compiled_once
from codesign.study.blocks import block_of
from codesign.study.evaluation import Done, Evaluator
from codesign.study.partition import Affinity, Alone, Work, apart
from codesign.study.shared import Parts
from codesign.study.space import Space
from codesign.study.store import Entry, EntryState

S = TypeVar("S", bound="Slot")

BATCHES_AHEAD = 2
"""The batches of each worker: one in hand, and one ahead."""

_MOST_WORKS = 1000
_GROWTH = 4


class BatchSize:
    """The number of works that take so many ``seconds``, by those that came in."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._a_work: float | None = None
        self._most = 1

    def take(self, seconds: float, works: int) -> None:
        """Learn from works that took so long. Faster ones count at once: the first ones waited for kernels."""
        a_work = seconds / max(1, works)
        before = a_work if self._a_work is None else self._a_work
        self._a_work = min(a_work, 0.7 * before + 0.3 * a_work)
        self._most = max(self._most, min(_MOST_WORKS, _GROWTH * works))

    @property
    def works(self) -> int:
        """The number of works that a batch has."""
        if self._a_work is None:
            return 1
        return max(1, min(self._most, round(self.seconds / max(self._a_work, 1e-6))))


class Slot:
    """A worker, as the queue sees it. ``name``: tells it from the others.

    ``batches``: the works under way, by what will come of them, the first ones first.
    """

    def __init__(self, name: Hashable) -> None:
        self.name = name
        self.batches: dict[Any, list[Work]] = {}

    @property
    def works(self) -> list[Work]:
        """All works under way."""
        return [work for batch in self.batches.values() for work in batch]


MOST_WAITING = 64

SOME_SEAT = ""
"""The slot of an executor that has one worker, or tells none from another."""


class Dealer:
    """Works in order, dealt to slots. Behind the last work, ``works`` is asked again with the next draw.

    An executor that tells no slots from each other may go through it: it gives the works in their order.

    Args:
        works: to come.
        late: whether so many points that were granted can be begun no more; see ``Budget.late``.
    """

    def __init__(self, works: Iterable[Work], late: Callable[[int], bool] = lambda _: False) -> None:
        self._works, self._late = iter(works), late
        self._first: deque[Work] = deque()
        self._waiting = defaultdict[Hashable, deque[Work]](deque)
        self._slot_of: dict[Affinity, Hashable] = {}

    def __iter__(self) -> Iterator[Work]:
        while (work := self.draw()) is not None:
            yield work

    def draw(self, slot: Hashable = SOME_SEAT) -> Work | None:
        """The next work for a slot; None: none for now."""
        if self._first:
            return self._first.popleft()
        if (work := self._own(slot)) is not None:
            return work
        while sum(map(len, self._waiting.values())) < MOST_WAITING:
            work = next(self._works, None)
            if work is None:
                break
            if work.affinity is None:
                return work
            owner = self._slot_of.setdefault(work.affinity, slot)
            if owner == slot:
                return work
            self._waiting[owner].append(work)
        self._take_over(slot)
        return self._own(slot)

    def put_back(self, works: Sequence[Work], slot: Hashable = SOME_SEAT) -> None:
        """Take works back: they are the next ones of the slot that began their affinity, and else of any slot."""
        for work in reversed(works):
            if work.affinity is not None and self._slot_of.get(work.affinity) == slot:
                self._waiting[slot].appendleft(work)
            else:
                self._first.appendleft(work)

    def add(self, works: Iterable[Work]) -> None:
        """Take works in the place of one that fell apart: they are next, for any slot."""
        self._first.extend(works)

    def is_empty(self) -> bool:
        """True if no work is left."""
        if not self._first and not any(self._waiting.values()):
            self._first.extend([work] if (work := next(self._works, None)) is not None else [])
        return not self._first and not any(self._waiting.values())

    def _own(self, slot: Hashable) -> Work | None:
        """The first work that waits for a slot."""
        waiting = self._waiting[slot]
        while waiting:
            work = waiting.popleft()
            if not self._late(len(work)):
                return work
        return None

    def _take_over(self, slot: Hashable) -> None:
        """Let a slot have works of one affinity that wait for another one, and the affinity too if all of them move."""
        waiting = {owner: works for owner, works in self._waiting.items() if works}
        if not waiting:
            return
        owner = max(waiting, key=lambda each: len(waiting[each]))
        theirs = waiting[owner]
        affinity, count = Counter(work.affinity for work in theirs).most_common(1)[0]
        most = (len(theirs) + 1) // 2
        moved = [work for work in theirs if work.affinity == affinity][-most:]
        if affinity is not None and len(moved) == count:
            self._slot_of[affinity] = slot
        taken = set(map(id, moved))
        self._waiting[owner] = deque(work for work in theirs if id(work) not in taken)
        self._waiting[slot].extend(moved)


DEATH_HINT = (
    "use fewer workers if memory ran out (SIGKILL); in a script, explore below `if __name__ == '__main__':`, as workers"
    " import it"
)


class WorkQueue:
    """The works to come: those under suspicion first, each alone; then the others, as ``Dealer`` deals them.

    - ``space``: of the points. ``workers``: how many compute; points that are simulated by themselves are dealt out to
      so many. ``seconds``: how long a batch is to take.
    - ``suspects``: works that were under way when a worker died.
    """

    def __init__(self, works: Iterable[Work], space: Space, workers: int, seconds: float = 0.0) -> None:
        self.workers, self.size = workers, BatchSize(seconds)
        self.suspects: deque[Work] = deque()
        self._dealer = works if isinstance(works, Dealer) else Dealer(works)
        self._space = space
        self._trials: list[Work] = []

    def next(self, busy: Sequence[Work], slot: Hashable = SOME_SEAT) -> Work | None:
        """The next work for a slot on which ``busy`` is under way; None: none for now."""
        if any(map(self.on_trial, busy)) or (self.suspects and busy):
            return None
        if self.suspects:
            self._trials.append(self.suspects.popleft())
            return self._trials[-1]
        return self._dealer.draw(slot)

    def hand_out(self, slots: Sequence[S], send: Callable[[S, list[Work]], None], *, one_by_one: bool = False) -> None:
        """Give each worker a batch, and then each a second one; or each one work at a time."""
        for depth in range(1 if one_by_one else BATCHES_AHEAD):
            for slot in [*slots]:
                if len(slot.batches) > depth:
                    continue
                batch: list[Work] = []
                most = 1 if one_by_one else self.size.works
                while len(batch) < most and (work := self.next([*slot.works, *batch], slot.name)) is not None:
                    batch.append(work)
                if batch:
                    send(slot, batch)

    def came(self, slot: Slot, works: Sequence[Work], done: Sequence[Done], seconds: float) -> list[Done]:
        """The outcomes of the first works of a batch, with these works again; the others are next. For ``take``."""
        self.size.take(seconds, len(done))
        self.put_back(works[len(done) :], slot.name)
        return [replace(each, work=work) for work, each in zip(works, done, strict=False)]

    def on_trial(self, work: Work) -> bool:
        """True if a work is computed alone, as a worker died while it was under way before."""
        return any(work is trial for trial in self._trials)

    def is_empty(self) -> bool:
        """True if no work is left that is not under way."""
        return not self.suspects and self._dealer.is_empty()

    def take(self, done: Done) -> Iterator[Done]:
        """Give what came in, or put its points into the queue where they are to be computed apart."""
        self._ended(done.work)
        if done.apart:
            self._dealer.add(apart(self._space, done.work, self.workers))
        else:
            yield done

    def put_back(self, works: Sequence[Work], slot: Hashable = SOME_SEAT) -> None:
        """Take back works that nothing came of on a slot, through no fault of theirs: they are next."""
        tried = [work for work in works if self._ended(work)]
        self.suspects.extendleft(reversed(tried))
        self._dealer.put_back([work for work in works if not any(work is each for each in tried)], slot)

    def after_death(self, works: Iterable[Work], cause: str) -> Iterator[Done]:
        """The outcomes of works on a slot that died and so failed; the others are under suspicion.

        ``cause``: how it died, such as `` by SIGKILL``; "" where it is not known.
        """
        for work in works:
            if not self._ended(work):
                self.suspects.append(work)
                continue
            points = tuple(work.points_of(self._space))
            if len(points) > 1:
                self.suspects.extendleft(Alone((point,)) for point in reversed(points))
                continue
            message = f"a worker process died{cause} twice while it computed this point"
            entries = tuple(Entry(point.key, EntryState.FAILED, f"{message}\n  hint: {DEATH_HINT}") for point in points)
            yield Done(Alone(points), entries=entries)

    def _ended(self, work: Work) -> bool:
        """End the trial of a work; True if it was on trial."""
        before = len(self._trials)
        self._trials = [trial for trial in self._trials if trial is not work]
        return len(self._trials) < before


class Packing:
    """Computes batches of works, and packs what comes of them; the sender of the works adds them again."""

    def __init__(self, evaluate: Evaluator) -> None:
        self._evaluate = evaluate
        self._parts = Parts()

    def __call__(self, works: Sequence[Work], seconds: float) -> tuple[list[Done], float]:
        """The outcomes of the first works, packed, and the seconds that it took; see ``Evaluator.batch``."""
        begun = time.monotonic()
        came, _ = self._evaluate.batch(works, seconds, compiled_once)
        return [self._packed(done) for done in came], time.monotonic() - begun

    def _packed(self, done: Done) -> Done:
        block = b"" if done.priced is None else block_of(done.priced, self._parts)[0]
        return replace(done, work=Alone(()), priced=None, block=block)
