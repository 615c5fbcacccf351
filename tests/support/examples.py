"""How thorough tests are: `make test-all` draws new examples and more of them, `make test` few and the same ones."""

from __future__ import annotations

import os

THOROUGH = "HYPOTHESIS_NEW_EXAMPLES" in os.environ


def examples(number: int) -> int:
    """``number`` of examples for ``make test-all``, and a third of them for ``make test``."""
    return number if THOROUGH else -(-number // 3)
