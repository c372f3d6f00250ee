#!/usr/bin/env bash
# Proof that no test depends on the speed of the machine: the fast tests again and again with busy loops beside them,
# then once at a quarter of the speed. The programs must be built (./dev test, ./dev asan).
#
#   bash tests/under_load.sh [--preset release|asan] [--repeat N] [--busy N] [--only REGEX] [--quarter-only]
#
# A quarter of the speed: a control group where the system allows one, else `cpulimit` (Debian: cpulimit).
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit

preset=release repeat=20 busy=4 only=. loaded=1
while (($#)); do
  case $1 in
    --preset) preset=$2; shift ;;
    --repeat) repeat=$2; shift ;;
    --busy) busy=$2; shift ;;
    --only) only=$2; shift ;;
    --quarter-only) loaded=0 ;;
    *) printf 'under_load: unknown option %s; known: --preset --repeat --busy --only --quarter-only\n' "$1" >&2; exit 2 ;;
  esac
  shift
done
export ASAN_OPTIONS=${ASAN_OPTIONS-detect_stack_use_after_return=1}
out=build/$preset/under_load
mkdir -p "$out"

loops=()
group=
stop() {
  for pid in "${loops[@]}"; do kill "$pid" 2>/dev/null; done
  if [[ -n $group ]]; then rmdir "$group" 2>/dev/null; fi
}
trap stop EXIT

tests=(ctest --test-dir "build/$preset" -R "$only" --output-on-failure --no-tests=error --timeout 3600 --parallel "$(nproc)")
failures=0

# round NAME COMMAND...: one run of the tests
round() {
  local name=$1 start=$SECONDS
  shift
  if "$@" >"$out/$name.log" 2>&1 </dev/null; then
    printf '%s: passed, %d s\n' "$name" $((SECONDS - start))
  else
    printf '%s: FAILED, %d s; see %s\n' "$name" $((SECONDS - start)) "$out/$name.log"
    failures=$((failures + 1))
  fi
}

if ((loaded)); then
  for ((i = 0; i < busy; i++)); do
    (while :; do :; done) &
    loops+=($!)
  done
  for ((i = 1; i <= repeat; i++)); do round "load-$i" "${tests[@]}"; done
  for pid in "${loops[@]}"; do kill "$pid"; done
  loops=()
fi

# a quarter of all cores together; control groups of either version
quota=$(($(nproc) * 25000))
name=powbench-quarter
if [[ -f /sys/fs/cgroup/cgroup.controllers ]] && mkdir /sys/fs/cgroup/$name 2>/dev/null; then
  group=/sys/fs/cgroup/$name
  echo "$quota 100000" >$group/cpu.max || exit
elif [[ -f /sys/fs/cgroup/cpu/cpu.cfs_quota_us ]] && mkdir /sys/fs/cgroup/cpu/$name 2>/dev/null; then
  group=/sys/fs/cgroup/cpu/$name
  echo 100000 >$group/cpu.cfs_period_us && echo "$quota" >$group/cpu.cfs_quota_us || exit
fi
if [[ -n $group ]]; then
  round quarter bash -c "echo \$\$ >$group/cgroup.procs && exec \"\$@\"" quarter "${tests[@]}"
elif command -v cpulimit >/dev/null; then
  round quarter cpulimit --include-children --limit $((quota / 1000)) -- "${tests[@]}"
else
  printf 'quarter: not run; there is neither a control group to be had nor cpulimit\n'
  failures=$((failures + 1))
fi
printf '%d rounds failed\n' "$failures"
((failures == 0))
