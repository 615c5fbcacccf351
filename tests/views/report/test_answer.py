"""The sentence and the five figures that lead a run, and the sentence that leads an exploration."""

from __future__ import annotations

import pytest
from report_samples import LINKS, a_fleet_result, a_mission, a_mission_result, a_result, a_study, a_task

from codesign.ground.figures import FIGURES
from codesign.inputs.constraint import Constraint
from codesign.planners.interface import Quality
from codesign.system.results.mission import Bottleneck
from codesign.system.results.result import Clock, Result
from codesign.views.report import answer, study_sentence, study_tables
from codesign.views.report.sentences import FIRST, plan_pace_text

PCI = {"pci": LINKS["uart"]}
DIMM = {"external_memory": "dimm"}


def figures(result: Result) -> dict[str, str]:
    return {name: cell.text for name, cell in answer(result).figures}


def all_arriving() -> Result:
    quality = a_result().quality
    assert isinstance(quality, Quality)
    return a_result(
        quality=Quality(**{**vars(quality), "starts_arrived": quality.starts}),
        task=a_task(plan_time_worst_s=0.00321),
        links=PCI,
        places={"load": "host"},
    )


def test_a_plan_in_one_sentence_and_five_figures() -> None:
    assert answer(all_arriving()).sentence == (
        "labyrinth on virtex2-pci (harmonic, bit_serial on fpga) is feasible: worst plan time 3.21 ms; planning on"
        " fpga takes 91 % of the time, link pci takes 9.34 %, host takes <0.01 %: a faster clock of fpga helps first."
    )
    assert figures(all_arriving()) == {
        "worst plan time": "3.21 ms",
        "energy": "4.2 mJ",
        "FPGA power": "1.31 W (1.01 to 1.91)",
        "tightest resource": "block RAMs: 100 %, 144 of 144",
        "starts that arrive": "64 of 64",
    }


@pytest.mark.parametrize("names", FIRST.values())
def test_the_first_figures_are_declared(names: tuple[str, ...]) -> None:
    assert set(names) <= set(FIGURES)
    assert FIGURES[names[0]].unit == "s"


def test_starts_that_do_not_arrive_stand_in_the_verdict() -> None:
    assert "fits, but only 63 of 64 starts arrive: worst plan time –;" in answer(a_result()).sentence


def test_the_time_stands_against_what_is_asked() -> None:
    asked = [Constraint(figure="plan_time_worst_s", at_most=0.005), Constraint(figure="power", at_most=10.0)]
    assert (
        "is feasible: worst plan time 3.21 ms where at most 5 ms is asked for;"
        in answer(all_arriving(), asked).sentence
    )
    tight = [Constraint(figure="plan_time_worst_s", at_most=0.001), Constraint(figure="power", at_most=1.0)]
    sentence = answer(all_arriving(), tight).sentence
    assert "fits, but misses what is asked for (worst plan time at most: 3.21 ms against 1 ms; FPGA power" in sentence
    assert "is feasible" not in sentence


def test_a_design_that_does_not_fit_leads_with_the_reason_and_a_remedy() -> None:
    result = a_result(slices=67_584)
    assert answer(result).sentence.endswith(
        "is not feasible: slices: 67,584 against 33,792; block: at most 36×66 fits."
    )
    shown = figures(result)
    assert shown["tightest resource"] == "slices: 200 %, 67,584 of 33,792"
    assert shown["worst plan time"] == shown["starts that arrive"] == "–"


def test_the_reason_that_is_passed_by_the_largest_factor_comes_first() -> None:
    (near,) = a_result(slices=40_000).reasons
    far = near.model_copy(update={"name": "lut4", "demand": 300, "limit": 100, "gap": 200})
    result = a_result(slices=40_000, reasons=(near, far))
    assert "is not feasible: LUT4: 300 against 100 and 1 more reason;" in answer(result).sentence


