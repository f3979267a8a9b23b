"""Studies on broken machines: kills at any moment, killing points, full disks, damaged files; nothing is lost, nothing twice."""

import json
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from conftest import single_pair
from test_study import computed

import geartrain as gt
from geartrain.studies import study_store
from geartrain.studies.study_command import main
from geartrain.studies.study_store import Claim, Store
from geartrain.studies.study_worker import STOPPED, compute_batch

pytestmark = pytest.mark.full

POINTS = 30
KEEP = ["jumps", "largest rms", "frequency"]


def study(points=POINTS, first=0.3):
    space = gt.Space({"input_torque": np.linspace(first, 0.5, points)})
    return gt.Study(single_pair(0.4, stiffness_cos=[0.3]), space, keep=KEEP, response={"start": 0.4, "stop": 1.2})


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return study().run(tmp_path_factory.mktemp("whole"))


@pytest.fixture
def folder(tmp_path):
    """A study that is begun, a batch for each point."""
    study().prepare(tmp_path / "runs", parts=30)
    return tmp_path / "runs"


def command(folder, *arguments, environment=None):
    return subprocess.Popen(
        [sys.executable, "-m", "geartrain.studies.study_command", folder, *arguments], start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, **(environment or {})},
    )


def kill_all(process):
    """The process and whatever it has started, which is in its session."""
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()


def until_claimed(folder, process):
    """Waits until a process has begun a point, or has ended."""
    deadline = time.monotonic() + 60
    while process.poll() is None and not any((folder / "claims").iterdir()) and time.monotonic() < deadline:
        time.sleep(0.01)


def alive(session):
    """Processes of a session that are no zombies."""
    done = subprocess.run(["ps", "-s", str(session), "-o", "pid=,stat="], capture_output=True, text=True, check=False)
    return [line for line in done.stdout.splitlines() if "Z" not in line]


def is_whole(folder, whole):
    """Nothing lost, nothing twice, the same bits."""
    found = study().run(folder)
    return found.identical(whole) and len(set(computed(folder))) == POINTS


def patched(tmp_path, code):
    """An environment in which every process of Python runs some code when it has imported the plan of a study."""
    (tmp_path / "sitecustomize.py").write_text("import geartrain.studies.study_plan as study_plan\n" + textwrap.dedent(code))
    return {"PYTHONPATH": str(tmp_path)}


def killing(tmp_path, torque, once=False):
    """As `patched`: a point of the study kills the process that computes it, always or once."""
    return patched(tmp_path, f"""
        import os, signal
        compute = study_plan.Plan.compute
        def killing(plan, point):
            mark = {str(tmp_path / "killed")!r}
            if plan.columns[0][point] == {torque!r} and not ({once!r} and os.path.exists(mark)):
                open(mark, "a").write("killed ")
                os.kill(os.getpid(), signal.SIGKILL)
            return compute(plan, point)
        study_plan.Plan.compute = killing
    """)


def test_killed_at_any_moment_and_run_again(folder, whole, times):
    """Each time while points are computed, as long as there are any."""
    moments = random.Random(4)
    for _ in range(times(6, share=2)):
        process = command(folder, "--workers", "2")
        until_claimed(folder, process)
        time.sleep(moments.uniform(0.0, 0.1))
        kill_all(process)
    assert is_whole(folder, whole)


def test_a_killed_worker_costs_nothing(folder, whole, tmp_path):
    environment = killing(tmp_path, float(whole.input_torque[17]), once=True)
    process = command(folder, "--workers", "2", environment=environment)
    said, _ = process.communicate(timeout=120)
    assert process.returncode == 0 and said == f"{POINTS} of {POINTS} points are in {folder}\n"
    assert study().dataset(folder).identical(whole)
    assert len(computed(folder)) == len(set(computed(folder)))


def test_a_point_that_kills_is_set_aside(folder, whole, tmp_path):
    environment = killing(tmp_path, float(whole.input_torque[17]))
    process = command(folder, "--workers", "2", environment=environment)
    said, _ = process.communicate(timeout=120)
    assert process.returncode == 1 and said.endswith("1 of them failed\n")
    found = study().dataset(folder)
    assert found.status[17] == "set aside" and "by signal 9 (Killed)" in str(found.message[17].values)
    rest = np.arange(POINTS) != 17
    assert (found.status[rest] == "done").all() and found["largest rms"][rest].equals(whole["largest rms"][rest])
    assert main([str(folder), "--retry"]) == 0 and study().dataset(folder).identical(whole)


