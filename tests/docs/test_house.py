"""The page of the house has the figures that its script counts."""

from __future__ import annotations

import re

from places import ROOT

from docs.count_house import FIGURES, classes, late_imports, modules_of_a_run, type_tests

PAGE = (ROOT / "docs" / "house.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (\D[^|]*) \| ([\d,]+) \| ([\d,]+) \| (yes|no) \|$", PAGE, re.MULTILINE)


def test_the_page_names_what_is_counted_and_what_is_required() -> None:
    rows = {name: int(most.replace(",", "")) for name, _, most, _ in ROWS}
    assert {name: most for name, (_, most) in FIGURES.items()}.items() <= rows.items()


def test_a_figure_is_met_where_it_is_at_most_what_is_required() -> None:
    for name, now, most, met in ROWS:
        assert met == ("yes" if int(now.replace(",", "")) <= int(most.replace(",", "")) else "no"), name


def test_few_places_ask_a_component_or_link_for_its_type() -> None:
    assert type_tests(classes("inputs.components", "inputs.links", "components")) <= 10


def test_the_law_of_a_link_is_named_in_one_file() -> None:
    files = [path for path in (ROOT / "codesign").rglob("*.py") if "BusLink" in path.read_text(encoding="utf-8")]
    assert [path.name for path in files] == ["links.py"]


def test_a_run_loads_what_it_needs_and_no_other_planner() -> None:
    loaded, ran = modules_of_a_run()
    assert loaded <= 250
    assert ran <= 110


def test_few_imports_stand_inside_functions() -> None:
    assert late_imports() <= 60
