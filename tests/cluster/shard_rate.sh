#!/usr/bin/env bash
# What a sweep in shards costs without any cluster's own waits: pairs of the serial run on two threads and of SHARDS shards, two at a time,
# with the merge and the run that collects, in wall time and in CPU time, which other work on the machine moves less. Only the content is
# asserted. Closes with `N passed, N failed`.
# With `instructions` in place of PAIRS: once, by the instructions of all programs as valgrind counts them, which no other work moves.
#   shard_rate.sh POWBENCH [POINTS [SHARDS [PAIRS|instructions]]]
set -uo pipefail
powbench=$(realpath "$1")
points=${2-100000} shards=${3-10} pairs=${4-5}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit
words=(sweep --vary angle_deg=0:180 --vary supply_volts~230:2 --points "$points" --seed 7 --progress none)
hash_of() { "$powbench" db check --db "$1" --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["hash"])'; }
# wall time, and the CPU time of all commands that have ended, s
now() { echo "$(date +%s.%N) $(awk '{ print ($16 + $17) / 100 }' /proc/$$/stat)"; }
if [[ $pairs == instructions ]]; then
  count=(valgrind --tool=cachegrind --cache-sim=no --cachegrind-out-file=/dev/null)
  sum() { cat "$@" | awk '/I *refs:/ { gsub(",", ""); n += $NF } END { printf "%.0f\n", n }'; }
  "${count[@]}" "$powbench" "${words[@]}" --db serial.db -j 2 >/dev/null 2>serial.log
  for ((shard = 1; shard <= shards; ++shard)); do
    "${count[@]}" "$powbench" "${words[@]}" --db "part$shard.db" --shard "$shard/$shards" -j 1 >/dev/null 2>"shard$shard.log"
  done
  "${count[@]}" "$powbench" db merge -o all.db part*.db >/dev/null 2>merge.log
  "${count[@]}" "$powbench" "${words[@]}" --db all.db -j 2 >/dev/null 2>collect.log
  awk -v points="$points" -v shards="$shards" -v n="$(sum serial.log) $(sum shard*.log) $(sum merge.log) $(sum collect.log)" 'BEGIN {
    split(n, t); printf "%d points in %d shards, 10^9 instructions: serial %.3f, shards %.3f, merge %.3f, collecting run %.3f: rate %.4f\n", points,
    shards, t[1] / 1e9, t[2] / 1e9, t[3] / 1e9, t[4] / 1e9, t[1] / (t[2] + t[3] + t[4]) }'
  same=$([[ $(hash_of all.db) == "$(hash_of serial.db)" ]] && echo 1 || echo 0)
  printf '%d passed, %d failed\n' "$same" $((1 - same))
  exit $((1 - same))
fi
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
  awk -v pair="$start $serial $end" 'BEGIN { split(pair, t); printf "serial %.2f s, in shards %.2f s, rate %.3f; CPU %.2f s, %.2f s, rate %.3f\n",
    t[3] - t[1], t[5] - t[3], (t[3] - t[1]) / (t[5] - t[3]), t[4] - t[2], t[6] - t[4], (t[4] - t[2]) / (t[6] - t[4]) }' | tee -a rates
  if [[ $(hash_of all.db) == "$(hash_of serial.db)" ]]; then passed=$((passed + 1)); else failed=$((failed + 1)); fi
done
median() { awk -v k="$1" '{ print $k + 0 }' rates | sort -n | sed -n "$(((pairs + 1) / 2))p"; }
printf '%s points in %s shards: median rate %s by wall time, %s by CPU time, of %s pairs\n' "$points" "$shards" "$(median 9)" "$(median 16)" "$pairs"
printf '%d passed, %d failed\n' "$passed" "$failed"
((failed == 0))
