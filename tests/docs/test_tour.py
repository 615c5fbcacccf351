"""The notebook of the tour is a notebook, was run, and a new run shows the same."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from places import ROOT

import codesign
from docs.make_tour import NOTEBOOK, run_cells

TOUR: dict[str, Any] = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
CODES = [cell for cell in TOUR["cells"] if cell["cell_type"] == "code"]


def texts(outputs: list[dict[str, Any]]) -> list[Any]:
    """What is printed and shown but for pictures: their bytes depend on the libraries that draw."""
    return [
        output.get("text") or {kind: data for kind, data in output["data"].items() if kind != "image/png"}
        for output in outputs
    ]


def test_it_is_a_notebook_of_form_4_5() -> None:
    assert set(TOUR) == {"cells", "metadata", "nbformat", "nbformat_minor"}
    assert (TOUR["nbformat"], TOUR["nbformat_minor"]) == (4, 5)
    ids = [cell["id"] for cell in TOUR["cells"]]
    assert len(ids) == len(set(ids))
    assert all(re.fullmatch(r"[a-zA-Z0-9_-]{1,64}", each) for each in ids)
    for cell in TOUR["cells"]:
        more = {"execution_count", "outputs"} if cell["cell_type"] == "code" else set()
        assert set(cell) == {"cell_type", "id", "metadata", "source"} | more
    assert [cell["execution_count"] for cell in CODES] == list(range(1, len(CODES) + 1))


def test_it_leads_through_all() -> None:
    heads = re.findall(r"^## (\w+)", "\n".join("".join(cell["source"]) for cell in TOUR["cells"]), re.MULTILINE)
    assert heads == ["Load", "Run", "Explore", "Plot", "Trace"]
    assert sum("image/png" in output.get("data", {}) for cell in CODES for output in cell["outputs"]) >= 4
    assert NOTEBOOK.stat().st_size < 400_000


@pytest.mark.slow
def test_a_new_run_shows_the_same(tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    shown = run_cells(TOUR, tmp_path)
    assert [texts(outputs) for outputs in shown] == [texts(cell["outputs"]) for cell in CODES]
    assert (tmp_path / "front.pdf").read_bytes().startswith(b"%PDF")


def test_jupyter_runs_it_too(tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed: the notebook is not run by Jupyter")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed: the notebook is not run by Jupyter")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed: the notebook is not run by Jupyter")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    client = nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}})
    client.execute()
    before, after = (
        [texts(cell.outputs) for cell in each.cells if cell.cell_type == "code"]
        for each in (nbformat.read(NOTEBOOK, as_version=4), notebook)
    )
    assert after == before


def test_the_citation_file_has_what_the_format_asks_for() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors", "type", "version", "license"} <= set(cited)
    assert cited["cff-version"] == "1.2.0"
    assert cited["type"] == "software"
    assert cited["version"] == codesign.__version__
    assert all(set(author) <= {"family-names", "given-names", "name"} for author in cited["authors"])
    for reference in cited["references"]:
        assert {"type", "title", "authors"} <= set(reference)
        assert reference["year"] > 1990
