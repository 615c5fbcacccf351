"""A column of a study is one line: CSV, frames and Parquet are views of the same columns."""

from __future__ import annotations

import pytest
from recipes import Recipe

COLUMN = """    yield Column("parity", lambda points: points % 2, ("even", "odd"))
    yield Column("twice", lambda points: 2 * points)
"""

VIEWS = """
from pathlib import Path
from codesign import explore, load_platform, load_workload
from codesign.views.report.study_tables import write_study_csv
import csv, pyarrow.parquet as parquet
workload = load_workload("breadth-first")
study = explore(load_platform("virtex4-pci"), workload, store=None, workers=1)
write_study_csv(study, Path("study.csv"))
study.to_parquet("study.parquet")
with open("study.csv", newline="") as file:
    written = [row["twice"] for row in csv.DictReader(file)]
read, frame = parquet.read_table("study.parquet").to_pydict(), study.frame()
print(written == [str(each) for each in read["twice"]], read["twice"] == frame["twice"].tolist())
print(read["twice"][:3], read["parity"] == frame["parity"].tolist())
"""


def test_a_column_is_in_every_view(tmp_path_factory: pytest.TempPathFactory) -> None:
    pytest.importorskip("pyarrow")
    pytest.importorskip("pandas")
    recipe = Recipe(tmp_path_factory.mktemp("tree"), "a column of the CSV, of frames and of Parquet")
    recipe.edit("study/columns.py", ('    yield Column("state"', COLUMN))
    assert recipe.python("-c", VIEWS).splitlines() == ["True True", "[0, 2, 4] True"]
