"""A process-local memory of costly answers, bounded in bytes.

The points of an exploration share much of their work: the field of a map at one precision is the same
whatever part it is computed on. A ``Memo`` keeps such answers under keys that name everything they depend
on (the digest of the problem first), so that sharing never changes a figure, only the time it takes.
"""

from __future__ import annotations

import sys
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

T = TypeVar("T")

DEFAULT_BYTES = 512 * 2**20


class Memo:
    """Answers by key, the least recently used forgotten first once they hold more than ``max_bytes``.

    An answer larger than ``max_bytes`` is handed back but not kept. What is kept is handed out again as it
    is, not
    copied: treat it as frozen. Not for use by several threads at once.

    >>> memo = Memo()
    >>> memo.get(("square", 12), lambda: 12 * 12), memo.get(("square", 12), lambda: 0)
    (144, 144)
    >>> memo.hits, memo.misses
    (1, 1)
    """

    def __init__(self, max_bytes: int = DEFAULT_BYTES) -> None:
        self.max_bytes = max_bytes
        self.held_bytes = 0
        self.hits = 0
        self.misses = 0
        self._kept: OrderedDict[tuple[Any, ...], tuple[Any, int]] = OrderedDict()

    def __len__(self) -> int:
        return len(self._kept)

    def get(self, key: tuple[Any, ...], compute: Callable[[], T]) -> T:
        """The answer kept under ``key``, or that of ``compute``, which is then kept.

        ``compute`` may itself use this memo. Where it raises, nothing is kept.
        """
        found = self._kept.get(key)
        if found is not None:
            self.hits += 1
            self._kept.move_to_end(key)
            answer: T = found[0]
            return answer
        self.misses += 1
        answer = compute()
        self._keep(key, answer)
        return answer

    def _keep(self, key: tuple[Any, ...], answer: Any) -> None:
        size = approximate_bytes(key) + approximate_bytes(answer)
        if size > self.max_bytes:
            return
        _, replaced = self._kept.pop(key, (None, 0))
        self._kept[key] = (answer, size)
        self.held_bytes += size - replaced
        while self.held_bytes > self.max_bytes:
            _, (_, freed) = self._kept.popitem(last=False)
            self.held_bytes -= freed


def approximate_bytes(value: Any) -> int:
    """About how much memory a value holds, with all that it refers to; arrays count by their buffer.

    What is shared inside ``value`` counts once.
    """
    seen: set[int] = set()
    waiting = [value]
    total = 0
    while waiting:
        item = waiting.pop()
        if id(item) in seen or isinstance(item, type):
            continue
        seen.add(id(item))
        total += sys.getsizeof(item, 64)
        waiting.extend(_parts(item))
        if getattr(item, "base", None) is not None:
            # A view answers for the buffer that it keeps alive.
            waiting.append(item.base)
    return total


def _parts(item: Any) -> Iterable[Any]:
    if isinstance(item, (str, bytes, bytearray, int, float, complex)):
        return ()
    if isinstance(item, Mapping):
        return [*item.keys(), *item.values()]
    if isinstance(item, (tuple, list, set, frozenset)):
        return item
    if getattr(item, "dtype", None) is not None and getattr(item.dtype, "hasobject", False):
        flat: list[Any] = item.ravel().tolist()
        return flat
    attributes = list(getattr(item, "__dict__", {}).values())
    for kind in type(item).__mro__:
        slots = kind.__dict__.get("__slots__", ())
        names = (slots,) if isinstance(slots, str) else slots
        attributes += [getattr(item, name) for name in names if hasattr(item, name)]
    return attributes
