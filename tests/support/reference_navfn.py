"""NavFn as ``navfn.cpp`` of nav2_navfn_planner has it, line by line, with its names: the reference of the kernels.

Floats are numpy's of 32 bits, doubles are Python's. ``hypot`` is the root of the sum of squares in doubles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

COST_OBS, COST_NEUTRAL, POT_HIGH, PRIORITYBUFSIZE, INVSQRT2 = 254, 50, np.float32(1.0e10), 10_000, 0.707106781
F = np.float32


def rounded(value: float) -> int:
    return int(math.copysign(math.floor(abs(value) + 0.5), value))


@dataclass
class NavFn:
    """``nx`` cells a row; ``costarr``: COST_NEUTRAL or COST_OBS. The wave begins at ``goal`` and ends at ``starts``."""

    nx: int
    costarr: list[int]
    goal: int
    starts: list[int]
    updates: int = 0
    potarr: list[np.float32] = field(default_factory=list)
    pending: list[bool] = field(default_factory=list)
    blocks: dict[str, list[int]] = field(default_factory=lambda: {"cur": [], "next": [], "over": []})
    cur_t: np.float32 = field(default_factory=lambda: F(COST_OBS))

    def push(self, block: str, n: int) -> None:
        held = self.blocks[block]
        if not self.pending[n] and self.costarr[n] < COST_OBS and len(held) < PRIORITYBUFSIZE:
            held.append(n)
            self.pending[n] = True

    def update_cell(self, n: int) -> None:
        self.updates += 1
        sides = (n - 1, n + 1, n - self.nx, n + self.nx)
        left, right, up, down = (self.potarr[side] for side in sides)
        tc, ta = min(left, right), min(up, down)
        hf, dc = F(self.costarr[n]), F(tc - ta)
        if dc < 0:
            dc, ta = F(-dc), tc
        if dc >= hf:
            pot = F(ta + hf)
        else:
            div = float(F(dc / hf))
            pot = F(ta + F(hf * F(-0.2301 * div * div + 0.5307 * div + 0.7040)))
        if pot < self.potarr[n]:
            self.potarr[n] = pot
            block = "next" if pot < self.cur_t else "over"
            for side, value in zip(sides, (left, right, up, down), strict=True):
                if value > F(pot + F(INVSQRT2 * self.costarr[side])):
                    self.push(block, side)

    def propagate(self) -> None:
        ns = len(self.costarr)
        self.potarr, self.pending = [POT_HIGH] * ns, [False] * ns
        self.potarr[self.goal] = F(0.0)
        for side in (1, -1, -self.nx, self.nx):
            self.push("cur", self.goal + side)
        for _ in range(max(ns // 20, self.nx + ns // self.nx)):
            if not self.blocks["cur"] and not self.blocks["next"]:
                break
            for n in self.blocks["cur"]:
                self.pending[n] = False
            for n in self.blocks["cur"]:
                self.update_cell(n)
            self.blocks["cur"], self.blocks["next"] = self.blocks["next"], []
            if not self.blocks["cur"]:
                self.cur_t = F(self.cur_t + F(2 * COST_NEUTRAL))
                self.blocks["cur"], self.blocks["over"] = self.blocks["over"], []
            if any(self.potarr[start] < POT_HIGH for start in self.starts):
                break

    def grad_cell(self, n: int) -> None:
        nx, pot = self.nx, self.potarr
        if self.gradx[n] + self.grady[n] > 0.0 or n < nx or n > len(pot) - nx:
            return
        cv, dx, dy = pot[n], F(0.0), F(0.0)
        if cv >= POT_HIGH:
            if pot[n - 1] < POT_HIGH:
                dx = F(-COST_OBS)
            elif pot[n + 1] < POT_HIGH:
                dx = F(COST_OBS)
            if pot[n - nx] < POT_HIGH:
                dy = F(-COST_OBS)
            elif pot[n + nx] < POT_HIGH:
                dy = F(COST_OBS)
        else:
            if pot[n - 1] < POT_HIGH:
                dx = F(dx + F(pot[n - 1] - cv))
            if pot[n + 1] < POT_HIGH:
                dx = F(dx + F(cv - pot[n + 1]))
            if pot[n - nx] < POT_HIGH:
                dy = F(dy + F(pot[n - nx] - cv))
            if pot[n + nx] < POT_HIGH:
                dy = F(dy + F(cv - pot[n + nx]))
        norm = F(math.sqrt(float(dx) * float(dx) + float(dy) * float(dy)))
        if norm > 0:
            norm = F(1.0 / float(norm))
            self.gradx[n], self.grady[n] = F(norm * dx), F(norm * dy)

    def calc_path(self, start: int, most: int) -> list[tuple[float, float]]:  # noqa: PLR0912 - as the source
        """Points (x, y), from ``start`` down to the goal; none where it is not reached."""
        nx, pot = self.nx, self.potarr
        self.gradx, self.grady = [F(0.0)] * len(pot), [F(0.0)] * len(pot)
        stc, dx, dy = start, F(0.0), F(0.0)
        path: list[tuple[float, float]] = []
        for _ in range(most):
            nearest = max(0, min(len(pot) - 1, stc + rounded(dx) + nx * rounded(dy)))
            if pot[nearest] < COST_NEUTRAL:
                return [*path, (float(self.goal % nx), float(self.goal // nx))]
            if stc < nx or stc > len(pot) - nx:
                return []
            path.append((float(F(F(stc % nx) + dx)), float(F(F(stc // nx) + dy))))
            oscillates = len(path) > 2 and path[-1] == path[-3]
            rows = [stc - nx, stc, stc + nx]
            around = [row + off for row in rows for off in (-1, 0, 1)]
            if oscillates or any(pot[n] >= POT_HIGH for n in around):
                minp, minc = int(pot[stc]), stc
                for n in around:
                    if n != stc and pot[n] < minp:
                        minp, minc = int(pot[n]), n
                stc, dx, dy = minc, F(0.0), F(0.0)
                if pot[stc] >= POT_HIGH:
                    return []
                continue
            corners = (stc, stc + 1, stc + nx, stc + nx + 1)
            for corner in corners:
                self.grad_cell(corner)

            def interpolated(grad: list[np.float32], corners: tuple[int, ...], dx: np.float32, dy: np.float32) -> float:
                a, b, c, d = (grad[corner] for corner in corners)
                first = float(F((1.0 - float(dx)) * float(a) + float(F(dx * b))))
                second = float(F((1.0 - float(dx)) * float(c) + float(F(dx * d))))
                return float(F((1.0 - float(dy)) * first + float(F(dy * F(second)))))

            x, y = interpolated(self.gradx, corners, dx, dy), interpolated(self.grady, corners, dx, dy)
            if x == 0.0 and y == 0.0:
                return []
            ss = F(F(0.5) / F(math.sqrt(x * x + y * y)))
            dx, dy = F(dx + F(F(x) * ss)), F(dy + F(F(y) * ss))
            if dx > 1.0:
                stc, dx = stc + 1, F(dx - F(1.0))
            if dx < -1.0:
                stc, dx = stc - 1, F(dx + F(1.0))
            if dy > 1.0:
                stc, dy = stc + nx, F(dy - F(1.0))
            if dy < -1.0:
                stc, dy = stc - nx, F(dy + F(1.0))
        return []
