#!/bin/sh
# A study on a cluster with SLURM: 64 tasks of one core, each for its own batches; nobody coordinates them. First, from Python,
# `study.prepare("runs/torque", parts=64)`; then `sbatch example/study_slurm.sh runs/torque`, again for what a time limit has cut off.
#SBATCH --array=1-64
#SBATCH --cpus-per-task=1
#SBATCH --time=01:00:00
#SBATCH --signal=TERM@60
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
exec geartrain-study "$1" --part "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
