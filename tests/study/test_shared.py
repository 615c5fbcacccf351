"""Points share what they have in common."""

from __future__ import annotations

from small_maps import Specs

import codesign
from codesign.ground.memo import approximate_bytes
from codesign.inputs import design_point
from codesign.study import explore
from codesign.system.scenarios import simulate


def test_a_study_keeps_what_its_points_have_in_common_once(specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8").partition("explore:")[0]
    text = text.replace("[12, 18]", "[24, 36]")
    text += f"explore: {{axes: {{fpga.part: [XC3S500E-4], relax.iterations: {list(range(1, 201))}}}}}\n"
    specs[1].write_text(text, encoding="utf-8")
    platform, workload = codesign.load_platform(specs[0]), codesign.load_workload(specs[1])
    study = explore(platform, workload, workers=1)
    assert study.feasible == ()
    for point in study.points[::40]:
        assert point.result is not None
        alone = simulate(*design_point(platform, workload, point.axes))
        assert point.result == alone
        assert point.result.model_dump_json() == alone.model_dump_json()
    assert approximate_bytes(study.outcomes) / len(study.points) < 6000
