"""Studies on a real scheduler and real workers, which are killed, on this machine."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import signal
import socket
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from executor_contract import Contract, evaluator, run, works_of
from explore_fakes import AXES, Fake, computed, exploring

import codesign
from benchmarks.local_cluster import Cluster, cluster
from codesign.ground.errors import CodesignError, InputError, RunError
from codesign.inputs import Platform, Workload
from codesign.study import ClusterExecutor, SerialExecutor, explore, load_study
from codesign.study import cluster as cluster_module
from codesign.study.cluster import _address_of
from codesign.study.evaluation import PointByPoint
from codesign.study.space import Space
from codesign.study.store import EntryState
from codesign.study.work_queue import BatchSize

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None,
    reason="NOT TESTED: the extra cluster is not installed (pip install 'hwsw-codesign[cluster]')",
)


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with cluster(tmp_path_factory.mktemp("cluster")) as started:
        yield started


@pytest.fixture(scope="module")
def platform() -> Platform:
    return codesign.load_platform("virtex4-pci")


@pytest.fixture(scope="module")
def workload() -> Workload:
    return exploring(codesign.load_workload("labyrinth"), AXES)


class TestClusterExecutor(Contract):
    @pytest.fixture
    def executor(self, two: Cluster) -> Iterator[ClusterExecutor]:
        with ClusterExecutor(two.address) as executor:
            yield executor

    # Below, on a cluster of its own: a worker cannot be woken.
    test_closing_ends_the_work = None  # type: ignore[assignment]


def test_a_study_of_a_cluster_is_that_of_this_process(
    two: Cluster, platform: Platform, workload: Workload, tmp_path: Path
) -> None:
    log, file = tmp_path / "log", tmp_path / "points.sqlite"
    one = explore(platform, workload, workers=1, evaluate=Fake()).to_json()
    with ClusterExecutor(two.address) as executor:
        study = explore(platform, workload, executor=executor, store=file, evaluate=Fake(log))
    assert study.to_json() == one == load_study(file).to_json()
    assert sorted(computed(log)) == list(range(12))
    assert str(os.getpid()) not in {line.split()[1] for line in log.read_text().splitlines()}


def test_a_client_that_is_handed_in_computes_and_stays_open(
    two: Cluster, platform: Platform, workload: Workload
) -> None:
    from distributed import Client

    with Client(two.address, set_as_default=False) as client:
        study = explore(platform, workload, executor=client, evaluate=Fake())
        assert client.submit(int, "7").result() == 7
    assert study.to_json() == explore(platform, workload, workers=1, evaluate=Fake()).to_json()


def test_both_workers_share_the_work(two: Cluster, tmp_path: Path) -> None:
    log = tmp_path / "log"
    with ClusterExecutor(two.address) as executor:
        run(executor, {"slices": list(range(20))}, log, limit=2, at=dict.fromkeys(range(20), "meet"))
    assert len({line.split()[1] for line in log.read_text().splitlines()}) == 2


def test_every_worker_is_seen_where_dask_names_five(monkeypatch: pytest.MonkeyPatch) -> None:
    """``scheduler_info`` of the lowest release that is accepted names five workers, unless it is asked for more."""
    from distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=8, threads_per_worker=1, processes=False, dashboard_address=None) as local,
        Client(local, set_as_default=False) as client,
    ):
        whole = client.scheduler_info(n_workers=-1)
        five = {**whole, "workers": dict(list(whole["workers"].items())[:5])}
        monkeypatch.setattr(client, "scheduler_info", lambda n_workers=5: whole if n_workers == -1 else five)
        executor = ClusterExecutor(client)
        assert (executor.workers, executor.words) == (8, "8 workers on 1 machine")
        crew = cluster_module.Crew(client, evaluator({}))
        crew.look()
        assert {slot.address for slot in crew.joining} == set(whole["workers"])
        crew.end()


def test_what_computes_travels_once_to_each_worker(two: Cluster, tmp_path: Path) -> None:
    """Each unpickling of the evaluator is noted: two workers, and not one for each of the batches."""
    with ClusterExecutor(two.address) as executor:
        axes = {"slices": list(range(10, 50))}
        run(executor, axes, tmp_path / "log", limit=1)
        evaluate = Noted(tmp_path / "noted")
        list(executor.run(works_of(axes, 1), PointByPoint(evaluate, Space(axes, ""))))
    assert len((tmp_path / "noted").read_text().splitlines()) <= 2


class Noted(Fake):
    """Notes where it is unpickled."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.file = file

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        with self.file.open("a") as file:
            file.write(f"{os.getpid()}\n")


