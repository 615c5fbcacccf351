"""What an answer says of a host that declares load and jitter."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml

from codesign.inputs.files import data_folder


def test_an_answer_that_is_proved_to_a_percentile_says_so(tmp_path: Path, hwsw: Callable[..., Any]) -> None:
    """The upper end of the time is the 99th percentile: no worst case is proved of a program beside others."""
    said = {}
    for name, keys in (("quiet", {}), ("late", {"load": 0.2, "jitter": {"median": 1.05, "p99": 1.5}})):
        platform = yaml.safe_load((data_folder("platforms") / "raspberry-pi-4.yaml").read_text())
        platform["components"]["host"] |= keys
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(platform))
        done = hwsw("advise", "house", "--goal", "133,144", "--rate", "100Hz", "--boards", tmp_path / f"{name}.yaml")
        assert done.exit_code == 0, done.output
        said[name] = done.stdout
    assert "host.pace" not in said["quiet"]
    assert "holds at every value" in said["late"]
    assert "with host.pace at its least (jitter counts to its 99th percentile)" in said["late"]
