"""Links of every kind, and runs over them whose account is checked at every event."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from typing import Any

import simpy

from codesign.components import Arbitration, Bus, Delivery, Ideal, Link, LinkErrors, Serial
from codesign.ground.records import MessageRecord, Record
from codesign.laws.acts import BusLaw, IdealLaw, SerialLaw

Work = Generator[simpy.Event, Any, Any]
Make = Callable[..., Link]


def a_bus(environment: simpy.Environment, speed: int = 1, **options: Any) -> Link:
    law = BusLaw(33_000_000 * speed, width=32, burst_words=4, setup_cycles=3)
    return Bus(environment, "link", law, **options)


def a_bus_in_bursts(environment: simpy.Environment, speed: int = 1, **options: Any) -> Link:
    return a_bus(environment, speed, arbitration=Arbitration.BURST, **options)


def a_serial_line(
    environment: simpy.Environment, speed: int = 1, frame: dict[str, Any] | None = None, **options: Any
) -> Link:
    return Serial(environment, "link", SerialLaw(30_000_000 * speed, **(frame or {})), fifo_depth=4, **options)


def a_shared_serial_line(environment: simpy.Environment, speed: int = 1, **options: Any) -> Link:
    return a_serial_line(environment, speed, between=("a", "b", "c"), **options)


def an_ideal_link(environment: simpy.Environment, speed: int = 1, **options: Any) -> Link:
    del speed
    return Ideal(environment, "link", IdealLaw(), **options)


TIMED: list[Make] = [a_bus, a_bus_in_bursts, a_serial_line, a_shared_serial_line]
ALL: list[Make] = [*TIMED, an_ideal_link]


@dataclass(frozen=True)
class Ask:
    """One message: when and by whom it is asked for, and when its sender is interrupted, if it is."""

    at: int
    sender: str
    bits: int
    priority: int = 0
    post: bool = False
    interrupt_at: int | None = None


@dataclass
class Seen:
    """What came of a run: deliveries by the index of the message, when posters were free, and all records."""

    link: Link
    deliveries: dict[int, Delivery] = field(default_factory=dict)
    free: dict[int, int] = field(default_factory=dict)
    records: list[MessageRecord] = field(default_factory=list)
    moments: list[tuple[int, int]] = field(default_factory=list)


def balance(link: Link) -> None:
    """Nothing is lost from the account, and the link is never busier than the time allows."""
    assert link.sent == link.delivered + sum(link.dropped.values()) + link.in_flight
    assert min(link.delivered, link.in_flight, link.retransmissions, link.undetected, link.late) >= 0
    assert 0 <= link.busy <= link.now


def run(make: Make, asks: Sequence[Ask], until: int | None = None, **options: Any) -> Seen:
    """Ask for every message at its time; ``until`` (ps): stop there."""
    environment = simpy.Environment()

    def hear(record: Record) -> None:
        assert isinstance(record, MessageRecord)
        seen.records.append(record)

    seen = Seen(make(environment, listeners=(hear,), **options))

    def one(index: int, ask: Ask) -> Work:
        yield environment.timeout(ask.at)
        message = (ask.sender, "b" if ask.sender == "a" else "a", str(index), ask.bits, ask.priority)
        if ask.post:
            carrier = yield from seen.link.post(*message)
            seen.free[index] = environment.now
            seen.deliveries[index] = yield carrier
        else:
            seen.deliveries[index] = yield from seen.link.send(*message)

    def interrupted(index: int, ask: Ask) -> Work:
        try:
            yield from one(index, ask)
        except simpy.Interrupt:
            return

    def interrupter(process: simpy.Process, at: int) -> Work:
        yield environment.timeout(at)
        if process.is_alive:
            process.interrupt()

    for index, ask in enumerate(asks):
        process = environment.process(interrupted(index, ask))
        if ask.interrupt_at is not None:
            environment.process(interrupter(process, ask.interrupt_at))
    while environment.peek() <= (float("inf") if until is None else until) and environment.peek() != float("inf"):
        environment.step()
        assert type(environment.now) is int
        balance(seen.link)
        seen.moments.append((environment.now, seen.link.in_flight))
    return seen


def all_errors(seed: int = 1, **changes: Any) -> LinkErrors:
    """Errors of every kind."""
    values: dict[str, Any] = {
        "bit_error_rate": 0.002,
        "checksum_bits": 3,
        "retries": 2,
        "timeout": 700_000,
        "drop": 0.1,
        "late_share": 0.2,
        "late_delay": 500_000,
        "seed": seed,
    }
    return LinkErrors(**(values | changes))
