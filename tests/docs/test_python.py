"""The examples of docs/python.md pass a strict check of types."""

from __future__ import annotations

import doctest
import subprocess
import sys
from pathlib import Path

import pytest
from places import ROOT


@pytest.mark.slow  # Run by `make lint` too, where mypy has read the package.
def test_the_examples_of_the_page_are_typed(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    script = tmp_path / "page.py"
    script.write_text(doctest.script_from_examples((ROOT / "docs" / "python.md").read_text("utf-8")), "utf-8")
    # The examples follow each other in one script: their names are those of a reader's notebook.
    assert "picture.figure.axes" in script.read_text("utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", "pyproject.toml", script],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
