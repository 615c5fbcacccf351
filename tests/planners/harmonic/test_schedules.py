"""Schedules that are found, stages that are promoted, and the start of a first plan, in workloads and on axes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import codesign
from codesign.ground.errors import InputError, SpecError
from codesign.planners.harmonic.plan import relax
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.planner import PLANNER
from codesign.planners.harmonic.styles import ARCHITECTURES
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.system.results.result import Result

RELAX: dict[str, Any] = {"component": "fpga", "block": [10, 20], "iterations": 6, "stop": "schedule_end"}
BEST = {"optimal": {"last": 23, "candidates": [5, 9, 14]}}


def workload_of(folder: Path, *, mapping: Any = None, explore: Any = None, **relax: Any) -> codesign.Workload:
    text = {
        "kind": "workload",
        "name": "halls",
        "planner": "harmonic",
        "problem": {
            "map": {"generate": "rooms", "rows": 20, "columns": 40, "room": [8, 8], "door": 2, "seed": 3},
            "goals": [[2, 2]],
            "starts": {"count": 4},
            "arrive": 0.0,
        },
        "mapping": {"relax": {**RELAX, **relax}, **(mapping or {})},
        **({"explore": explore} if explore else {}),
    }
    file = folder / "halls.yaml"
    file.write_text(yaml.safe_dump(text), encoding="utf-8")
    return codesign.load_workload(file)


def run(folder: Path, platform: str = "virtex4-pci", **relax: Any) -> Result:
    return codesign.simulate(codesign.load_platform(platform), workload_of(folder, **relax))


def relaxing(result: Result) -> int:
    assert result.cycles is not None
    return result.cycles["relax"]


def test_the_result_shows_the_schedule_that_was_found_and_its_proof(tmp_path: Path) -> None:
    result = run(tmp_path, schedule=BEST)
    proof = result.found["relax.schedule"]
    found = result.parameters["relax"]["schedule"]
    assert list(proof["precisions"]) == found  # type: ignore[arg-type]
    assert [stage.precision for stage in result.stages or ()] == found
    assert proof["cycles"] == relaxing(result)
    assert (proof["schedules"], proof["stages"]) == (8, 10)
    accounted = [proof[name] for name in ("simulated", "cut_off", "bounded_away")]
    assert sum(int(number) for number in accounted) == 10  # type: ignore[arg-type]
    assert any(f"relax.schedule: {', '.join(map(str, found))}: the best of 8" in note for note in result.notes)
    again = Result.model_validate_json(result.model_dump_json())
    assert again.found == result.found


@pytest.mark.parametrize(
    ("platform", "changes"),
    [
        ("virtex4-pci", {}),
        ("virtex4-pci", {"stop": "first_without_local_maxima"}),
        ("virtex4-pci", {"block": [20, 40], "digit_bits": 4}),
        ("virtex4-pci", {"iterations": 1, "pipeline": 1}),
        ("pc-epyc", {"component": "first", "style": "software"}),
        ("pc-epyc", {"component": "first", "style": "software_limbs"}),
    ],
)
def test_no_schedule_takes_fewer_cycles_of_the_style(tmp_path: Path, platform: str, changes: dict[str, Any]) -> None:
    components = codesign.load_platform(platform).components
    if "component" in changes:
        changes["component"] = next(iter(components))
    best = run(tmp_path, platform, schedule=BEST, **changes)
    schedules = [[23], [5, 23], [9, 23], [14, 23], [5, 9, 23], [5, 14, 23], [9, 14, 23], [5, 9, 14, 23]]
    times = []
    for schedule in schedules:
        single = run(tmp_path, platform, schedule=schedule, **changes)
        times.append(relaxing(single))
        if schedule == best.parameters["relax"]["schedule"]:
            assert relaxing(single) == relaxing(best)
            assert single.quality == best.quality
    assert relaxing(best) == min(times)


def test_the_schedule_is_found_for_each_point_of_an_axis(tmp_path: Path) -> None:
    axes = {"relax.schedule": [[23], BEST, {"first": 5, "step": 5, "last": 23}], "relax.iterations": [1, 6]}
    study = codesign.explore(
        codesign.load_platform("virtex4-pci"), workload_of(tmp_path, schedule=[23], explore={"axes": axes})
    )
    assert not study.failed
    results = [point.result for point in study.points]
    assert all(result is not None for result in results)
    proofs = [result.found for result in results if result is not None and result.found]
    assert len(proofs) == 2
    by_iterations: dict[int, list[Result]] = {}
    for result in results:
        assert result is not None
        by_iterations.setdefault(result.parameters["relax"]["iterations"], []).append(result)
    for group in by_iterations.values():
        assert min(group, key=relaxing).found


def test_a_design_that_does_not_fit_is_not_searched(tmp_path: Path) -> None:
    result = run(tmp_path, schedule={"optimal": {"last": 1023}})
    assert not result.feasible
    assert result.found["relax.schedule"]["reason"] == "not searched, as the design does not fit with any schedule"


def test_a_run_that_stops_early_keeps_its_last_precision(tmp_path: Path) -> None:
    result = run(tmp_path, schedule={"optimal": {"last": 255}}, stop="first_without_local_maxima")
    assert result.parameters["relax"]["schedule"][-1] == 255
    assert result.precision == result.found["relax.schedule"]["run_ends_at"]
    assert result.precision is not None
    assert result.precision < 255


FAULTS: list[tuple[dict[str, Any], str, str]] = [
    ({"schedule": "optimal"}, "schedule: the best schedule needs its last precision", "{optimal: {last: 63}}"),
    ({"schedule": {"optimal": {"candidates": [7]}}}, "schedule.optimal.last: missing", "add this key"),
    (
        {"schedule": {"optimal": {"last": 31, "candidates": [15, 7]}}},
        "schedule.optimal.candidates[1]: precision 7 follows 15",
        "precisions rise",
    ),
    (
        {"schedule": {"optimal": {"last": 31, "candidates": [7, 31]}}},
        "schedule.optimal.candidates[1]: candidate 31 is not below the last precision, 31",
        "before the last stage",
    ),
    (
        {"schedule": {"optimal": {"last": 31, "candidates": []}}},
        "schedule.optimal.candidates: an empty list of candidates",
        "at least one",
    ),
    (
        {"schedule": {"optimal": {"last": 1023, "candidates": {"first": 1, "step": 1}}}},
        "schedule.optimal.candidates: 1022 candidates are too many",
        "at most 128",
    ),
    ({"schedule": BEST, "termination": "published"}, "termination: termination published: costs", "sound"),
    ({"schedule": BEST, "promote": {"after": 2}}, "promote: promoted stages: costs", "never"),
    ({"schedule": [7, 23], "promote": 3}, "promote: 3 is no promotion", "{after: 3}"),
    ({"schedule": [7, 23], "promote": {"after": 0}}, "promote.after", "1"),
    (
        {"schedule": [7, 23], "promote": {"after": 2}, "termination": "published"},
        "promote: termination published: a stage from a promoted one",
        "termination: sound",
    ),
    ({"schedule": [7, 23], "start": "lower_bound"}, "start: lower_bound is made by task lower_bound", "start"),
]


@pytest.mark.parametrize(("changes", "what", "hint"), FAULTS)
def test_faults_have_their_place_and_a_remedy(tmp_path: Path, changes: dict[str, Any], what: str, hint: str) -> None:
    with pytest.raises(SpecError) as caught:
        run(tmp_path, **changes)
    (fault,) = caught.value.faults
    assert f"{fault.key}: {fault.what}".startswith(f"mapping.relax.{what}")
    assert fault.line > 0
    assert hint in f"{fault.what} {fault.hint}"


def test_a_style_without_a_search_is_a_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(type(ARCHITECTURES[0]), "find", lambda _style, _job: None)
    with pytest.raises(SpecError, match="style bit_serial has no search for it") as caught:
        run(tmp_path, schedule=BEST)
    assert caught.value.faults[0].key == "mapping.relax.schedule"


def test_a_plan_waits_for_its_schedule() -> None:
    parameters = RelaxParameters.model_validate({"block": (3, 3), "iterations": 2, "schedule": BEST})
    problem = Problem(np.ones((3, 3), bool), ((0, 0),), ())
    with pytest.raises(InputError, match="not known yet"):
        PLANNER.plan(Job(problem, parameters))


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 10_000),
    st.sampled_from([(9, 13), (3, 4), (4, 13), (1, 1)]),
    st.sampled_from([1, 3, 20]),
    st.integers(1, 6),
)
def test_a_promoted_run_ends_with_the_same_bits(seed: int, block: tuple[int, int], iterations: int, after: int) -> None:
    generator = np.random.default_rng(seed)
    free = generator.random((9, 13)) > 0.25
    free[4, 4] = True
    schedule = [5, 12, 20]

    def field(**promotion: Any) -> Any:
        return relax(free, [(4, 4)], block=block, iterations=iterations, schedule=schedule, **promotion)

    settled, promoted = field(), field(promote_after=dict.fromkeys(schedule[:-1], after))
    assert (promoted.field.limbs == settled.field.limbs).all()
    assert promoted.from_below
    assert not promoted.stages[-1].promoted
    for stage, whole in zip(promoted.stages[:1], settled.stages, strict=False):
        assert stage.promoted is (whole.sweeps > after)
        assert stage.sweeps == min(whole.sweeps, after)


def test_a_promoted_stage_takes_the_same_cycles_visit_by_visit(tmp_path: Path) -> None:
    promoted = {"schedule": [5, 14, 23], "promote": {"after": 1}}
    workload = workload_of(tmp_path, **promoted)
    platform = codesign.load_platform("virtex4-pci")
    system = codesign.system.scenarios.bind(platform, workload)
    style, cycles = system.architecture, []
    for detail in (True, False):
        steps = style.work(Job(system.problem, system.planning, part=system.part, detail=detail))
        cycles.append(sum(int(step.cycles.sum()) for step in steps if step.phase == "relax"))
    result = codesign.simulate(platform, workload)
    assert cycles == [relaxing(result)] * 2
    assert [stage.promoted for stage in result.stages or ()] == [True, True, False]
    settled = run(tmp_path, schedule=[5, 14, 23])
    assert result.quality == settled.quality
    assert relaxing(result) != relaxing(settled)


def test_a_promoted_stage_never_ends_a_run() -> None:
    free = np.ones((6, 6), bool)
    plan = relax(
        free,
        [(0, 0)],
        block=(6, 6),
        iterations=2,
        schedule=[8, 16],
        stop_without_local_maxima=True,
        promote_after={8: 8},
    )
    assert plan.stages[0].promoted
    assert plan.precision == 16


def test_no_circuit_promotes_early(tmp_path: Path) -> None:
    from codesign.planners.harmonic.plug_in import PLUG_IN

    system = codesign.system.scenarios.bind(
        codesign.load_platform("virtex4-pci"), workload_of(tmp_path, schedule=[7, 23], promote={"after": 2})
    )
    with pytest.raises(SpecError, match="no circuit leaves a stage before it has settled"):
        PLUG_IN.circuits[0].circuit(system.job)


def test_the_start_of_a_first_plan_is_an_axis(tmp_path: Path) -> None:
    warm = {"mapping": {"lower_bound": {"component": "host"}}, "schedule": [7, 15, 23]}
    results = {start: run(tmp_path, **warm, start=start) for start in ("zero", "lower_bound", None)}
    assert [stage.precision for stage in results["zero"].stages or ()] == [7, 15, 23]
    assert [stage.precision for stage in results["lower_bound"].stages or ()] == [23]
    assert results[None].stages == results["lower_bound"].stages
    assert results["zero"].quality == results["lower_bound"].quality
    assert relaxing(results["lower_bound"]) < relaxing(results["zero"])
    found = run(tmp_path, **{**warm, "schedule": BEST}, start="lower_bound")
    assert found.parameters["relax"]["schedule"] == [23]
    assert "one stage" in str(found.found["relax.schedule"]["reason"])
