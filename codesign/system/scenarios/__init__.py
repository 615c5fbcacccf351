"""From specs to a result: bind, fit, build, run. Each scenario of a workload has a room here.

``simulate(platform, workload)`` does all four. ``SCENARIOS`` (``run``) lists the scenarios: a room derives from
``scenario.Scenario`` and answers what binding and a run ask of it. Watching is separate: a listener takes records and
changes nothing.
"""

from codesign.system.scenarios.run import SCENARIOS, bind, check_files, outlook, scenario_of, simulate, simulate_system

__all__ = ["SCENARIOS", "bind", "check_files", "outlook", "scenario_of", "simulate", "simulate_system"]
