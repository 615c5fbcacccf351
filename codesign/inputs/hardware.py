"""The base of components and links, which says which keys are prices.

A price moves the time and the energy of work and of messages. It moves neither the work nor the messages. Design points
that differ in prices alone compute the same, so one simulation serves them all.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from codesign.models import SpecModel


class Hardware(SpecModel):
    """A component or link of a platform. By default it has no price.

    ``traded``: the prices whose faster value is worse in another figure. Of all other prices the fastest value is best.
    """

    traded: ClassVar[frozenset[str]] = frozenset()

    def prices(self) -> frozenset[str]:
        """The keys that are prices."""
        return frozenset()

    def directions(self) -> Mapping[str, int]:
        """By price, 1 where no act is slower as the price rises, and -1 where none is slower as it falls.

        A price that does neither is left out.
        """
        return {}

    @property
    def drawing(self) -> Any:
        """Power while it works (``busy``) and while it waits (``idle``); None where it has or declares none."""
        return None

    def shape(self) -> Any:
        """All but its prices, as JSON: components of one shape compute the same."""
        return self.model_dump(mode="json", exclude=set(self.prices()))
