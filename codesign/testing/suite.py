"""The contract of a plug-in as a suite: every rule against every case, by one call or as tests of pytest."""

from __future__ import annotations

import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from codesign.planners.plug_in import PlugIn
from codesign.testing import members, paths, planner, styles
from codesign.testing.case import Case, Rule

RULES: tuple[Rule, ...] = (*members.RULES, *planner.RULES, *paths.RULES, *styles.RULES)
"""Every rule, those of what is declared first."""

Parameters = Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Breach:
    """A rule that a plug-in breaks, the case that shows it, and how."""

    rule: str
    case: str
    sentence: str

    def __str__(self) -> str:
        return f"{self.rule} ({self.case}): {self.sentence}"


def cases_of(
    plug_in: PlugIn, parameters: Parameters = ({},), problems: Sequence[Any] | None = None
) -> tuple[Case, ...]:
    """One case for each set of parameters.

    Raises:
        ValueError: no parameters, or not two problems where the planner takes problems of its own or some are given.
        InputError: a plug-in without a planner has styles of a planner that is not installed.
    """
    if not parameters:
        raise ValueError("parameters is empty: give at least one set, as in parameters=[{}]")
    found = plug_in.planner
    if found is None:
        from codesign.system import catalog

        owners = sorted({style.planner for style in (*plug_in.styles, *plug_in.task_styles)})
        if not owners:
            raise ValueError("the plug-in holds neither a planner nor a style")
        found = catalog.planner(owners[0])
    if problems is None and found.problem_model is not None:
        raise ValueError(f"planner {found.name} has problems of its own: give two that differ as problems=")
    if problems is not None and len(problems) != 2:
        raise ValueError(f"{len(problems)} problems are given: give two that differ")
    return tuple(Case(plug_in, found, index, given, problems) for index, given in enumerate(parameters))


def broken_rules(
    plug_in: PlugIn, parameters: Parameters = ({},), problems: Sequence[Any] | None = None
) -> tuple[Breach, ...]:
    """Every rule that the plug-in breaks; arguments as for ``check_plug_in``."""
    found = []
    for case in cases_of(plug_in, parameters, problems):
        for each in RULES:
            try:
                if each.applies(case):
                    each(case)
            except AssertionError as wrong:
                found.append(Breach(each.name, str(case), str(wrong) or _raised(wrong)))
            # The code of others: it may raise anything, and the other rules are still checked.
            except Exception as wrong:
                found.append(Breach(each.name, str(case), _raised(wrong)))
    return tuple(found)


def _raised(wrong: Exception) -> str:
    """The exception in a sentence, with the line that raised it."""
    last = traceback.extract_tb(wrong.__traceback__)[-1]
    return f"{type(wrong).__name__} is raised in {Path(last.filename).name}:{last.lineno}: {wrong}"


def check_plug_in(
    plug_in: PlugIn, parameters: Parameters = ({},), problems: Sequence[Any] | None = None
) -> None:
    """Check that a plug-in keeps its contract.

    Args:
        plug_in: what the package registers. Without a planner, its styles are checked with the installed planner.
        parameters: sets of parameters of the planning task as a workload writes them, small enough to run in a moment.
        problems: two problems that differ: what the planner takes, or mappings for its ``problem_model``. By default
            two maps of six rooms, 24 × 32 cells; required where the planner has a ``problem_model``.

    Raises:
        AssertionError: rules are broken; the message names each rule with one sentence.
        ValueError: no parameters, or not two problems.
        InputError: a plug-in without a planner has styles of a planner that is not installed.
    """
    found = broken_rules(plug_in, parameters, problems)
    if found:
        lines = "".join(f"\n- {breach}" for breach in found)
        raise AssertionError(f"the plug-in breaks its contract in {len(found)} places:{lines}")


class PlugInContract:
    """The same as tests of pytest, one for each rule and each set of parameters.

    A subclass in a test module, with a name that begins with ``Test``, says what to check:

        class TestFlood(PlugInContract):
            plug_in = PLUG_IN
            parameters = ({"bits": 12}, {"bits": 5})

    ``parameters`` and ``problems`` are those of ``check_plug_in``.
    """

    plug_in: ClassVar[PlugIn]
    parameters: ClassVar[Parameters] = ({},)
    problems: ClassVar[Sequence[Any] | None] = None

    def pytest_generate_tests(self, metafunc: Any) -> None:
        """Give ``test_contract`` its rules and cases: pytest calls this by its name."""
        if "contract_rule" not in metafunc.fixturenames:
            return
        pairs = [
            (each, case)
            for case in cases_of(self.plug_in, self.parameters, self.problems)
            for each in RULES
            if each.applies(case)
        ]
        ids = [f"{each.name}-{case}" for each, case in pairs]
        metafunc.parametrize(("contract_rule", "contract_case"), pairs, ids=ids)

    def test_contract(self, contract_rule: Rule, contract_case: Case) -> None:
        """The rule holds for the case."""
        contract_rule(contract_case)
