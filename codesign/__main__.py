"""``python -m codesign`` does what ``hwsw`` does."""

from __future__ import annotations

import gc
import sys

_ALLOCATIONS = 20_000
"""Between two searches for circles of garbage. Modules and results make few: 700 costs a tenth of a short command."""


def main() -> None:
    """Run the command line; an interrupt while it still loads ends it without a traceback."""
    from codesign.ground import interrupts
    from codesign.ground.errors import Interrupted

    gc.set_threshold(_ALLOCATIONS, 20, 20)
    try:
        interrupts.end_on_signals()
        from codesign.cli import main as command

        command(prog_name="hwsw")
    except KeyboardInterrupt as fault:
        interrupt = interrupts.struck(fault) or Interrupted
        print(interrupts.word(interrupt), file=sys.stderr)
        sys.exit(interrupt.exit_code)
    finally:
        interrupts.leave_in_peace()


if __name__ == "__main__":
    main()
