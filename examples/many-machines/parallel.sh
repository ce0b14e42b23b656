#!/bin/bash
# An experiment on some machines by GNU parallel: each takes the next shard as soon as it has done one, and one that fails
# is done again, twice. What is there already is not done again.
#
#   ./parallel.sh 50 rotated --runs 10000
#
# HOSTS names other machines, as `parallel --sshlogin` takes them; they see the working folder, and have the same rpl.
set -euo pipefail
shards=$1
shift
mkdir -p parts
seq "$shards" | parallel --sshlogin "${HOSTS:-:}" --workdir . --retries 3 --halt soon,fail=20% \
    "test -e parts/{}.part || rpl experiment $(printf '%q ' "$@") --jobs 1 --shard {}/$shards --out parts/{}.part"
rpl experiment merge parts/*.part