@pytest.mark.parametrize(
    ("busy", "changes", "remedy"),
    [
        ({"fpga": 0.6, "pci": 0.4}, {}, "planning on fpga takes 60 % of the time, link pci takes 40 %: a faster clock"),
        ({"fpga": 0.4, "pci": 0.6}, {}, "link pci takes 60 % of the time, planning on fpga takes 40 %: a faster link"),
        ({"fpga": 0.1, "host": 0.9}, {}, "host takes 90 % of the time, planning on fpga takes 10 %: a faster host"),
        ({"fpga": 1.0, "dimm": 0.9}, DIMM, "memory dimm is busy 90 % of it: a faster memory dimm"),
        ({"fpga": 1.0, "dimm": 0.2}, DIMM, "memory dimm is busy 20 % of it: a faster clock of fpga"),
        ({"fpga": 1.0}, {"clock": None}, "planning on fpga takes 100 % of the time: a faster fpga"),
    ],
)
def test_what_helps_a_plan_first(busy: dict[str, float], changes: dict[str, object], remedy: str) -> None:
    result = a_result(utilisation=busy, links=PCI, places={"load": "host", "relax": "fpga"}, **changes)
    assert remedy in plan_pace_text(result)
    assert plan_pace_text(result).endswith(" helps first")


def test_a_clock_at_its_limit_is_not_the_remedy() -> None:
    clock = a_result().clock
    assert clock is not None
    at_limit = Clock(hz=int(clock.limit.value), limit=clock.limit)
    assert "its clock is at the limit of" in plan_pace_text(a_result(clock=at_limit))


def test_a_run_of_no_time_has_no_bottleneck() -> None:
    assert plan_pace_text(a_result(utilisation={"fpga": 0.0})) == ""


def test_a_mission_leads_with_its_end_and_its_figures() -> None:
    result = a_mission_result()
    assert "is feasible: reached after 100 s; 2 missed deadlines; the pace is set by uart" in answer(result).sentence
    assert figures(result) == {
        "mission time": "100 s",
        "mission energy": "2 kJ",
        "replan latency": "200 ms",
        "distance ratio": "1.2",
        "tightest resource": "block RAMs: 100 %, 144 of 144",
    }


def test_a_mission_without_its_goal_is_no_success() -> None:
    result = a_mission_result(mission=a_mission(reached=False, ended="walled in", contacts=1))
    sentence = answer(result).sentence
    assert "fits, but the mission ends without its goal: walled in after 100 s; 1 contact, 2 missed" in sentence
    assert figures(result)["mission time"] == "–"


def test_the_lever_of_a_mission_is_told_as_what_helps() -> None:
    text = "body.baud 9,600 → 19,200: 60 s in place of 100 s. 1 of the 4 levers help"
    lever = Bottleneck(name="body", kind="lever", share=0.4, text=text)
    sentence = answer(a_mission_result(mission=a_mission(bottleneck=lever))).sentence
    assert sentence.endswith("; what helps first is body.baud 9,600 → 19,200: 60 s in place of 100 s.")


def test_a_fleet_says_whether_robots_collided() -> None:
    assert "2 pairs of robots collide" in answer(a_fleet_result()).sentence
    assert "fits, but only 7 of 8 robots arrive" in answer(a_fleet_result()).sentence
    assert "no robots collided" in answer(a_fleet_result(collisions=0)).sentence
    assert figures(a_fleet_result())["robots that arrive"] == "7 of 8"


def test_no_name_of_a_user_reaches_a_terminal_unchanged() -> None:
    lead = answer(a_result(workload="a\x1b[31mb", notes=("c\x1b[0md",)))
    assert "\x1b" not in lead.text + lead.sentence_text
    assert "note: c\\x1b[0md" in lead.text


def test_an_exploration_in_one_sentence() -> None:
    study = a_study()
    sentence = study_sentence(study)
    assert sentence.startswith(f"{study.workload} on {study.platform}, 24 design points: ")
    assert "; least first plan time: " in sentence
    few, all_of_them = study_tables(study), study_tables(study, everything=True)
    assert few == all_of_them[: len(few)]
    assert {table.title for table in all_of_them} > {"Best in each objective", "Where the figures come from"}