def test_the_first_works_of_a_node_without_kernels_are_announced(tmp_path: Path) -> None:
    """Once in a run, where something is computed, and no more where the node has a kernel."""
    told: list[str] = []
    cache, axes = tmp_path / "cache", {"slices": [10, 11, 12]}
    with cluster(tmp_path, 0) as started:
        started.add(2, NUMBA_CACHE_DIR=str(cache))
        with ClusterExecutor(started.address) as executor:
            executor.compiling = lambda: told.append("compiling")
            run(executor, {"slices": []}, tmp_path / "log", limit=1)
            assert told == []
            run(executor, axes, tmp_path / "log", limit=1)
            assert told == ["compiling"]
            (node,) = (cache / "nodes").iterdir()
            (node / "one.nbi").touch()
            run(executor, axes, tmp_path / "log", limit=1)
    assert told == ["compiling"]


def test_workers_and_an_executor_are_refused_together(platform: Platform, workload: Workload) -> None:
    with pytest.raises(InputError, match="3 local workers and an executor are asked for at once"):
        explore(platform, workload, workers=3, executor=SerialExecutor(), evaluate=Fake())


def test_the_command_line_refuses_both_too(hwsw: Callable[..., Result], specs: tuple[Path, Path]) -> None:
    result = hwsw("explore", *specs, "--workers", 2, "--cluster", "tcp://127.0.0.1:8786")
    assert result.exit_code == 2
    assert "--cluster: --workers is given too\n  hint: keep one of the two" in result.output


@pytest.mark.parametrize(
    "address", ["nowhere", "tcp://host", "http://host:80", "tcp://host:0", "tcp://a b:1", "h:70000"]
)
def test_what_is_no_address(address: str) -> None:
    with pytest.raises(InputError, match="is no address of a scheduler"):
        ClusterExecutor(address)


@pytest.mark.parametrize("content", [None, "{", "[]", '{"id": 1}', "[" * 100_000])
def test_what_is_no_file_of_a_scheduler(tmp_path: Path, content: str | None) -> None:
    file = tmp_path / "scheduler.json"
    if content is not None:
        file.write_text(content)
    with pytest.raises(InputError, match="is no file of a scheduler"):
        ClusterExecutor(str(file))


def test_the_file_of_a_scheduler(two: Cluster) -> None:
    assert _address_of(str(two.file)) == two.address


@pytest.mark.parametrize(
    ("address", "words"),
    [("tcp://127.0.0.1:1", "Connection refused"), ("tcp://no-such-host.invalid:8786", "no-such-host")],
)
def test_a_cluster_that_is_not_there(
    hwsw: Callable[..., Result], specs: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, address: str, words: str
) -> None:
    monkeypatch.setattr("codesign.study.cluster._SECONDS_TO_CONNECT", 1)
    result = hwsw("explore", *specs, "--cluster", address, "--store", "points.sqlite")
    assert result.exit_code == 1, result.output
    assert f"no scheduler answers at {address}" in result.output
    assert "hint: start one with dask scheduler" in result.output
    assert not Path("points.sqlite").exists()