def test_the_workers_of_a_killed_client_end(folder, whole):
    process = command(folder, "--workers", "2")
    deadline = time.monotonic() + 60
    while not computed(folder) and time.monotonic() < deadline:
        time.sleep(0.05)
    process.kill()
    process.communicate()
    deadline = time.monotonic() + 20
    while alive(process.pid) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not alive(process.pid)
    assert not any(Store(folder).claims.iterdir())  # what they had begun is written
    assert is_whole(folder, whole)


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_writes_what_is_done(folder, whole, number, workers):
    process = command(folder, "--workers", str(workers))
    until_claimed(folder, process)
    os.killpg(process.pid, number)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 3 and "the same call goes on from there" in said and "Traceback" not in said, said
    assert is_whole(folder, whole) and not any(Store(folder).suspects.iterdir())


def test_a_stop_amid_the_locks_of_futures(folder, whole, tmp_path):
    """The thread that completes the futures would wait for their locks, and the study for that thread."""
    environment = patched(tmp_path, f"""
        import os, signal
        from concurrent.futures import _base
        enter = _base._AcquireFutures.__enter__
        def stopped(futures):
            enter(futures)
            if len(futures.futures) < {POINTS}:
                os.kill(os.getpid(), signal.SIGTERM)
        _base._AcquireFutures.__enter__ = stopped
    """)
    process = command(folder, "--workers", "2", environment=environment)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 3 and "Traceback" not in said, said
    assert is_whole(folder, whole)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_stop_within_a_finalizer(folder, whole, tmp_path, workers):
    """Python prints the exception of the signal's handler there, and drops it."""
    environment = patched(tmp_path, """
        import os, signal
        compute = study_plan.Plan.compute
        class Last:
            def __del__(self):
                os.killpg(os.getpgrp(), signal.SIGINT)
        def stopped(plan, point):
            if plan.columns[0][point] == plan.columns[0][7]:
                Last()
            return compute(plan, point)
        study_plan.Plan.compute = stopped
    """)
    process = command(folder, "--workers", str(workers), environment=environment)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 3 and "the same call goes on from there" in said, said
    assert is_whole(folder, whole) and not any(Store(folder).suspects.iterdir())


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_amid_a_suspect_sets_nothing_aside(folder, whole, tmp_path, number):
    """The process of its own that computes it gets Ctrl-C too."""
    environment = patched(tmp_path, f"""
        import os, signal, sys, time
        compute = study_plan.Plan.compute
        def slow(plan, point):
            if plan.columns[0][point] == {float(whole.input_torque[17])!r}:
                open({str(tmp_path / "begun")!r}, "w").close()
                time.sleep(60)
            return compute(plan, point)
        study_plan.Plan.compute = slow
    """)
    store = Store(folder)
    (store.suspects / store.plan().key(17).decode()).touch()
    process = command(folder, "--workers", "1", environment=environment)
    deadline = time.monotonic() + 60
    while process.poll() is None and not (tmp_path / "begun").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    os.kill(process.pid, number) if number == signal.SIGTERM else os.killpg(process.pid, number)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 3 and "the same call goes on from there" in said and "Traceback" not in said, said
    assert not alive(process.pid) and is_whole(folder, whole)


def stop_after_a_claim():
    """A process that is told to stop when it has claimed a batch and computes nothing yet."""
    make = Claim.make

    def stopped(path):
        claim = make(path)
        os.kill(os.getpid(), signal.SIGTERM)
        return claim

    Claim.make = stopped


def test_a_stop_at_any_moment_leaves_no_claim(folder):
    store = Store(folder)
    with ProcessPoolExecutor(1, get_context("spawn"), stop_after_a_claim) as pool:
        assert pool.submit(compute_batch, str(folder), store.plan().digest, 0).result() == STOPPED
    assert not any(store.claims.iterdir()) and not any(store.suspects.iterdir()) and not computed(folder)


def test_a_worker_that_is_told_to_end_does(folder):
    """A pool that is broken ends its processes by one signal, and waits for them."""
    store = Store(folder)
    with ProcessPoolExecutor(1, get_context("spawn"), stop_after_a_claim) as pool:
        assert pool.submit(compute_batch, str(folder), store.plan().digest, 0).result() == STOPPED
        (process,) = pool._processes.values()
        process.join(60)  # as it begins Python anew, on a machine that is busy
        assert process.exitcode == -signal.SIGTERM


