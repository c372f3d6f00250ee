#!/usr/bin/env bash
# What a sweep in shards costs without any cluster's own waits: pairs of the serial run on two threads and of SHARDS shards, two at a time,
# with the merge and the run that collects, in wall time. Only the content is asserted. Closes with `N passed, N failed`.
#   shard_rate.sh POWBENCH [POINTS [SHARDS [PAIRS]]]
set -uo pipefail
powbench=$(realpath "$1")
points=${2-100000} shards=${3-10} pairs=${4-5}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit
words=(sweep --vary angle_deg=0:180 --vary supply_volts~230:2 --points "$points" --seed 7 --progress none)
hash_of() { "$powbench" db check --db "$1" --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["hash"])'; }
now() { date +%s.%N; }
passed=0 failed=0
for ((pair = 1; pair <= pairs; ++pair)); do
  rm -f ./*.db
  start=$(now)
  "$powbench" "${words[@]}" --db serial.db -j 2 >/dev/null 2>&1
  serial=$(now)
  seq "$shards" | xargs -P 2 -I{} "$powbench" "${words[@]}" --db part{}.db --shard "{}/$shards" -j 1 >/dev/null 2>&1
  "$powbench" db merge -o all.db part*.db >/dev/null 2>&1
  "$powbench" "${words[@]}" --db all.db -j 2 >/dev/null 2>&1
  end=$(now)
  awk -v a="$start" -v b="$serial" -v c="$end" 'BEGIN { printf "serial %.2f s, in shards %.2f s, rate %.3f\n", b - a, c - b, (b - a) / (c - b) }' |
    tee -a rates
  if [[ $(hash_of all.db) == "$(hash_of serial.db)" ]]; then passed=$((passed + 1)); else failed=$((failed + 1)); fi
done
printf '%s points in %s shards: median rate %s of %s pairs\n' "$points" "$shards" \
  "$(awk '{ print $NF }' rates | sort -n | sed -n "$(((pairs + 1) / 2))p")" "$pairs"
printf '%d passed, %d failed\n' "$passed" "$failed"
((failed == 0))
