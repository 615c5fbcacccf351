"""The parameters that a planner can be given, as tables."""

from __future__ import annotations

from collections.abc import Sequence

from codesign.system import PlannerFacts
from codesign.system.inspect import Parameter
from codesign.views.report.table import Table, left, words


def settings_table(settings: Sequence[Parameter]) -> Table:
    """The settings of the papers' runs that ``hwsw reproduce --set`` moves."""
    rows = tuple(words(each.task, each.name, each.accepted, each.meaning) for each in settings)
    return Table("Settings of the papers' runs", left("planner", "setting", "accepted", "meaning"), rows)


def planner_tables(facts: PlannerFacts) -> tuple[Table, ...]:
    """The parameters of a planner's tasks, its styles, and its policies for planning again."""
    parameters = [(each.task, each.name, each.accepted, each.default, each.meaning) for each in facts.parameters]
    policies = [(policy, "" if number else "default") for number, policy in enumerate(facts.policies)]
    tables = (
        Table(
            "Parameters: in a workload mapping.TASK.PARAMETER, with --set TASK.PARAMETER",
            left("task", "parameter", "accepted", "default", "meaning"),
            tuple(words(*row) for row in parameters),
        ),
        Table("Styles", left("style", "what it is"), tuple(words(*row) for row in facts.styles.items())),
        Table("Policies for planning again", left("policy", ""), tuple(words(*row) for row in policies)),
    )
    return tuple(table for table in tables if table.rows)
