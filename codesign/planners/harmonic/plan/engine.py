"""The fast relaxation: bit planes of all blocks, carried from stage to stage."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import RunError
from codesign.planners.harmonic.plan import kernels
from codesign.planners.harmonic.plan.arguments import Arguments, Stage, StageEnd, VisitBatch
from codesign.planners.harmonic.plan.fixed_point import Field, limbs_needed
from codesign.planners.harmonic.plan.layout import addresses, better_transposed, make_layout, make_state, segmented
from codesign.planners.harmonic.plan.limbs import (
    count_local_maxima,
    fill_mask,
    fill_residual,
    raise_field,
    residual_bits,
)

VISITS_PER_BATCH = 1 << 14
# Words times iterations between two chances for an interrupt: some tenth of a second.
BUDGET = 1 << 25
# Planes above those in use, besides those for the sum of the steps of a visit: memory that is seldom touched.
SPARE_PLANES = 16


class Engine:
    """Runs stage after stage of one relaxation.

    ``spare_planes``: planes allocated above those in use; None means as many as a visit may need. ``budget``: see
    ``BUDGET``. ``transposed``: True if rows and columns are exchanged inside; None means where it takes fewer vectors.
    None of these arguments changes a result.

    ``published``: True if stages end by the published test, not by the sound one. It may be changed between stages.
    """

    def __init__(
        self,
        arguments: Arguments,
        spare_planes: int | None = None,
        budget: int = BUDGET,
        transposed: bool | None = None,
    ) -> None:
        self._iterations = arguments.iterations
        self.published = arguments.termination == "published"
        self._budget = budget
        bits_of_a_visit = arguments.iterations.bit_length()
        self._spare = SPARE_PLANES + bits_of_a_visit if spare_planes is None else spare_planes
        shape, block = arguments.free.shape, arguments.block
        self._transposed = better_transposed(block) if transposed is None else transposed
        if self._transposed:
            shape, block = shape[::-1], block[::-1]
        self._field = arguments.start
        # Rows and columns of values are those of the map.
        self._limbs = np.array(arguments.start.limbs, order="C")
        self._candidates = np.array(arguments.movable, order="C")
        values, movable = self._turned(self._limbs), self._turned(self._candidates)
        bits, negative = residual_bits(values, movable)
        self._signed = bool(negative)
        # r always has its two low planes, and a sign in two's complement.
        # At the start of a stage r = N + E + S + W - 4H of its first values, and d = 0.
        count = max(bits, 2) + self._signed
        self._layout = make_layout(shape, block, count + self._spare, self._transposed)
        self._state = make_state(self._layout, self._signed)
        self._addresses = addresses(self._state)
        fill_mask(self._layout, movable, self._state.mask)
        fill_residual(self._layout, values, movable, self._state.residual, count)
        self._state.width[:] = self._state.active[:] = count - 2

    def _turned(self, array: NDArray[Any]) -> NDArray[Any]:
        # Always a copy: numba compiles anew for arrays that are read-only or not contiguous.
        return np.array(array.swapaxes(0, 1) if self._transposed else array, order="C")

    @property
    def settled(self) -> bool:
        """True if no visit would change a bit any more."""
        return not self._state.active.any()

    def run(
        self,
        stage_index: int,
        precision: int,
        most_sweeps: int | None = None,
        promote_after: int | None = None,
        converged: StageEnd | None = None,
    ) -> Iterator[VisitBatch | StageEnd]:
        """One stage at ``precision``, not below the precision of the stage before.

        Raises RunError if it would never end. With ``most_sweeps`` it ends with a fault at that number of sweeps, or at
        the sweep that shows that the values repeat. With ``promote_after`` it ends without a fault at that number.
        ``converged``: the end of another stage at this precision with the same field, should this one settle: the
        values need not be read from the planes again.
        """
        self._lift(precision - self._field.precision)
        layout = self._layout
        control = np.zeros(kernels.CONTROL_SIZE, np.int64)
        control[kernels.POWER] = 1
        counts = np.empty(VISITS_PER_BATCH, np.int32)
        blocks = layout.down * layout.across
        visits = iterations = 0
        status = kernels.RUNNING
        fault, promoted = "", False
        ends = [sweeps * blocks for sweeps in (most_sweeps, promote_after) if sweeps is not None]
        # ``counts`` has room for ``VISITS_PER_BATCH`` visits, so a stage is a few calls of the kernel; between two of
        # them the user may interrupt, and memory may grow.
        while status != kernels.CONVERGED:
            status, written = kernels.advance(
                self._layout,
                self._addresses,
                control,
                counts[: min(ends) - visits] if ends else counts,
                self._iterations,
                self._budget,
                self.published,
                self._signed,
            )
            if status == kernels.CYCLE and most_sweeps is None:
                what = f"at {precision} bits the values come back to where they were and never settle"
                raise RunError(what, "start", "start from zero, or from values nowhere above the final field")
            if status == kernels.GROW:
                self._grow()
            if written:
                block = _in_turns(blocks, visits % blocks, written)
                yield VisitBatch(stage_index, precision, block, counts[:written].copy())
                visits += written
                iterations += int(counts[:written].sum(dtype=np.int64))
            if status == kernels.CYCLE:
                fault = f"at {precision} bits the values come back to where they were and never settle"
                break
            promoted = promote_after is not None and visits == promote_after * blocks
            if status == kernels.RUNNING and promoted:
                break
            if status == kernels.RUNNING and most_sweeps is not None and visits == most_sweeps * blocks:
                fault = f"at {precision} bits the values have not settled after {most_sweeps:,} sweeps"
                break
        self._forget("ring", "visit", "snapshot")
        if converged is not None and self.settled:
            maxima, self._field = converged.stage.local_maxima, converged.field
            self._limbs = np.array(self._field.limbs, order="C")
        else:
            self._limbs = self._raised(precision)
            maxima = int(count_local_maxima(self._limbs, self._candidates))
            self._field = Field(self._limbs.view(), precision)
        promoted &= status != kernels.CONVERGED and not fault
        stage = Stage(precision, int(control[kernels.SWEEPS]), visits, iterations, maxima, promoted)
        yield StageEnd(stage_index, stage, self._field, fault)

    def _grow(self) -> None:
        """Allocate more planes in the middle of a stage."""
        old, old_planes = self._state, self._layout.planes
        self._layout = self._layout._replace(planes=old_planes + self._spare)
        new = self._state = make_state(self._layout, self._signed)
        for name, source in old._asdict().items():
            target = getattr(new, name)
            if name in ("residual", "odometer", "visit", "snapshot"):
                depth = min(old_planes, int(max(old.active.max() + 2, old.deepest.max(), old.visit_width.max())))
                self._by_plane(target, self._layout.planes)[:, :depth] = self._by_plane(source, old_planes)[:, :depth]
            elif name != "ring":
                target[:] = source
        self._addresses = addresses(new)

    def _by_plane(self, words: NDArray[np.uint64], planes: int) -> NDArray[np.uint64]:
        return words.reshape(-1, planes, self._layout.plane)

    def _lift(self, shift: int) -> None:
        """r << shift, d = 0: the start of the next stage."""
        self._forget("ring", "visit", "odometer", "snapshot")
        old, old_layout, old_addresses = self._state, self._layout, self._addresses
        # A sign is needed only where a negative r is left. A settled block has none.
        # With h = H << D the new residual is r << D, as N, E, S, W and h all shift alike. A converged stage leaves
        # 0 <= r < 4. A stage that the published test ended early leaves more, and one that cycles may leave r < 0.
        most = int(old.active.max())
        self._signed &= most > 0
        count = most + 2
        layout = segmented(self._layout, shift + count)
        self._layout = layout._replace(planes=shift + count + self._signed + self._spare)
        new = self._state = make_state(self._layout, self._signed)
        self._addresses = addresses(new)
        new.mask[:] = old.mask
        kernels.lift(old_layout, old_addresses, self._layout, self._addresses, shift, self._signed)

    def _forget(self, *names: str) -> None:
        """Free the planes that the stage no longer needs: most of the memory where blocks are large."""
        self._state = self._state._replace(**dict.fromkeys(names, np.empty(0, np.uint64)))

    def _raised(self, precision: int) -> NDArray[np.uint64]:
        """h = (h << shift) + d: the values at the end of the stage."""
        raised = np.empty((*self._candidates.shape, limbs_needed(precision)), np.uint64)
        raise_field(
            self._layout,
            self._limbs,
            precision - self._field.precision,
            self._state.odometer,
            self._state.odometer_width,
            self._signed,
            raised,
        )
        return raised


def _in_turns(blocks: int, first: int, count: int) -> NDArray[np.int32]:
    """``count`` blocks from the block ``first`` on, and again from the first after the last."""
    # A division a visit would take longer than many a visit.
    turns = -(-(first + count) // blocks)
    every = np.broadcast_to(np.arange(blocks, dtype=np.int32), (turns, blocks)).ravel()
    return every[first : first + count]
