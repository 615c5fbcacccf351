"""``python -m codesign`` does what ``hwsw`` does."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line; an interrupt while it still loads ends it without a traceback."""
    try:
        from codesign.cli import main as command

        command(prog_name="hwsw")
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
