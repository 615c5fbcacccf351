"""The published tables on the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from click.testing import Result

Run = Callable[..., Result]


def test_reproduce_runs_every_paper(hwsw: Run, tmp_path: Path) -> None:
    result = hwsw("reproduce", "--quick", "--json")
    assert result.exit_code == 0, result.output
    rows = json.loads(result.stdout)["rows"]
    for author in ("Girau", "Vacariu", "Möller", "Dubey", "Saudi"):
        assert any(row["table"].startswith(author) for row in rows), author
