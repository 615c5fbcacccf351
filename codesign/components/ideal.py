"""A link that takes no time: for what is not to be studied, and for checks."""

from __future__ import annotations

from collections.abc import Sequence

import simpy

from codesign.components.link import Link
from codesign.components.link_faults import LinkErrors
from codesign.records import Listener


class Ideal(Link):
    """Delivers every message at the picosecond at which it is asked for, and counts it all the same.

    It is never busy. Errors and outages behave as on every link.
    """

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        *,
        between: Sequence[str] = (),
        errors: LinkErrors | None = None,
        outages: Sequence[tuple[int, int | None]] = (),
        listeners: Sequence[Listener] = (),
    ) -> None:
        super().__init__(
            environment,
            name,
            shared=False,
            between=between,
            errors=errors,
            outages=outages,
            listeners=listeners,
        )

    def duration(self, bits: int) -> int:  # noqa: ARG002  (every link tells it by the bits)
        """No time, whatever ``bits`` is."""
        return 0
