"""The table of docs/rtl.md says of every style on an FPGA whether it has a circuit."""

from __future__ import annotations

from places import ROOT

from codesign.system import catalog


def test_the_table_names_every_style_on_an_fpga() -> None:
    planners = catalog.planners()
    circuits = catalog.circuits()
    styles = {
        (planner, planners[planner].planning_task, name): (planner, name, "") in circuits
        for (planner, name), style in catalog.architectures().items()
        if style.component_type == "fpga"
    }
    styles |= {
        (planner, task, name): (planner, name, task) in circuits
        for planner, task, kind, name in catalog.task_styles()
        if kind == "fpga"
    }
    page = (ROOT / "docs" / "rtl.md").read_text(encoding="utf-8")
    lines = page.partition("## What has RTL")[2].partition("\n## ")[0].splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")][1:]
    written = {(row[0], row[1].strip("`"), row[2].strip("`")): row[3] == "yes" for row in rows}
    assert written == styles
    assert all(row[4] for row in rows if row[3] == "no"), "what to do instead"
