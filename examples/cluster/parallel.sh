#!/bin/bash
# Runs the shards of a series with GNU parallel, on this machine or on others:
#
#   parallel.sh 20 OUT monte-carlo lar3 --flights 2000
#   PARALLEL="--sshloginfile hosts --workdir ." parallel.sh 20 OUT monte-carlo lar3 --flights 2000
#
# 20 is the number of shards and OUT a folder that all machines can access. Then follows the command
# without --shard, --threads and --out. Running the same line again continues interrupted shards.
# When all are done:
#
#   dn merge OUT/shard_* --out RESULT
set -euo pipefail
shards=$1 out=$2
shift 2

# A word in single quotes for the shell that parallel starts. Quotes behind every brace keep
# parallel from replacing it: {} would become the number of the shard.
quoted() {
  local word=${1//\'/\'\\\'\'}
  printf "'%s'" "${word//\{/\{\'\'}"
}

command=$(quoted "${DN:-dn}")
for word in "$@"; do command+=" $(quoted "$word")"; done
mkdir -p "$out"
seq "$shards" | parallel --joblog "$out/jobs.log" --resume-failed --line-buffer --tag \
  "$command --shard {}/$(quoted "$shards") --threads 1 --out $(quoted "$out/shard_"){}"
