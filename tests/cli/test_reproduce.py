"""The published tables on the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import jsonschema
import pytest
from click.testing import Result

Run = Callable[..., Result]


def test_reproduce_runs_every_paper_and_keeps_to_its_schema(hwsw: Run, tmp_path: Path) -> None:
    result = hwsw("reproduce", "--quick", "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout, parse_constant=pytest.fail)
    jsonschema.validate(told, json.loads(hwsw("schema", "reproduction").stdout))
    rows = told["rows"]
    for author in ("Girau", "Vacariu", "Möller", "Dubey", "Saudi"):
        assert any(row["table"].startswith(author) for row in rows), author