@pytest.mark.parametrize(
    ("content", "words"), [(b"", "nothing came within 1 s"), (b"HTTP/1.0 400 Bad Request" * 4, "is no scheduler")]
)
def test_what_listens_is_no_scheduler(content: bytes, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("codesign.study.cluster._SECONDS_TO_CONNECT", 1)
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        threading.Thread(target=_answer, args=(server, content), daemon=True).start()
        with pytest.raises(RunError, match=f"no scheduler answers at {address}: .*{words}"):
            ClusterExecutor(address)


def _answer(server: socket.socket, content: bytes) -> None:
    """Send the content on one connection, which stays open."""
    connection, _ = server.accept()
    connection.sendall(content)
    time.sleep(5)


def test_tls_without_certificates_names_the_settings() -> None:
    with pytest.raises(CodesignError, match="needs certificates"):
        ClusterExecutor("tls://127.0.0.1:1")


def test_a_cluster_without_a_worker(tmp_path: Path) -> None:
    with (
        cluster(tmp_path, 0) as empty,
        ClusterExecutor(empty.address, patience=0.5) as executor,
        pytest.raises(RunError, match="had no worker for 0 s") as caught,
    ):
        run(executor, {"slices": [1, 2]})
    assert "dask worker tcp://" in str(caught.value)


def test_a_worker_with_other_versions_is_refused_before_any_work(
    two: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster_module.node, "versions", lambda: {"Python": "3.11", "numba": "0.1"})
    with ClusterExecutor(two.address) as executor, pytest.raises(RunError, match=r"here 0\.1") as caught:
        run(executor, {"slices": [1, 2]}, tmp_path / "log")
    assert "cannot compute this\nworker tcp://127.0.0.1" in str(caught.value)
    assert computed(tmp_path / "log") == []


def test_a_worker_with_other_code_is_refused_before_any_work(
    two: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = cluster_module.package_digest
    monkeypatch.setattr(cluster_module, "package_digest", Other(real))
    with ClusterExecutor(two.address) as executor, pytest.raises(RunError, match="other code of codesign"):
        run(executor, {"slices": [1, 2]}, tmp_path / "log")
    assert computed(tmp_path / "log") == []


def test_a_worker_with_other_files_is_refused_before_any_work(two: Cluster, tmp_path: Path) -> None:
    part = tmp_path / "parts" / "mine.yaml"
    evaluate = OfFiles(Fake(tmp_path / "log"), Space({"slices": [1]}, ""))
    evaluate.read = {part: "a digest"}
    with ClusterExecutor(two.address) as executor, pytest.raises(RunError, match="its files differ") as caught:
        list(executor.run(works_of({"slices": [1]}), evaluate))
    assert str(part) in str(caught.value)
    assert computed(tmp_path / "log") == []


class OfFiles(PointByPoint):
    """Reads files, as one says that has them."""

    read: dict[Path, str]

    def files(self) -> dict[Path, str]:
        return self.read


class Other:
    """Another digest here than where it is sent to."""

    def __init__(self, real: Callable[[], str]) -> None:
        self.real, self.here = real, os.getpid()

    def __call__(self) -> str:
        return "other" if os.getpid() == self.here else self.real()


def test_a_worker_that_dies_costs_a_retry_alone(tmp_path: Path) -> None:
    log = tmp_path / "log"
    axes = {"slices": list(range(10, 22))}
    with cluster(tmp_path) as started, ClusterExecutor(started.address) as executor:
        entries = run(executor, axes, log, limit=2, at={7: "kill once"})
    assert {entry.state for entry in entries.values()} == {EntryState.DONE}
    times = Counter(computed(log))
    assert times.keys() == set(range(12))
    assert times[7] == 2


@pytest.mark.slow
@pytest.mark.parametrize("how", ["die", "crash", "kill"])
def test_a_point_that_workers_die_of_fails_alone(tmp_path: Path, how: str) -> None:
    axes = {"do": ["a", "b", "c", "d", how, "e", "f", "g"]}
    with cluster(tmp_path, nanny=True) as started, ClusterExecutor(started.address) as executor:
        entries = run(executor, axes, limit=3)
    found = [entries[point.key] for point in Space(axes, "").points()]
    assert [entry.state for entry in found] == [
        EntryState.FAILED if value == how else EntryState.DONE for value in axes["do"]
    ]
    assert found[4].text.startswith("a worker process died twice while it computed this point\n")


def test_a_scheduler_that_goes_away_ends_the_run_and_loses_nothing(
    platform: Platform, workload: Workload, tmp_path: Path
) -> None:
    log, file = tmp_path / "log", tmp_path / "points.sqlite"
    slow = Fake(log, {11: "sleep"})
    with cluster(tmp_path) as started, ClusterExecutor(started.address) as executor:
        killing = threading.Thread(target=_kill_after, args=(started, log, 5))
        killing.start()
        with pytest.raises(RunError, match=r"the scheduler of the cluster at tcp://.* went away") as caught:
            explore(platform, workload, executor=executor, store=file, evaluate=slow)
        killing.join()
    assert "the same command goes on from there" in str(caught.value)
    finished = {point.index for point in load_study(file).points if point.state == "done"}
    assert finished
    log.unlink()
    whole = explore(platform, workload, workers=1, store=file, evaluate=Fake(log))
    assert set(computed(log)) == set(range(12)) - finished
    assert whole.to_json() == explore(platform, workload, workers=1, evaluate=Fake()).to_json()


def _kill_after(started: Cluster, log: Path, points: int) -> None:
    until = time.monotonic() + 600
    while len(computed(log)) < points and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(0.5)
    started.scheduler.send_signal(signal.SIGKILL)


@pytest.mark.slow
def test_closing_ends_the_work(tmp_path: Path) -> None:
    axes = {"do": ["nothing", *(["sleep"] * 20)]}
    with cluster(tmp_path) as started, ClusterExecutor(started.address) as executor:
        with contextlib.closing(executor.run(works_of(axes, 1), evaluator(axes, tmp_path / "log"))) as coming:
            next(coming)
        time.sleep(0.5)
        # Two sleep, and nothing that was sent ahead is begun any more.
        assert len(computed(tmp_path / "log")) <= 1 + 2


@pytest.mark.slow
def test_a_worker_that_comes_later_helps(tmp_path: Path) -> None:
    log = tmp_path / "log"
    at = dict.fromkeys(range(4, 12), "meet")
    with cluster(tmp_path, 1) as started, ClusterExecutor(started.address) as executor:
        coming = threading.Thread(target=started.add, args=(1,))
        coming.start()
        entries = run(executor, {"slices": list(range(10, 22))}, log, limit=1, at=at)
        coming.join()
    assert len(entries) == 12
    assert len({line.split()[1] for line in log.read_text().splitlines()}) == 2


def test_the_size_of_batches_follows_the_time_of_works() -> None:
    size = BatchSize(0.5)
    assert size.works == 1
    size.take(20.0, 1)  # with the kernels
    assert size.works == 1
    size.take(0.02, 1)
    assert size.works == 4  # one that was quick does not make the next ones so
    size.take(0.16, 8)
    assert size.works == 25
    for _ in range(20):
        size.take(0.25 * size.works, size.works)
    assert size.works == 2


SMALL = """\
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: maze, rows: 13, columns: 17, seed: 3}
  goals: [[0, 1]]
  starts: {count: 5, seed: 0}
  arrive: 0 # few bits, so that many points take little time
mapping:
  relax: {component: fpga, block: [6, 8], iterations: 6, schedule: [7]}
  decide: {component: fpga}
explore:
  axes:
    relax.block: [[6, 8], [4, 5], [13, 17]]
    relax.schedule: [[8], {first: 4, step: 4, last: 12}]
    relax.termination: [sound, published]
    fpga.part: [XC2V6000-4, XC4VLX160-12]
    fpga.clock: [100 MHz, 150 MHz]
  objectives: [first_plan_s, slices, energy_j]
"""


@pytest.mark.slow
def test_the_table_of_a_cluster_with_a_killed_worker_is_that_of_one_process(
    hwsw: Callable[..., Result], tmp_path: Path
) -> None:
    """With kernels: of the workers of a node one compiles at a time, each kernel once."""
    (tmp_path / "small.yaml").write_text(SMALL)
    one = hwsw("explore", "virtex4-pci", "small.yaml", "--workers", 1, "--store", "1.sqlite", "--csv", "1.csv")
    assert one.exit_code == 0, one.output
    cache = tmp_path / "cache"
    with cluster(tmp_path, 0) as started:
        started.add(2, NUMBA_CACHE_DIR=str(cache))
        killing = threading.Thread(target=_kill_when, args=(started, lambda: any(cache.rglob("*.nbi"))))
        killing.start()
        words = ("--cluster", started.address, "--store", "2.sqlite", "--csv", "2.csv")
        two = hwsw("explore", "virtex4-pci", "small.yaml", *words)
        killing.join()
    assert two.exit_code == 0, two.output
    assert two.stderr.count("compiling kernels, once") == 1
    assert (tmp_path / "2.csv").read_bytes() == (tmp_path / "1.csv").read_bytes()
    (node,) = (cache / "nodes").iterdir()
    kernels = [file.name.rpartition(".nbc")[0] for file in node.rglob("*.nbc")]
    assert len(kernels) == len(set(kernels)) > 5
    assert not list(cache.glob("*.nbi"))


def _kill_when(started: Cluster, ready: Callable[[], bool]) -> None:
    """Kill the first worker, in the middle of compiling."""
    until = time.monotonic() + 600
    while not ready() and time.monotonic() < until:
        time.sleep(0.01)
    os.killpg(started.workers[0].pid, signal.SIGKILL)
