"""How a message on a link ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

ABANDONED = "abandoned"
"""The reason of a message that was dropped because its sender was interrupted."""

LINK_DOWN = "link down"
"""The reason of a message that was dropped because of an outage."""


class DeliveryOutcome(StrEnum):
    """How a message ended."""

    DELIVERED = "delivered"
    DROPPED = "dropped"


@dataclass(frozen=True)
class Delivery:
    """How a message ended, and where its time went (ps).

    - ``time``: when it was delivered or given up. ``reason``: why it was dropped, None where it was delivered.
    - ``attempts``: how often it was on the wire.
    - ``transferred``: the time on the wire, all attempts together. ``queued``: all other time since the request: the
      wait for the line, an edge, a timeout, the end of an outage, or a late arrival.
    - ``damaged``: it was delivered with wrong bits that were not detected. ``wrong``: the indices of the wrong bits of
      the message itself, from 0, in order, without those of its checksum and its frames.
    """

    time: int
    outcome: DeliveryOutcome
    reason: str | None
    attempts: int
    queued: int
    transferred: int
    damaged: bool = False
    wrong: tuple[int, ...] = ()
