"""``hwsw explore --cluster`` as a process: interrupted while a cluster computes, and over TLS."""

from __future__ import annotations

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.local_cluster import ENVIRONMENT, cluster
from codesign.study import load_study

pytestmark = [
    pytest.mark.skipif(
        importlib.util.find_spec("distributed") is None,
        reason="NOT TESTED: the extra cluster is not installed (pip install 'hwsw-codesign[cluster]')",
    ),
    pytest.mark.slow,
]

WORKLOAD = """\
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: maze, rows: 13, columns: 17, seed: 3}
  goals: [[0, 1]]
  starts: {count: 5, seed: 0}
  arrive: 0 # few bits, so that designs fit
mapping:
  relax: {component: fpga, block: [6, 8], iterations: 6, schedule: {first: 4, step: 4, last: 12}}
  decide: {component: fpga}
explore:
  axes:
    relax.block: [[6, 8], [4, 5], [13, 17], [7, 9], [5, 17]]
    relax.iterations: ITERATIONS
    relax.termination: [sound, published]
    fpga.clock: [100 MHz, 150 MHz]
  objectives: [first_plan_s, slices, energy_j]
"""


def command(folder: Path, iterations: str, *words: str) -> list[str]:
    """The command, of a study in the folder."""
    (folder / "small.yaml").write_text(WORKLOAD.replace("ITERATIONS", iterations))
    return [sys.executable, "-m", "codesign", "explore", "virtex4-pci", str(folder / "small.yaml"), *words]


def test_an_interrupt_leaves_the_cluster_free_and_the_points_kept(tmp_path: Path) -> None:
    store = tmp_path / "points.sqlite"
    with cluster(tmp_path) as started:
        words = ("--cluster", started.address, "--store", str(store), "--csv", str(tmp_path / "2.csv"))
        explore = command(tmp_path, "{from: 1, to: 60, step: 1}", *words)
        running = subprocess.Popen(explore, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        try:
            assert running.stderr is not None
            lines = []
            for line in running.stderr:
                lines.append(line)
                if "/1200 points" in line and not line.startswith("0/"):
                    break
            running.send_signal(signal.SIGINT)
            _, errors = running.communicate(timeout=60)
        finally:
            running.kill()
        assert running.returncode == 130, [*lines, errors]
        assert "Traceback" not in errors
        assert "finished points are kept" in errors
        kept = sum(point.state == "done" for point in load_study(store).points)
        assert 0 < kept < 1200
        done = subprocess.run(explore, capture_output=True, text=True, check=True, timeout=300)
        assert f"{kept} from the store" in done.stderr
    alone = command(
        tmp_path, "{from: 1, to: 60, step: 1}", "--workers", "1", "--csv", str(tmp_path / "1.csv"),
        "--store", str(tmp_path / "1.sqlite"),
    )  # fmt: skip
    subprocess.run(alone, capture_output=True, check=True, timeout=300)
    assert (tmp_path / "1.csv").read_bytes() == (tmp_path / "2.csv").read_bytes()


def certificates(folder: Path) -> Path:
    """A configuration of dask with a certificate that signs itself, made by openssl."""
    openssl = shutil.which("openssl")
    if openssl is None:
        pytest.skip("NOT TESTED: openssl is not installed, so there is no certificate for TLS")
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    subprocess.run(
        [openssl, "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1", "-subj", "/CN=127.0.0.1",
         "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", str(key), "-out", str(certificate)],
        check=True, capture_output=True,
    )  # fmt: skip
    roles = "".join(
        f"      {role}: {{cert: {certificate}, key: {key}}}\n" for role in ("scheduler", "worker", "client")
    )
    file = folder / "dask.yaml"
    file.write_text(
        f"distributed:\n  comm:\n    require-encryption: true\n    tls:\n      ca-file: {certificate}\n{roles}"
    )
    return file


def test_a_cluster_over_tls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    settings = certificates(tmp_path)
    encrypted = {**ENVIRONMENT, "DASK_CONFIG": str(settings)}
    with cluster(tmp_path, 2, config=settings) as started:
        assert started.address.startswith("tls://127.0.0.1:")
        words = ("--cluster", started.address, "--store", str(tmp_path / "points.sqlite"))
        explore = command(tmp_path, "[1, 2]", *words)
        done = subprocess.run(explore, capture_output=True, check=False, text=True, env=encrypted, timeout=300)
        assert done.returncode == 0, done.stderr
        assert f"cluster {started.address}: 2 workers on 1 machine" in done.stderr
        assert "40 design points" in done.stdout
        without = subprocess.run(explore, capture_output=True, check=False, text=True, env=ENVIRONMENT, timeout=120)
        assert without.returncode == 2
        assert "needs certificates" in without.stderr
        assert "distributed.comm.tls.ca-file" in without.stderr
        plain = started.address.replace("tls://", "tcp://")
        other = command(tmp_path, "[1, 2]", "--cluster", plain)
        refused = subprocess.run(other, capture_output=True, check=False, text=True, env=ENVIRONMENT, timeout=120)
        assert refused.returncode == 1, refused.stderr
        assert f"no scheduler answers at {plain}" in refused.stderr
        for ran in (without, refused):
            assert "Traceback" not in ran.stderr
        demanded = subprocess.run(other, capture_output=True, check=False, text=True, env=encrypted, timeout=120)
        assert demanded.returncode == 2, demanded.stderr
        assert "Traceback" not in demanded.stderr
        assert "is not encrypted, as dask's configuration requires" in demanded.stderr
        assert "hint: write tls://" in demanded.stderr
    assert os.path.exists(tmp_path / "points.sqlite")
