"""The base of components and links, which says which keys are prices.

A price moves the time and the energy of work and of messages. It moves neither the work nor the messages. Design points
that differ in prices alone compute the same, so one simulation serves them all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from codesign.ground.figures import Figure
from codesign.ground.models import SpecModel
from codesign.laws import Law, Number


class Hardware(SpecModel):
    """A component or link of a platform.

    ``law``: what its acts take. It reads the keys of the same names.
    ``traded``: the prices whose faster value is worse in another figure. Of all other prices the fastest value is best.
    """

    law: ClassVar[type[Law]]
    traded: ClassVar[frozenset[str]] = frozenset()

    def prices(self) -> frozenset[str]:
        """The keys that are prices: by default the price keys of its law."""
        return frozenset(self.law.prices(self))

    def directions(self) -> Mapping[str, int]:
        """By price, 1 where no act is slower as the price rises, and -1 where none is slower as it falls.

        A price that does neither is left out.
        """
        return self.law.directions(self)

    def law_of(self, unit: str, number: Callable[[str], Number]) -> Law:  # noqa: ARG002 - see a processor
        """The law of the acts that are counted in a unit, with ``number(key)`` for each price."""
        return self.law.of(self, number)

    def figure(self, key: str) -> Figure:
        """The figure at a dotted key, such as ``power.busy`` or ``costs.wavefront_cell``."""
        found: Any = self
        for name in key.split("."):
            found = found[name] if isinstance(found, Mapping) else getattr(found, name)
        return found  # type: ignore[no-any-return]

    @property
    def drawing(self) -> Any:
        """Power while it works (``busy``) and while it waits (``idle``); None where it has or declares none."""
        return None

    def shape(self) -> Any:
        """All but its prices, as JSON: components of one shape compute the same."""
        return self.model_dump(mode="json", exclude=set(self.prices()))
