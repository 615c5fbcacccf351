"""The contract of a plug-in as a suite: every rule against every case, by one call or as tests of pytest."""

from __future__ import annotations

import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from codesign.planners.plug_in import PlugIn
from codesign.system import catalog
from codesign.testing.case import Case, Rule
from codesign.testing.rules import RULES


@dataclass(frozen=True)
class Breach:
    """A rule that a plug-in breaks, the case that shows it, and a sentence on it."""

    rule: str
    case: str
    sentence: str

    def __str__(self) -> str:
        return f"{self.rule} ({self.case}): {self.sentence}"


def cases_of(plug_in: PlugIn) -> tuple[Case, ...]:
    """One case for each set of parameters of the plug-in's samples.

    Raises:
        ValueError: no parameters; or not two problems, where the planner has problems of its own or samples give some.
        InputError: a plug-in without a planner has styles of a planner that is not installed.
    """
    parameters, problems = plug_in.samples.parameters, plug_in.samples.problems
    if not parameters:
        raise ValueError("samples.parameters is empty: give at least one set, as in Samples(parameters=[{}])")
    planner = plug_in.planner
    if planner is None:
        owners = sorted({style.planner for style in (*plug_in.styles, *plug_in.task_styles)})
        if not owners:
            raise ValueError("the plug-in holds neither a planner nor a style")
        planner = catalog.planner(owners[0])
    if problems is None and planner.problem_model is not None:
        text = f"planner {planner.name} has problems of its own: give two that differ as samples.problems"
        raise ValueError(text)
    if problems is not None and len(problems) != 2:
        raise ValueError(f"samples.problems holds {len(problems)}: give two that differ")
    return tuple(Case(plug_in, planner, index, given, problems) for index, given in enumerate(parameters))


def broken_rules(plug_in: PlugIn, rules: Sequence[Rule] = RULES) -> tuple[Breach, ...]:
    """Every rule, of all or of some, that the plug-in breaks. Raises as ``cases_of``."""
    breaches = []
    for case in cases_of(plug_in):
        for each in rules:
            try:
                if each.applies(case):
                    each(case)
            except AssertionError as wrong:
                breaches.append(Breach(each.name, str(case), str(wrong) or _raised(wrong)))
            # The code of others: it may raise anything, and the other rules are still checked.
            except Exception as wrong:
                breaches.append(Breach(each.name, str(case), _raised(wrong)))
    return tuple(breaches)


def _raised(wrong: Exception) -> str:
    last = traceback.extract_tb(wrong.__traceback__)[-1]
    return f"{type(wrong).__name__} is raised in {Path(last.filename).name}:{last.lineno}: {wrong}"


def check_plug_in(plug_in: PlugIn) -> None:
    """Check that a plug-in keeps its contract, on its ``samples``.

    Without a planner, its styles are checked with the installed planner.

    Raises:
        AssertionError: rules are broken; the message names each rule with one sentence.
        ValueError: the samples have no parameters, or not two problems.
        InputError: a plug-in without a planner has styles of a planner that is not installed.
    """
    breaches = broken_rules(plug_in)
    if breaches:
        lines = "".join(f"\n- {breach}" for breach in breaches)
        raise AssertionError(f"the plug-in breaks its contract in {len(breaches)} places:{lines}")


class PlugInContract:
    """The contract as tests of pytest, one for each rule and each set of parameters.

    A subclass in a test module, with a name that begins with ``Test``, names the plug-ins to check:

        class TestFlood(PlugInContract):
            plug_ins = (PLUG_IN,)

    By default every installed plug-in is checked.
    """

    plug_ins: ClassVar[Sequence[PlugIn] | None] = None

    def pytest_generate_tests(self, metafunc: Any) -> None:
        """Give ``test_contract`` its rules and cases: pytest calls this by its name."""
        if "contract_rule" not in metafunc.fixturenames:
            return

        plug_ins = catalog.plug_ins() if self.plug_ins is None else self.plug_ins
        pairs = [
            (each, case) for plug_in in plug_ins for case in cases_of(plug_in) for each in RULES if each.applies(case)
        ]
        ids = [f"{each.name}-{case}" for each, case in pairs]
        metafunc.parametrize(("contract_rule", "contract_case"), pairs, ids=ids)

    def test_contract(self, contract_rule: Rule, contract_case: Case) -> None:
        """The rule holds for the case."""
        contract_rule(contract_case)
