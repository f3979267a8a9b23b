"""The study of a folder on a cluster's queue, by Dask: `python example/study_jobqueue.py FOLDER slurm 64`.

`FOLDER` is what `study.prepare` or `study.run` has written, 64 the jobs of one core each. With `local` for `slurm` the jobs are
processes of this machine.
"""

from __future__ import annotations

import sys

import dask
import dask_jobqueue.local
from dask.distributed import Client
from dask_jobqueue import SLURMCluster

import geartrain as gt

__all__ = ["main"]

CLUSTERS = {"slurm": SLURMCluster, "local": dask_jobqueue.local.LocalCluster}


def main(folder: str, queue: str, jobs: str) -> None:
    """Compute what is not yet in the folder."""
    dask.config.set({"distributed.worker.profile.enabled": False})  # it looks at the workers a hundred times a second
    job = {"walltime": "01:00:00"} if queue == "slurm" else {}
    with CLUSTERS[queue](cores=1, processes=1, memory="2GB", **job) as cluster, Client(cluster) as client:
        cluster.scale(int(jobs))
        dataset = gt.read_study(folder).run(folder, client)
        print(f"{int((dataset.status == 'done').sum())} of {dataset.status.size} points done")


if __name__ == "__main__":
    if len(sys.argv) != 4 or sys.argv[2] not in CLUSTERS:
        sys.exit(__doc__)
    main(*sys.argv[1:])
