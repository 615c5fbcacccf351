"""The boards of the catalogue: which are asked about, what they cost, and what they draw while they wait."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from codesign.ground.errors import InputError
from codesign.ground.figures import Figure
from codesign.inputs import Platform, list_platforms, load_platform
from codesign.inputs.files import is_path
from codesign.inputs.platform import Board as Sold


@dataclass(frozen=True, eq=False)
class Board:
    """A platform that is asked about. ``source``: its shipped name or its file, as ``hwsw run`` takes it."""

    source: str
    platform: Platform

    @property
    def name(self) -> str:
        """Its name in results."""
        return self.platform.name

    @property
    def price_usd(self) -> float | None:
        """Its price, with the price of the computer beside it; None if the platforms do not declare both."""
        prices = self._prices
        return None if prices is None else sum(float(price.value) for price in prices)

    @property
    def price_interval_usd(self) -> tuple[float, float] | None:
        """The least and the greatest price inside the intervals of the figures; None where it is not known."""
        prices = self._prices
        if prices is None:
            return None
        return sum(price.interval[0] for price in prices), sum(price.interval[1] for price in prices)

    @property
    def _prices(self) -> list[Figure] | None:
        """Its own price, and the price of the computer beside it."""
        prices = [board.price for board in self._sold]
        known = [price for price in prices if price is not None]
        return known if prices and len(known) == len(prices) else None

    @property
    def _sold(self) -> list[Sold]:
        """The board that is sold, and the computer beside it; empty for a platform that is none."""
        board = self.platform.board
        if board is None:
            return []
        return [board] if board.beside is None else [board, *Board(board.beside, load_platform(board.beside))._sold]

    @cached_property
    def input_idle_w(self) -> tuple[float, float, float] | None:
        """The power at its input while it waits, with the computer beside it: value, least and greatest, W.

        The greatest is of the work that was measured too. None if it is not declared for both.
        """
        powers = [board.power for board in self._sold]
        known = [power for power in powers if power is not None]
        if not powers or len(known) < len(powers):
            return None
        ends = [(power.idle.interval[0], (power.busy or power.idle).interval[1]) for power in known]
        return sum(power.idle.value for power in known), *(sum(column) for column in zip(*ends, strict=True))

    @property
    def idle_w(self) -> float:
        """The power that its components draw while no plan is computed, W."""
        return sum(figure.value for figure in self._idle)

    @property
    def idle_interval_w(self) -> tuple[float, float]:
        """The least and the greatest of it inside the intervals of the figures, W."""
        return sum(figure.interval[0] for figure in self._idle), sum(figure.interval[1] for figure in self._idle)

    @property
    def _idle(self) -> list[Figure]:
        """Static power of every FPGA, and idle power of every processor, memory and link with a declared power."""
        components = self.platform.components.values()
        figures = [spec.chip.static_power for spec in components if spec.chip is not None]
        drawing = [spec.drawing for spec in (*components, *self.platform.links.values())]
        return figures + [power.idle for power in drawing if power is not None]


def boards_of(sources: Sequence[str] | None = None) -> tuple[Board, ...]:
    """The boards of these shipped names or files; by default every shipped platform that is a board on sale.

    Raises:
        InputError: no such board, none at all, or one is named twice. SpecError: the faults of a file.
    """
    if sources is None:
        shipped = (Board(name, load_platform(name)) for name in list_platforms())
        return tuple(board for board in shipped if board.platform.board is not None)
    if not sources:
        raise InputError("no board is named", "--boards", "write --boards zynq,arty-a7, or leave it out")
    boards: dict[str, Board] = {}
    for source in sources:
        board = Board(source, load_platform(source))
        if board.name in boards:
            what = f"board {board.name} is named twice"
            raise InputError(what, "--boards", "name it once, or give one of the files another name:")
        boards[board.name] = board
    return tuple(boards.values())


def is_file(board: Board) -> bool:
    """True if the board is a file of the user, not a shipped platform."""
    return is_path(board.source)
