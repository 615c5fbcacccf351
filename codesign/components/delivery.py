"""The end of a message on a link."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

ABANDONED = "abandoned"
"""The reason of a message that was dropped because its sender was interrupted."""

LINK_DOWN = "link down"
"""The reason of a message that was dropped because of an outage."""


class DeliveryOutcome(StrEnum):
    """The end of a message."""

    DELIVERED = "delivered"
    DROPPED = "dropped"


@dataclass(frozen=True)
class Delivery:
    """The end of a message, and the account of its time (ps).

    - ``time``: when it was delivered or given up. ``reason``: why it was dropped; None if it was delivered.
    - ``attempts``: how often it was on the wire.
    - ``transferred``: the time on the wire, all attempts together. ``queued``: all other time since the request: the
      wait for the line, an edge, a timeout, the end of an outage, or a late arrival.
    - ``damaged``: it was delivered with wrong bits that were not detected. ``wrong``: the indices of the wrong bits of
      the message itself, from 0, in order, without the bits of its checksum and its frames.
    """

    time: int
    outcome: DeliveryOutcome
    reason: str | None
    attempts: int
    queued: int
    transferred: int
    damaged: bool = False
    wrong: tuple[int, ...] = ()
