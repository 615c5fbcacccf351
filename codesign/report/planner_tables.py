"""What a planner can be given, as tables."""

from __future__ import annotations

from codesign.report.table import Table, left, words
from codesign.system import PlannerFacts


def planner_tables(facts: PlannerFacts) -> tuple[Table, ...]:
    """The parameters of a planner's tasks, its styles, and its policies for planning again."""
    parameters = [
        (each.task, each.name, each.accepted, each.default, each.meaning) for each in facts.parameters
    ]
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
