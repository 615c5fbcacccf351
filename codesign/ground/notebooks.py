"""What a notebook shows of an object: a class derives from ``InNotebooks``, and the report makes the HTML.

The report stands above most classes that it shows, so it is not imported here: ``codesign`` itself, which every program
loads first, names the function that makes the HTML.
"""

from __future__ import annotations

from collections.abc import Callable

_html: list[Callable[[object], str]] = []


def show_with(html: Callable[[object], str]) -> None:
    """Let ``html`` make what notebooks show of every object that is ``InNotebooks``."""
    _html[:] = [html]


class InNotebooks:
    """A class whose objects a notebook shows as small tables."""

    def _repr_html_(self) -> str:
        """The object as a few lines of HTML, with bounded tables."""
        (html,) = _html
        return html(self)
