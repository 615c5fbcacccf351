"""Trees of specs and their mutations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st

from codesign.ground.errors import Fault, SpecError

scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**20), 10**20),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=8),
    st.sampled_from(["1 MHz", "fpga", "maze", "relax", "XC4VLX160-12", "x.yaml", "010", "1 us", "time", "sound"]),
)


quietly = settings(deadline=None)


trees = st.recursive(
    scalars,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(
            st.one_of(
                st.text(max_size=6),
                st.sampled_from(["type", "value", "source", "generate", "file", "first", "count", "figure", "at_most"]),
            ),
            inner,
            max_size=3,
        ),
    ),
    max_leaves=8,
)


def assert_faults_are_told(action: Callable[[], object]) -> tuple[Fault, ...]:
    """The faults of an action that may succeed: each is short and has its place. Any other exception is let through."""
    try:
        action()
    except SpecError as error:
        faults = error.faults
    else:
        return ()
    assert faults
    for fault in faults:
        assert fault.file
        assert fault.what
        assert min(fault.line, fault.column) >= 0
        assert len(str(fault)) < 1000
    return faults


def paths(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    inner: list[tuple[Any, ...]] = [path]
    entries = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in entries:
        inner += paths(value, (*path, key))
    return inner


def replaced(tree: Any, path: tuple[Any, ...], value: Any) -> Any:
    if not path:
        return value
    made = dict(tree) if isinstance(tree, dict) else list(tree)
    made[path[0]] = replaced(tree[path[0]], path[1:], value)
    return made
