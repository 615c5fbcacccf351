"""What starts at once loads nothing heavy: time decides no test, so the modules do."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("numpy", "numba", "pydantic", "scipy", "networkx", "matplotlib", "rich", "yaml")


@pytest.mark.parametrize(
    "words",
    [
        ["import codesign"],
        ["sys.argv = ['hwsw', '--help']", "from codesign.__main__ import main", "main()"],
        ["sys.argv = ['hwsw', '--version']", "from codesign.__main__ import main", "main()"],
    ],
    ids=["import", "help", "version"],
)
def test_it_loads_nothing_heavy(words: list[str]) -> None:
    code = ["import sys, atexit", f"heavy = {HEAVY!r}"]
    code += ["atexit.register(lambda: print('loaded', [name for name in heavy if name in sys.modules]))", *words]
    done = subprocess.run([sys.executable, "-c", "\n".join(code)], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "loaded []"
