"""What a study costs beside its computing: concurrent.futures, joblib and Dask against a plain loop, and reading a study back.

    python benchmarks/study.py [--points 10000] [--workers 2] [--repeats 1] [--read 100000]

Responses of figure 3's train within 10 %. Each engine runs in a process of its own, whose CPU time is with that of all processes
it has started. Overhead: that CPU time over the one of the plain loop, less 1; efficiency: the plain loop's time over workers times
wall time, which means something on an idle machine alone. The memory is the peak of the client.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import geartrain as gt
from geartrain.studies.study_plan import Plan
from geartrain.studies.study_store import Record, Store
from geartrain.studies.study_worker import record_of

CASE = Path(__file__).resolve().parent.parent / "namelists" / "fig03.nml"
NAMES = [f"mesh {mesh} {name}" for mesh in (1, 2) for name in ("damping_ratio", "half_backlash", "stiffness")]
RANGE = {"start": 0.2, "stop": 2.6}


def study_of(points):
    """Of the train with each value drawn from within 10 %."""
    sample = np.random.default_rng(0).uniform(0.9, 1.1, (points, len(NAMES)))
    space = gt.Space(sample=sample, names=NAMES, relative=True)
    return gt.Study(gt.read_case(CASE).train, space, response=RANGE, keep=["peaks", "jumps", "largest dynamic_factor"])


def by_plain_loop(points, workers, folder):
    """In one process, as a user would write it."""
    train = gt.read_case(CASE).train
    for values in np.random.default_rng(0).uniform(0.9, 1.1, (points, len(NAMES))):
        meshes = [
            replace(mesh, damping_ratio=mesh.damping_ratio * damping, half_backlash=mesh.half_backlash * gap,
                    stiffness=mesh.stiffness * stiffness)
            for mesh, (damping, gap, stiffness) in zip(train.meshes, values.reshape(2, 3))
        ]  # fmt: skip
        branch = replace(train, meshes=meshes).response(**RANGE)
        branch.jumps, branch.peaks(), branch.dynamic_factor[branch.stable].max()


def by_concurrent_futures(points, workers, folder):
    os.sched_setaffinity(0, [*os.sched_getaffinity(0)][:workers])  # all cores are so many then
    study_of(points).run(folder)


def by_joblib(points, workers, folder):
    from joblib.externals.loky import get_reusable_executor

    study_of(points).run(folder, get_reusable_executor(workers))


def by_dask(points, workers, folder):
    import dask
    from dask.distributed import Client, LocalCluster

    dask.config.set({"distributed.worker.profile.enabled": False})
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        study_of(points).run(folder, client)


ENGINES = {"plain loop": by_plain_loop, "concurrent.futures": by_concurrent_futures, "joblib (loky)": by_joblib, "Dask": by_dask}


def measured(engine, points, workers):
    """Wall time [s], CPU time [s] and the client's peak memory [MB] of an engine, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, __file__, "--engine", engine, "--points", str(points), "--workers", str(workers), folder]
        begun = time.perf_counter()
        one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, **one_thread})
        said = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        if status:
            raise RuntimeError(f"{engine}: status {status}")
        return time.perf_counter() - begun, usage.ru_utime + usage.ru_stime, float(said.split()[-1])


def read_back(points):
    """Seconds in which a study of so many points is read, which are records of a few trains under other keys."""
    with tempfile.TemporaryDirectory() as folder:
        study = study_of(points)
        plan: Plan = study._plan.in_batches_of(100, 0.03)
        store = Store(folder)
        store.make()
        store.put_plan(plan)
        few = [record_of(plan, point) for point in range(20)]
        for block in range(plan.blocks):
            records = [Record(plan.key(point), *few[point % 20][1:]) for point in plan.block(block)]
            store.write(f"{plan.digest}-{block:06d}", records)
        begun = time.process_time()
        dataset = study.dataset(folder)
        assert (dataset.status == "done").all()
        seconds = time.process_time() - begun
        begun = time.process_time()
        study.explain(folder)
        return seconds, time.process_time() - begun, dataset.nbytes / 1e6


def measure(quick, executable, say):
    """Rows by engine: wall time [s], CPU time [s], client's memory [MB]; the time to read a study back [s], and its size [MB]."""
    points, workers, stored = (1000 if quick else 10000), 2, (10000 if quick else 100000)
    rows = {}
    for engine in ENGINES:
        say(f"study: {engine}")
        rows[engine] = measured(engine, points, workers)
    seconds, _, size = read_back(stored)
    return {"points": points, "workers": workers, "rows": rows, "read": stored, "seconds": seconds, "size": size}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=10000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--read", type=int, default=100000)
    parser.add_argument("--engine", choices=ENGINES, help=argparse.SUPPRESS)
    parser.add_argument("folder", nargs="?", help=argparse.SUPPRESS)
    told = parser.parse_args()
    if told.engine:
        ENGINES[told.engine](told.points, told.workers, told.folder)
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
        return
    found = {engine: [] for engine in ENGINES}
    for _ in range(told.repeats):
        for engine, rows in found.items():
            rows.append(measured(engine, told.points, told.workers))
    plain = np.median([row[1] for row in found["plain loop"]])
    print(f"{told.points} points, {told.workers} workers, {told.repeats} repeats")
    print(f"{'':20s} {'wall [s]':>10s} {'CPU [s]':>10s} {'overhead':>10s} {'efficiency':>11s} {'client [MB]':>12s}")
    for engine, rows in found.items():
        wall, cpu, memory = np.median(rows, axis=0)
        workers = 1 if engine == "plain loop" else told.workers
        print(f"{engine:20s} {wall:10.1f} {cpu:10.1f} {cpu / plain - 1:10.1%} {plain / (workers * wall):11.2f} {memory:12.0f}")
    if told.read:
        seconds, again, size = read_back(told.read)
        print(f"{told.read} points read in {seconds:.1f} s of CPU time, a Dataset of {size:.0f} MB; their status in {again:.1f} s")


if __name__ == "__main__":
    main()
