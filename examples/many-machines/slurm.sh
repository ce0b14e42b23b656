#!/bin/bash
# An experiment as a job array of Slurm: a task for each shard, and a job that makes the table when all are done.
#
#   ./slurm.sh 50 rotated --runs 10000
#
# Every node sees the working folder. A shard that failed is done again by `sbatch --array=NUMBER`; what is missing is
# named by the table.
#SBATCH --cpus-per-task=1
#SBATCH --mem=1G
#SBATCH --time=4:00:00
set -euo pipefail
if [ -z "${SLURM_ARRAY_TASK_ID:-}" ]; then
    shards=$1
    mkdir -p parts
    array=$(sbatch --parsable --array="1-$shards" "$0" "$@")
    sbatch --dependency="afterany:$array" --output=table.txt --wrap="rpl experiment merge parts/*.part"
    exit
fi
shards=$1
shift
exec rpl experiment "$@" --jobs "${SLURM_CPUS_PER_TASK:-1}" --shard "$SLURM_ARRAY_TASK_ID/$shards" --out "parts/$SLURM_ARRAY_TASK_ID.part"
