"""The headlines of our planners and styles, which ``hwsw list`` reads in the place of the planners themselves."""

from __future__ import annotations

import json

from codesign.planners.registered import is_ours, registered
from codesign.system import catalog


def headlines_text() -> str:
    """The content of ``codesign/planners/headlines.json``."""
    kept = {point.value: catalog.headlines_of(point) for point in registered() if is_ours(point)}
    return json.dumps(kept, indent=1, ensure_ascii=False) + "\n"
