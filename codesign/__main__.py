"""``python -m codesign`` does what ``hwsw`` does."""

from __future__ import annotations

import gc
import sys

from codesign.ground.late import late

interrupts = late("codesign.ground.interrupts")
errors = late("codesign.ground.errors")
cli = late("codesign.cli")

_ALLOCATIONS = 20_000
"""Between two searches for circles of garbage. Modules and results make few: 700 costs a tenth of a short command."""


def main() -> None:
    """Run the command line; an interrupt while it still loads ends it without a traceback."""
    gc.set_threshold(_ALLOCATIONS, 20, 20)
    try:
        interrupts.end_on_signals()
        cli.main(prog_name="hwsw")
    except KeyboardInterrupt as fault:
        interrupt = interrupts.struck(fault) or errors.Interrupted
        print(interrupts.word(interrupt), file=sys.stderr)
        sys.exit(interrupt.exit_code)
    finally:
        interrupts.leave_in_peace()


if __name__ == "__main__":
    main()