def test_a_stop_of_the_client_leaves_no_claim(folder, monkeypatch):
    """Ctrl-C in the midst of a claim in the process of the study itself, which lives on and would count as its owner."""
    make = Claim.make

    def interrupted(path):
        signal.raise_signal(signal.SIGINT)
        return make(path)

    monkeypatch.setattr(Claim, "make", interrupted)
    store = Store(folder)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # dask_jobqueue's exits, where another test imported it
    try:
        with pytest.raises(KeyboardInterrupt):
            compute_batch(str(folder), store.plan().digest, 0)
    finally:
        signal.signal(signal.SIGINT, before)
    assert not any(store.claims.iterdir()) and not any(store.suspects.iterdir()) and not computed(folder)
    monkeypatch.undo()
    assert compute_batch(str(folder), store.plan().digest, 0) == "over"


def test_many_processes_share_a_study(folder, whole):
    processes = [command(folder, "--workers", "1") for _ in range(3)]
    for process in processes:
        process.communicate(timeout=120)
        assert process.returncode == 0
    assert len(computed(folder)) == len(set(computed(folder))) == POINTS
    assert study().dataset(folder).identical(whole)


def test_the_parts_of_an_array_job_make_the_whole(folder, whole):
    for part in range(1, 4):
        assert main([str(folder), "--part", f"{part}/3"]) == 0
        assert len(computed(folder)) == part * POINTS // 3
    assert study().dataset(folder).identical(whole)
    with pytest.raises(SystemExit) as ended:
        main([str(folder), "--part", "4/3"])
    assert ended.value.code == 2


def test_the_status_of_a_folder(folder, capsys, tmp_path):
    assert main([str(folder), "--status"]) == 0
    assert f"points done: 0; to do: {POINTS}" in capsys.readouterr().out
    assert main([str(tmp_path / "nowhere")]) == 4
    assert "nowhere: holds no study" in capsys.readouterr().err


