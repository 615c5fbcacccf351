"""What a worker sends back: no work, and priced outcomes as the block that the store keeps.

To write a block takes most of what keeping takes. So the workers write it, side by side, and the process that keeps all
only reads it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from codesign.exploration.blocks import block_of
from codesign.exploration.evaluation import Done
from codesign.exploration.partition import Alone, Work
from codesign.exploration.shared import Parts


class Packing:
    """Computes works, and packs what comes of them; the sender of the works adds them again."""

    def __init__(self, evaluate: Callable[[Work], Done]) -> None:
        self._evaluate = evaluate
        self._parts = Parts()

    def __call__(self, work: Work) -> Done:
        """What came of a work, packed."""
        done = replace(self._evaluate(work), work=Alone(()))
        if done.priced is None:
            return done
        return replace(done, priced=None, block=block_of(done.priced, self._parts)[0])
