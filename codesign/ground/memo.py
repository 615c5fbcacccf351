"""A process-local cache of costly answers, bounded in bytes.

The points of an exploration share much of their work: the field of a map at one precision is the same on any part. A
``Memo`` keeps such answers under keys that name everything they depend on, beginning with the digest of the problem. So
sharing changes no figure, only the time of the computation.
"""

from __future__ import annotations

import sys
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import Any, Generic, TypeVar

T = TypeVar("T")

DEFAULT_BYTES = 512 * 2**20


class Memo:
    """Answers by key. Beyond ``max_bytes`` the least recently used ones are removed first.

    An answer larger than ``max_bytes`` is returned but not kept. A kept answer is returned without a copy: do not
    change it. Not for use by several threads at once.

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
        """The answer kept under ``key``, or the answer of ``compute``, which is then kept.

        ``compute`` may itself use this memo. Where it raises, nothing is kept.
        """
        entry = self._kept.get(key)
        if entry is not None:
            self.hits += 1
            self._kept.move_to_end(key)
            kept_answer: T = entry[0]
            return kept_answer
        self.misses += 1
        answer = compute()
        self.keep(key, answer)
        return answer

    def held(self, key: tuple[Any, ...]) -> Any:
        """The answer kept under ``key``; None where none is."""
        entry = self._kept.get(key)
        return None if entry is None else entry[0]

    def keep(self, key: tuple[Any, ...], answer: Any) -> None:
        """Keep an answer that is there already, in the place of an earlier one."""
        size = approximate_bytes(key) + approximate_bytes(answer)
        if size > self.max_bytes:
            return
        _, replaced = self._kept.pop(key, (None, 0))
        self._kept[key] = (answer, size)
        self.held_bytes += size - replaced
        while self.held_bytes > self.max_bytes:
            _, (_, freed) = self._kept.popitem(last=False)
            self.held_bytes -= freed


class Same(Generic[T]):
    """An object as the key of what is kept of it: this very object, whatever is equal to it."""

    def __init__(self, it: T) -> None:
        self.it = it

    def __hash__(self) -> int:
        return id(self.it)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.it is other.it


def approximate_bytes(value: Any) -> int:
    """The approximate memory of a value with everything that it refers to. Arrays count with their buffers.

    Objects that are shared inside ``value`` count once. One with ``approximate_bytes`` says itself what it takes.
    """
    seen: set[int] = set()
    waiting = [value]
    total = 0
    while waiting:
        item = waiting.pop()
        kind = type(item)
        if id(item) in seen or isinstance(item, type):
            continue
        seen.add(id(item))
        total += sys.getsizeof(item, 64)
        if kind in _LEAVES:
            continue
        if hasattr(kind, "approximate_bytes"):
            total += item.approximate_bytes
            continue
        waiting.extend(_parts(item))
        if getattr(item, "base", None) is not None:
            # A view counts with the buffer that it keeps alive.
            waiting.append(item.base)
    return total


_LEAVES = frozenset((str, bytes, bytearray, int, float, complex, bool, type(None)))


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
    held: dict[str, Any] = getattr(item, "__dict__", {})
    kind: Any = type(item)
    return [*held.values(), *(getattr(item, name) for name in _slots(kind) if hasattr(item, name))]


@lru_cache(maxsize=1024)
def _slots(kind: type) -> tuple[str, ...]:
    """The names of the slots of a type and of those that it is made from."""
    names: list[str] = []
    for each in kind.__mro__:
        slots = each.__dict__.get("__slots__", ())
        names += (slots,) if isinstance(slots, str) else slots
    return tuple(names)
