"""Studies on Dask: a scheduler and two workers of this machine over TCP; any of them killed, and the client as well."""

import os
import re
import signal
import subprocess
import sys
import time

import pytest
from conftest import ROOT
from test_study import computed
from test_study_faults import POINTS, killing, study

import geartrain as gt

pytestmark = pytest.mark.full

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return study().run(tmp_path_factory.mktemp("whole"))


class Cluster:
    """Processes of a scheduler and its workers."""

    def __init__(self, folder, environment=None):
        self.environment = {**os.environ, **(environment or {})}
        self.folder, self.processes = folder, []
        self.scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        self.address = self.said(r"Scheduler at:\s+(tcp://127.0.0.1:\d+)")
        self.workers = [self.start_worker() for _ in range(2)]

    def start(self, *arguments):
        log = (self.folder / f"{len(self.processes)}.log").open("w")
        process = subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:]], stdout=log,
                                   stderr=log, cwd=self.folder, env=self.environment)
        self.processes.append(process)
        return process

    def start_worker(self):
        return self.start("worker", self.address, "--no-nanny", "--nthreads", "1", "--no-dashboard")

    def said(self, pattern):
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            found = re.search(pattern, (self.folder / "0.log").read_text())
            if found:
                return found[1]
            time.sleep(0.05)
        raise TimeoutError((self.folder / "0.log").read_text())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path):
    with Cluster(tmp_path) as found:
        yield found


def begun(folder):
    study().prepare(folder, parts=30)
    return folder


CLIENT = """
import sys
sys.path.insert(0, {tests!r})
from distributed import Client
import geartrain as gt
from test_study_faults import study
if __name__ == "__main__":
    with Client({address!r}, timeout=30) as client:
        try:
            dataset = study().run({folder!r}, client)
            print("done", int((dataset.status == "done").sum()), flush=True)
        except gt.SolverError as error:
            print("told", error, flush=True)
"""


def client(cluster, folder):
    code = CLIENT.format(address=cluster.address, folder=str(folder), tests=str(ROOT / "test" / "python"))
    path = cluster.folder / "client.py"
    path.write_text(code)
    return subprocess.Popen([sys.executable, path], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for_points(folder, more=1):
    before, deadline = len(computed(folder)), time.monotonic() + 60
    while len(computed(folder)) < before + more and time.monotonic() < deadline:
        time.sleep(0.02)


def test_a_client_of_dask_computes_a_study(cluster, whole, tmp_path):
    folder = begun(tmp_path / "runs")
    with distributed.Client(cluster.address) as connected:
        connected.wait_for_workers(2)
        assert study().run(folder, connected).identical(whole)
    assert len(computed(folder)) == len(set(computed(folder))) == POINTS


@pytest.mark.nightly
def test_a_worker_killed_in_the_midst_costs_nothing(cluster, whole, tmp_path):
    folder = begun(tmp_path / "runs")
    process = client(cluster, folder)
    wait_for_points(folder)
    cluster.workers[0].send_signal(signal.SIGKILL)
    said, errors = process.communicate(timeout=120)
    assert said == f"done {POINTS}\n", errors
    assert study().dataset(folder).identical(whole) and len(set(computed(folder))) == POINTS


@pytest.mark.nightly
def test_a_point_that_kills_its_worker_is_set_aside(whole, tmp_path):
    folder = begun(tmp_path / "runs")
    logs = tmp_path / "logs"
    logs.mkdir()
    with Cluster(logs, killing(tmp_path, float(whole.input_torque[17]))) as cluster:
        process = client(cluster, folder)
        wait_for_points(folder)
        deadline = time.monotonic() + 120
        while process.poll() is None and time.monotonic() < deadline:
            dead = [worker for worker in cluster.workers if worker.poll() is not None]
            if dead:  # as a nanny would
                cluster.workers.remove(dead[0])
                cluster.workers.append(cluster.start_worker())
            time.sleep(0.1)
        said, errors = process.communicate(timeout=10)
    assert said == f"done {POINTS - 1}\n", errors
    found = study().dataset(folder)
    assert found.status[17] == "set aside" and (found.status == "done").sum() == POINTS - 1


@pytest.mark.nightly
def test_the_scheduler_killed_is_told_and_the_study_goes_on(cluster, whole, tmp_path):
    folder = begun(tmp_path / "runs")
    process = client(cluster, folder)
    wait_for_points(folder)
    cluster.scheduler.send_signal(signal.SIGKILL)
    said, errors = process.communicate(timeout=120)
    assert said.startswith("told ") and "the same call goes on from there" in said, (said, errors)
    assert 0 < len(computed(folder)) < POINTS
    logs = tmp_path / "logs"
    logs.mkdir()
    with Cluster(logs) as another, distributed.Client(another.address) as connected:
        assert study().run(folder, connected).identical(whole)
    assert len(set(computed(folder))) == POINTS


@pytest.mark.nightly
def test_the_client_killed_and_run_again(cluster, whole, tmp_path):
    folder = begun(tmp_path / "runs")
    process = client(cluster, folder)
    wait_for_points(folder)
    process.kill()
    process.communicate()
    said, errors = client(cluster, folder).communicate(timeout=120)
    assert said == f"done {POINTS}\n", errors
    assert study().dataset(folder).identical(whole) and len(computed(folder)) == len(set(computed(folder))) == POINTS


@pytest.mark.nightly
def test_a_client_that_cannot_write_the_folder_is_told(cluster, tmp_path):
    folder = begun(tmp_path / "runs")
    process = client(cluster, folder)
    wait_for_points(folder)
    folder.rename(tmp_path / "moved")
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 1 and "FileNotFoundError" in errors and str(folder) in errors


def test_without_dask_its_executors_interface_will_do(cluster, whole, tmp_path):
    with distributed.Client(cluster.address) as connected:
        assert study().run(begun(tmp_path / "runs"), connected.get_executor(pure=False)).identical(whole)
    with pytest.raises(gt.InputError, match=r"a Client of dask\.distributed"):
        study().run(tmp_path / "runs", cluster)
