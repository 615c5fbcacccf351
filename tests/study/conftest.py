"""What tests of explorations share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from codesign.inputs import exploration


@pytest.fixture(scope="module")
def searched() -> Iterator[None]:
    """A search runs in any space: none is so small that all of its points are computed in its place."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exploration, "ENUMERATED", 0)
        yield
