"""Which worker gets which work: works that share most of what they compute go to the same one.

Each worker keeps costly answers for the works that follow (``Memo``). Works of the same *kin* share most of them
(``Together.kin``). The worker that began a kin gets its other works too, so that no other one computes the same again.

The order of the works is kept, but for this: a work whose kin another worker has begun waits for that one, and at most
``MOST_WAITING`` works wait. Beyond them, and at the end, a worker with nothing to do takes over works that wait for
another one. The most works that wait for it and are of one kin, at most half of all, are taken.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence

from codesign.exploration.partition import Kin, Together, Work

MOST_WAITING = 64

SOME_SEAT = ""
"""The seat of an executor that has one worker, or tells none from another."""


class Dealer:
    """Works in order, dealt to seats. Behind the last work, ``works`` is asked again with the next draw.

    An executor that tells no seats from each other may go through it: it gives the works in their order.

    Args:
        works: to come.
        late: whether so many points that were granted can be begun no more; see ``Budget.late``.
    """

    def __init__(self, works: Iterable[Work], late: Callable[[int], bool] = lambda _: False) -> None:
        self._works, self._late = iter(works), late
        self._first: deque[Work] = deque()
        self._waiting: dict[Hashable, deque[Together]] = {}
        self._seat_of: dict[Kin, Hashable] = {}

    def __iter__(self) -> Iterator[Work]:
        while (work := self.draw()) is not None:
            yield work

    def draw(self, seat: Hashable = SOME_SEAT) -> Work | None:
        """The next work for a seat; None: none for now."""
        if self._first:
            return self._first.popleft()
        if (work := self._own(seat)) is not None:
            return work
        while sum(map(len, self._waiting.values())) < MOST_WAITING:
            work = next(self._works, None)
            if not isinstance(work, Together) or work.kin is None:
                if work is None:
                    break
                return work
            owner = self._seat_of.setdefault(work.kin, seat)
            if owner == seat:
                return work
            self._waiting.setdefault(owner, deque()).append(work)
        self._take_over(seat)
        return self._own(seat)

    def put_back(self, works: Sequence[Work], seat: Hashable = SOME_SEAT) -> None:
        """Take works back: they are the next ones of the seat that began their kin, and else of any seat."""
        for work in reversed(works):
            if isinstance(work, Together) and work.kin is not None and self._seat_of.get(work.kin) == seat:
                self._waiting.setdefault(seat, deque()).appendleft(work)
            else:
                self._first.appendleft(work)

    def add(self, works: Iterable[Work]) -> None:
        """Take works in the place of one that fell apart: they are next, for any seat."""
        self._first.extend(works)

    def is_empty(self) -> bool:
        """Whether no work is left."""
        if not self._first and not any(self._waiting.values()):
            self._first.extend([work] if (work := next(self._works, None)) is not None else [])
        return not self._first and not any(self._waiting.values())

    def _own(self, seat: Hashable) -> Work | None:
        """The first work that waits for a seat."""
        waiting = self._waiting.get(seat, ())
        while waiting:
            work = self._waiting[seat].popleft()
            if not self._late(len(work)):
                return work
        return None

    def _take_over(self, seat: Hashable) -> None:
        """Let a seat have works of one kin that wait for another one, and the kin with them if all of them move."""
        waiting = {owner: works for owner, works in self._waiting.items() if works}
        if not waiting:
            return
        owner = max(waiting, key=lambda each: len(waiting[each]))
        theirs = waiting[owner]
        kin, count = Counter(work.kin for work in theirs).most_common(1)[0]
        most = (len(theirs) + 1) // 2
        moved = [work for work in theirs if work.kin == kin][-most:]
        if kin is not None and len(moved) == count:
            self._seat_of[kin] = seat
        taken = set(map(id, moved))
        self._waiting[owner] = deque(work for work in theirs if id(work) not in taken)
        self._waiting.setdefault(seat, deque()).extend(moved)
