"""The shipped suite names the rule that a plug-in breaks: every rule has a plug-in here that breaks it."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from broken_plug_ins import PLANNER, RULE_BREAKERS, altered, planner, raising, styles, tasks, work_elsewhere
from rtl_tools import needs

from codesign.planners.breadth_first.plug_in import PLUG_IN
from codesign.planners.velocity_obstacle.plug_in import PLUG_IN as ROBOTS
from codesign.plugin import PlugIn, Problem, Samples
from codesign.testing import RULES, PlugInContract, broken_rules, cases_of, check_plug_in


@pytest.mark.parametrize(
    ("name", "words", "plug_in"), RULE_BREAKERS, ids=[f"{name}-{words}" for name, words, _ in RULE_BREAKERS]
)
def test_a_broken_rule_is_named(name: str, words: str, plug_in: PlugIn) -> None:
    if name == "circuits_report_what_the_model_expects":
        needs("cxxrtl")
    (rule,) = (each for each in RULES if each.name == name)
    sentences = [breach.sentence for breach in broken_rules(plug_in, [rule])]
    assert any(words in sentence for sentence in sentences), sentences


def test_every_rule_can_be_broken() -> None:
    assert {name for name, _, _ in RULE_BREAKERS} == {each.name for each in RULES}
    assert len({each.name for each in RULES}) == len(RULES)


def test_a_plug_in_that_is_altered_in_nothing_is_sound() -> None:
    check_plug_in(replace(styles(), planner=altered(PLANNER, {}), task_styles=tasks().task_styles))


def test_styles_for_somebody_elses_planner_are_checked_with_it() -> None:
    check_plug_in(PlugIn(styles=PLUG_IN.styles[:1]))
    check_plug_in(PlugIn(task_styles=PLUG_IN.task_styles))
    only = PlugIn(styles=work_elsewhere(lambda given: True).styles)
    assert "work_drained_ends_in_the_plan" in {breach.rule for breach in broken_rules(only)}


def test_all_breaches_are_listed_at_once() -> None:
    broken = planner(memory=raising, planning_task="search", description="It plans.")
    with pytest.raises(AssertionError, match="breaks its contract in 4 places") as wrong:
        check_plug_in(broken)
    lines = str(wrong.value).splitlines()[1:]
    assert [line.split(":")[0] for line in lines] == [
        f"- {rule} (breadth_first-{index})"
        for index in (0, 1)
        for rule in ("planner_names_its_planning_task", "planner_members_have_their_types")
    ]


@pytest.mark.parametrize(
    ("plug_in", "what"),
    [
        (replace(PLUG_IN, samples=Samples(parameters=[])), "parameters is empty"),
        (replace(PLUG_IN, samples=Samples(problems=[1])), "samples.problems holds 1"),
        (replace(ROBOTS, samples=Samples()), "problems of its own"),
        (PlugIn(), "neither a planner nor a style"),
    ],
)
def test_samples_that_check_nothing_are_refused(plug_in: PlugIn, what: str) -> None:
    with pytest.raises(ValueError, match=what):
        check_plug_in(plug_in)


def test_problems_of_the_author_replace_the_rooms() -> None:
    free = np.ones((5, 7), bool)
    problems = [Problem(free, ((0, 0),), (start,)) for start in ((4, 6), (4, 5))]
    plug_in = replace(PLUG_IN, samples=Samples(problems=problems))
    (case,) = cases_of(plug_in)
    assert [case.problem.digest, case.other_problem.digest] == [problem.digest for problem in problems]
    check_plug_in(plug_in)


@dataclass
class Metafunc:
    """As much of pytest's as the suite uses."""

    fixturenames: tuple[str, ...]
    pairs: Any = ()
    ids: Any = ()

    def parametrize(self, names: tuple[str, ...], pairs: Any, ids: Any) -> None:
        assert names == self.fixturenames
        self.pairs, self.ids = pairs, ids


def test_the_class_runs_what_the_call_runs() -> None:
    contract = type("Contract", (PlugInContract,), {"plug_ins": (PLUG_IN,)})()
    asked = Metafunc(("contract_rule", "contract_case"))
    contract.pytest_generate_tests(asked)
    cases = cases_of(PLUG_IN)
    assert [rule for rule, _ in asked.pairs] == [rule for case in cases for rule in RULES if rule.applies(case)]
    assert asked.ids[0] == f"{RULES[0].name}-breadth_first-0"
    for rule, each in asked.pairs:
        contract.test_contract(rule, each)
    other = Metafunc(("tmp_path",))
    contract.pytest_generate_tests(other)
    assert other.pairs == ()


CONTRACT = """
from dataclasses import replace
from codesign.planners.breadth_first.plug_in import PLUG_IN as SOUND
from codesign.plugin import Samples
from codesign.testing import PlugInContract

class Negative(type(SOUND.planner)):
    def memory(self, job):
        return -1

class TestNegative(PlugInContract):
    plug_ins = (replace(SOUND, planner=Negative(), samples=Samples()),)
"""


def test_pytest_reports_a_failure_by_the_rule(tmp_path: Path) -> None:
    (tmp_path / "test_negative.py").write_text(CONTRACT)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 1
    failed = [line.split(" - ")[0] for line in done.stdout.splitlines() if line.startswith("FAILED")]
    name = "test_contract[planner_members_have_their_types-breadth_first-0]"
    assert failed == [f"FAILED test_negative.py::TestNegative::{name}"]


def test_the_suite_needs_no_pytest() -> None:
    script = (
        "import sys\n"
        "sys.modules['pytest'] = None\n"
        "from codesign.planners.breadth_first.plug_in import PLUG_IN\n"
        "from codesign.testing import check_plug_in\n"
        "check_plug_in(PLUG_IN)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
