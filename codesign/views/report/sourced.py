"""The results of a study whose figures have all of its sources."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from codesign.ground.errors import CodesignError
from codesign.study.groups import Groups
from codesign.system.results.result import Result

if TYPE_CHECKING:
    from codesign.study import Study


def sourced_results(study: Study) -> Iterator[Result]:
    """Results that have every source of the figures of a study, in the order of the points.

    Points that were priced differ in clock and power. Their sources follow from the laws of a style and from the part,
    so one point of each kind is simulated; where its files are missing, it is left out.
    """
    outcomes = study.outcomes
    kinds = set()
    for first in Groups.of(outcomes.which).in_turn.firsts.tolist():
        number = int(outcomes.which[first])
        if number < 0:
            continue
        template = outcomes.templates[number]
        yield template
        kind = (
            *(template.platform, template.planner, template.style, template.component, template.part),
            *(template.feasible, *sorted(template.places.items())),
        )
        if number not in outcomes.whole and kind not in kinds:
            kinds.add(kind)
            try:
                result = study.result(first)
            except CodesignError:
                continue
            assert result is not None, "it has a template"
            yield result
