"""The base of every self-contained HTML page: the environment of templates, the footer, data for scripts.

Data flows in through templates that escape everything; what is put in as it is comes from this package, or from a
library that is kept in it with its licence. The page's content security policy forbids every request: what a reader
sees is in the file.
"""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.files import write_atomically
from codesign.ground.late import late
from codesign.ground.numbering import distinct
from codesign.system.results.result import Provenance
from codesign.views.report.wording import ABSENT

if TYPE_CHECKING:
    from codesign.views.report.canvas import Picture

jinja2 = late("jinja2")

_INVISIBLE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Controls but tab and newline, marks that turn the direction of writing, halves of surrogate pairs."""


def rendered(template: str, provenance: Provenance | None, **values: Any) -> str:
    """The page that a template makes of values. What is no page of its own is escaped."""
    page: str = _environment().get_template(template).render(footer=footer_text(provenance), **values)
    return page


@cache
def _environment() -> Any:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("codesign.views.report"),
        autoescape=True,
        finalize=_visible,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals.update(
        style=template_text("style.css"), shared=template_text("shared.js"), data_address=_data_address, absent=ABSENT
    )
    return environment


def footer_text(provenance: Provenance | None) -> str:
    """The provenance of a page, in a line; of a page without specs, version and date."""
    stamped = (provenance or Provenance()).stamped()
    names = {"codesign": "hwsw", "workload_digest": "workload", "map_digest": "map"}
    platforms = [f"platform {name} {digest[:12]}" for name, digest in stamped.platform_digests.items()]
    parts = [
        f"{names.get(key, key)} {text[:12] if key.endswith('digest') else text}"
        for key, text in stamped.constants.items()
    ]
    return "; ".join((parts[0], *platforms, *parts[1:]))


def _visible(value: Any) -> Any:
    """Text with characters that no page may hold, or that would hide or turn what follows, written as escapes.

    What is safe by its type is our own and stays as it is.
    """
    if isinstance(value, str) and not hasattr(value, "__html__"):
        return _INVISIBLE.sub(lambda match: ascii(match[0])[1:-1], value)
    return value


def template_text(name: str) -> str:
    """A file beside the templates: a style, a script."""
    return (resources.files("codesign.views.report") / "templates" / name).read_text(encoding="utf-8")


def script_json(value: Mapping[str, Any]) -> str:
    """JSON that may stand in a script element: nothing in it can end the element or open a comment."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _data_address(picture: Picture) -> str:
    kind = "svg+xml" if picture.format == "svg" else "png"
    return f"data:image/{kind};base64,{base64.b64encode(picture.data).decode()}"


def write_page(path: Path, page: str) -> None:
    """Write a page whole, or not at all.

    Raises:
        RunError: the file cannot be written.
    """
    write_atomically(path, page.encode("utf-8", "replace"))


Entry = dict[str, Any]
"""The place of a column: its ``type``, the byte ``at`` which it begins, and the ``count`` of its numbers."""

_FEW = 1 << 16


class Columns:
    """Columns that are added one after the other, for ``templates/columns.js``; no number loses a bit.

    ``add`` and ``texts`` return where a column stands.
    """

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._length = 0

    @property
    def packed(self) -> str:
        """All of them, deflated, in base64."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), 9)).decode()

    def add(self, numbers: NDArray[Any]) -> Entry:
        """A column of whole numbers from 0 to 2^32 - 1, or of any float64; NaN and infinities are kept."""
        if numbers.dtype.kind != "f":
            most = int(numbers.max(initial=0))
            size = 1 if most < 1 << 8 else 2 if most < _FEW else 4
            return self._put(f"u{size}", numbers.astype(f"<u{size}").tobytes(), len(numbers))
        values, codes = distinct(numbers)
        if len(values) < min(_FEW, max(2, len(numbers) // 2)):
            of = [self._floats(values), self.add(codes)]
            return {"type": "coded", "count": len(numbers), "of": of}
        return self._floats(numbers)

    def steps(self, numbers: NDArray[np.int64]) -> Entry:
        """A column of whole numbers that differ little from one to the next, of at most 2^31 in size."""
        steps: NDArray[np.int64] = np.diff(numbers, prepend=np.int64(0))
        # 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
        return {"type": "steps", "count": len(numbers), "of": [self.add((steps << 1) ^ (steps >> 63))]}

    def texts(self, texts: Sequence[str]) -> Entry:
        """Texts, as JSON. ``count`` is the number of bytes."""
        written = json.dumps(list(texts), ensure_ascii=True).encode()
        return self._put("json", written, len(written))

    def _floats(self, numbers: NDArray[Any]) -> Entry:
        # The first bytes of all numbers, then the second ones, and so on: so they deflate better.
        planes = numbers.astype("<f8").view(np.uint8).reshape(-1, 8).T
        return self._put("f8", np.ascontiguousarray(planes).tobytes(), len(numbers))

    def _put(self, kind: str, content: bytes, count: int) -> Entry:
        at = self._length
        # A typed array of 4 bytes a number begins at a multiple of 4.
        self._parts.append(content + bytes(-len(content) % 8))
        self._length += len(self._parts[-1])
        return {"type": kind, "at": at, "count": count}