def test_a_damaged_batch_is_told_and_computed_again(folder, whole):
    study().run(folder)
    one, other, third = Store(folder).paths()[:3]
    data = bytearray(one.read_bytes())
    data[len(data) // 2] ^= 1
    one.write_bytes(data)
    other.write_bytes(other.read_bytes()[:1000])
    third.write_bytes(b"")
    lost = POINTS - (len(computed_quietly(folder)))
    with pytest.warns(UserWarning, match=f"{one.name}: is damaged.*count as not computed"):
        found = study().dataset(folder)
    assert (found.status == "missing").sum() == lost > 0
    there = (found.status == "done").values
    assert found["largest rms"][there].equals(whole["largest rms"][there])
    with pytest.warns(UserWarning, match="is damaged"):
        assert study().run(folder).identical(whole)
    assert study().dataset(folder).identical(whole)


def computed_quietly(folder):
    store, keys = Store(folder), []
    for path in store.paths():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("warnings.warn", lambda *_, **__: None)
            batch = store.read(path)
        keys += [] if batch is None else batch.keys.tolist()
    return keys


def test_a_damaged_plan_is_told_and_written_again(folder, whole, capsys):
    path, = (folder / "plans").iterdir()
    path.write_bytes(path.read_bytes()[:2000])
    assert main([str(folder)]) == 4 and "is damaged" in capsys.readouterr().err
    assert study().run(folder).identical(whole) and main([str(folder)]) == 0


def test_a_full_disk_is_told_and_the_rest_kept(folder, whole):
    process = subprocess.run(
        ["bash", "-c", 'ulimit -f 2; exec "$@"', "bash", sys.executable, "-m", "geartrain.studies.study_command", folder,
         "--workers", "1"],
        capture_output=True, text=True, check=False,
    )
    assert process.returncode == 4 and "File too large" in process.stderr, process
    assert not computed(folder) and not any(path.name.endswith(".tmp") for path in (folder / "batches").iterdir())
    assert is_whole(folder, whole)


def test_a_full_file_system_in_memory(folder, whole, tmp_path):
    script = 'mount -t tmpfs -o size=200k none "$1" && cp -r "$2"/. "$1" && ' \
             '"$3" -m geartrain.studies.study_command "$1" --workers 1; ' \
             'echo status $?; rm -f "$1"/batches/*.tmp; cp -r "$1"/batches/. "$2"/batches'
    disk = tmp_path / "disk"
    disk.mkdir()
    arguments = ["unshare", "--map-root-user", "--mount", "sh", "-c", script, "sh", disk, folder, sys.executable]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    if "status" not in done.stdout or "mount" in done.stderr:
        pytest.skip(f"this system mounts nothing for us: {done.stderr}")
    assert "status 4" in done.stdout and "No space left on device" in done.stderr, done
    assert 0 < len(computed(folder)) < POINTS
    assert is_whole(folder, whole)


def test_a_folder_that_vanishes_is_told(folder, whole):
    process = command(folder, "--workers", "2")
    deadline = time.monotonic() + 60
    while not computed(folder) and time.monotonic() < deadline:
        time.sleep(0.05)
    folder.rename(folder.with_name("moved"))
    _, said = process.communicate(timeout=60)
    assert process.returncode == 4 and str(folder) in said and "Traceback" not in said, said
    assert not folder.exists()
    assert is_whole(folder.with_name("moved"), whole)


def test_long_work_is_written_as_it_goes(folder, whole, monkeypatch):
    monkeypatch.setattr("geartrain.studies.study_worker._LONGEST", 0.0)
    study().run(folder)
    assert len(Store(folder).paths()) == POINTS and study().dataset(folder).identical(whole)


def test_a_claim_is_left_alone_while_its_owner_lives(folder, monkeypatch):
    store = Store(folder)
    digest = store.plan().digest
    with store.claim(f"{digest}-000000") as claim:
        assert claim is not None
        assert compute_batch(str(folder), digest, 0) == "busy"
    assert compute_batch(str(folder), digest, 0) == "over"


def test_the_claim_of_another_machine_is_dead_without_a_heartbeat(folder):
    store = Store(folder)
    digest, key = store.plan().digest, store.plan().key(0)
    path = store.claims / f"{digest}-000000"
    owner = {"host": "another machine", "process": 1, "id": "x"}
    path.write_bytes(json.dumps(owner).ljust(160).encode() + key)
    assert compute_batch(str(folder), digest, 0) == "busy"
    long_ago = time.time() - 2 * study_store._STALE
    os.utime(path, (long_ago, long_ago))
    assert compute_batch(str(folder), digest, 0) == "over"
    assert not path.exists() and not store.is_suspect(key)  # it was tried in a process of its own


def test_a_claim_beats(tmp_path, monkeypatch):
    monkeypatch.setattr(study_store, "_HEARTBEAT", 0.05)
    claim = Claim.make(tmp_path / "claim")
    assert claim is not None and json.loads((tmp_path / "claim").read_text()[:160])["host"] == socket.gethostname()[:60]
    with claim:
        os.utime(tmp_path / "claim", (0, 0))
        time.sleep(0.5)
        assert (tmp_path / "claim").stat().st_mtime > 0
    assert Claim.make(tmp_path / "claim") is None


def test_a_broken_pool_of_the_user_is_told(tmp_path, whole, monkeypatch):
    environment = killing(tmp_path, float(whole.input_torque[17]))
    monkeypatch.setenv("PYTHONPATH", environment["PYTHONPATH"])
    with ProcessPoolExecutor(2, get_context("spawn")) as pool, pytest.raises(gt.SolverError, match="goes on"):
        study().run(tmp_path / "runs", pool)
    with pytest.warns(UserWarning, match=f"1 of {POINTS} points failed, the first with killed its process"):
        found = study().run(tmp_path / "runs")  # in this process, which the point would kill were it not suspected
    assert found.status[17] == "set aside" and (found.status != "done").sum() == 1


@pytest.mark.nightly
def test_a_script_without_a_guard_is_told_what_it_lacks(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(textwrap.dedent("""
        import geartrain as gt
        import geartrain.studies.study as study
        study._SMALL, study.cores = 0.0, lambda: 2
        train = gt.Train(
            input_torque=0.4, prime_mover_inertia=0.0, load_inertia=0.0, characteristic_length=1.0, characteristic_frequency=1.0,
            shafts=[gt.Shaft(rigid=True)] * 2,
            meshes=[gt.Mesh(driving_radius=1.0, driven_radius=1.0, driving_inertia=2.0, driven_inertia=2.0, stiffness=1.0)])
        gt.Study(train, gt.Space({"input_torque": [0.1, 0.2, 0.3]}), modes={}, keep=["natural_frequency"]).run("runs")
    """))
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 1 and 'needs the line if __name__ == "__main__":' in done.stderr


def test_a_copied_folder_is_whole(folder, whole, tmp_path):
    study().run(folder)
    shutil.copytree(folder, tmp_path / "copy")
    shutil.rmtree(folder)
    again = gt.read_study(tmp_path / "copy")
    assert again.dataset().identical(whole) and repr(again) == repr(study())
