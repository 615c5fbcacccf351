"""Programs of others read our traces: the doctor of pymcap-cli, Rerun's converter, mcap-protobuf-support.

They are the extra ``viewers``. Where one is not installed, its tests are skipped, and say so.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from trace_samples import a_mission, a_run, write

from codesign.ground.records import Record
from codesign.views.trace import open_trace

TRACES = pytest.mark.parametrize("records", [a_run(), a_mission()], ids=["run", "mission"])


def program(name: str) -> str:
    """The path of a program, beside this Python or on the path; without it the test is skipped."""
    beside = Path(sys.executable).with_name(name)
    found = str(beside) if beside.exists() else shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not installed: pip install codesign[viewers]")
    return found


@TRACES
def test_the_doctor_of_pymcap_finds_nothing(tmp_path: Path, records: list[Record]) -> None:
    path = write(tmp_path / "run.mcap", records)
    done = subprocess.run([program("pymcap-cli"), "doctor", path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@TRACES
def test_the_embedded_schemas_decode_every_message(tmp_path: Path, records: list[Record]) -> None:
    decoder = pytest.importorskip(
        "mcap_protobuf.decoder", reason="mcap-protobuf-support is not installed: pip install codesign[viewers]"
    )
    from mcap.reader import make_reader

    path = write(tmp_path / "run.mcap", records)
    with path.open("rb") as stream:
        reader: Any = make_reader(stream, validate_crcs=True, decoder_factories=[decoder.DecoderFactory()])
        decoded = [item.decoded_message for item in reader.iter_decoded_messages()]
    assert len(decoded) == open_trace(path).messages
    assert all(message.ListFields() or type(message).__name__ for message in decoded)


@TRACES
def test_rerun_draws_map_poses_paths_and_log(tmp_path: Path, records: list[Record]) -> None:
    """Rerun's own converter makes archetypes that it draws; each entity by its topic."""
    rerun = program("rerun")
    path = write(tmp_path / "run.mcap", records)
    recording = tmp_path / "run.rrd"
    converted = subprocess.run(
        [rerun, "mcap", "convert", path, "-o", recording], capture_output=True, text=True, check=False
    )
    assert converted.returncode == 0, converted.stderr
    printed = subprocess.run([rerun, "rrd", "print", recording], capture_output=True, text=True, check=True)
    shown = printed.stdout + printed.stderr
    chunks = [line for line in shown.splitlines() if line.startswith("Chunk(") and "McapChannel:" not in line]
    topics = {line.split(" - ")[1].strip() for line in chunks}
    drawn = {topic for topic in topics if not topic.startswith("/__")}
    expected = {
        channel.topic
        for channel in open_trace(path).channels
        if channel.schema.removeprefix("foxglove.") in ("VoxelGrid", "PointCloud", "FrameTransforms", "Log")
    }
    assert expected <= drawn
    for name in ("VoxelGridMap:voxel_indices", "Points3D:positions"):
        assert name in shown
    if any(channel.topic == "/tf" for channel in open_trace(path).channels):
        assert "Transform3D:translation" in shown
        assert "TextLog:text" in shown
