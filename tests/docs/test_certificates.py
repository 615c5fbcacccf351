"""docs/certificates.md: its commands print what it shows, and a reader made from the page alone agrees."""

from __future__ import annotations

import hashlib
import json
import re
import shlex
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tampering
from click.testing import Result
from places import ROOT

from codesign.study.certificates.file import read_certificate

TEXT = (ROOT / "docs" / "certificates.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```sh\n(.*?)\n```\n\n```text\n(.*?)```", TEXT, re.DOTALL)
COLUMNS = ["design", "claim", "by", "task", "figures", "budgets", "part", "low", "high", "name", "demand", "limit"]


def lines(text: str) -> list[str]:
    return [" ".join(line.split()) for line in text.splitlines()]


@pytest.mark.slow
def test_commands_print_what_the_page_shows(hwsw: Callable[..., Result], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    assert len(EXAMPLES) == 6
    for command, shown in EXAMPLES:
        program, *arguments = shlex.split(command)
        assert program == "hwsw"
        result = hwsw(*arguments)
        assert result.exit_code == 0
        printed = lines(result.stdout)
        for line in lines(shown):
            assert line == "..." or line in printed
    refused = re.search(r"```text\n\$ hwsw (.*?)\n(.*?)```", TEXT, re.DOTALL)
    assert refused is not None
    result = hwsw(*shlex.split(refused[1]))
    assert (result.exit_code, result.stderr) == (3, refused[2])
    row = re.search(r'\["design"\] == (\d+)\].*?\n(\d+)\n', TEXT, re.DOTALL)
    assert row is not None
    columns = read_certificate(Path("tiles.front")).columns
    entry = int(np.flatnonzero(columns["design"] == int(row[1]))[0])
    assert columns["claim"][entry] == 1
    assert columns["design"][columns["by"][entry]] == int(row[2])


def test_a_reader_made_from_the_page_agrees(tmp_path: Path) -> None:
    content = tampering.sample_file()
    path = tmp_path / "certificate"
    path.write_bytes(content)
    with zipfile.ZipFile(path) as archive:
        assert archive.comment.decode() == hashlib.sha256(content[:-64]).hexdigest()
        names = archive.namelist()
        texts = [archive.read(name) for name in names[:3]]
    assert names == ["definition.json", "head.json", "digests.json", *(f"{name}.npy" for name in COLUMNS)]
    columns: dict[str, Any] = dict(np.load(path, allow_pickle=False))
    definition, head, digests = map(json.loads, texts)
    study = hashlib.sha256(texts[0]).hexdigest()
    whole = hashlib.sha256(study.encode() + texts[1])
    for name in COLUMNS:
        whole.update(name.encode() + columns[name].tobytes())
    assert digests == {"study": study, "content": whole.hexdigest()}
    table = re.findall(r"^\| `(\w+)`(?:, `(\w+)`)? \| (\w+) \| ([A-Z× ]+) \|", TEXT, re.MULTILINE)
    sizes = {"R": head["rows"], "E": head["rows"] + head["boxes"], "B": head["boxes"], "S": head["reasons"]}
    sizes |= {"A": len(definition["axes"]), "F": len(definition["figures"]), "G": len(definition["budgets"])}
    described = {name: row[2:] for row in table for name in row[:2] if name}
    assert list(described) == COLUMNS
    for name, (kind, shape) in described.items():
        assert columns[name].dtype == np.dtype(kind).newbyteorder("<")
        assert columns[name].shape == tuple(sizes[size] for size in shape.split(" × "))
    keys = set(re.findall(r"`(\w+)`", TEXT))
    assert keys >= {*definition, *head, *digests}


def test_the_page_counts_the_kinds_of_tampering() -> None:
    counted = re.search(r"certificates in (\d+) ways", TEXT)
    assert counted is not None
    assert int(counted[1]) == len(tampering.ALL)
