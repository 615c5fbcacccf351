"""The behaviour suite of plug-ins: the contract that planners and styles keep, ours and others'.

``check_plug_in(PLUG_IN)`` checks everything in one call. ``PlugInContract`` is the same as a class of tests for pytest.
It checks every installed plug-in if it names none. Neither needs pytest to be installed.
"""

from codesign.testing.case import Case, Rule
from codesign.testing.rules import RULES
from codesign.testing.suite import Breach, PlugInContract, broken_rules, cases_of, check_plug_in

__all__ = ["RULES", "Breach", "Case", "PlugInContract", "Rule", "broken_rules", "cases_of", "check_plug_in"]
