#!/usr/bin/env bash
# `powbench sweep --slurm` on a cluster of one node: munged, slurmctld and slurmd of the system, started here on loopback with a
# MaxArraySize of 11, stopped at the end. 97 shards; slurmd is killed twice on the way and one shard run twice; three merge orders and
# the serial run must have one content hash. What shards, merge and the run that collects need together in CPU time is held against
# the serial run on two threads. Closes with `N passed, N failed`.
#   test_slurm.sh POWBENCH [POINTS]
set -uo pipefail
powbench=$(realpath "$1")
points=${2-48500}
passed=0 failed=0
check() {
  if [[ $2 == "$3" ]]; then
    passed=$((passed + 1))
  else
    failed=$((failed + 1))
    printf 'failed: %s: %s, expected %s\n' "$1" "$2" "$3"
  fi
}
for program in munged slurmctld slurmd sbatch; do
  if ! PATH=$PATH:/usr/sbin command -v "$program" >/dev/null; then
    printf 'failed: %s is not installed (Debian: munge slurmctld slurmd slurm-client)\n0 passed, 1 failed\n' "$program"
    exit 1
  fi
done
PATH=$PATH:/usr/sbin

folder=$(mktemp -d)
chmod 700 "$folder"
finish() {
  local name
  for name in slurmd slurmctld munged; do
    if [[ -s $folder/$name.pid ]]; then kill "$(<"$folder/$name.pid")" 2>/dev/null; fi
  done
  sleep 1
  rm -rf "$folder"
}
trap finish EXIT

port() { shuf -i 20000-30000 -n 1; }
mkdir "$folder/state" "$folder/spool" "$folder/bin"
cat >"$folder/bin/powbench" <<RUN
#!/bin/bash
# the program, with its CPU time, s, user and system, behind it
case "\$*" in
  *--shard*) kind=shard ;;
  *merge*) kind=merge ;;
  *serial.db*--progress*) kind=serial ;;
  *all.db*) kind=collect ;;
  *) kind=other ;;
esac
TIMEFORMAT='%U %S'
exec 3>&2
{ time $powbench "\$@" 2>&3; } 2>>"$folder/cpu.\$kind"
RUN
chmod +x "$folder/bin/powbench"
head -c 1024 /dev/urandom >"$folder/munge.key"
chmod 400 "$folder/munge.key"
munged --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" --pid-file="$folder/munged.pid" \
  --log-file="$folder/munged.log" --seed-file="$folder/munge.seed"
host=$(hostname -s)
cat >"$folder/slurm.conf" <<CONF
ClusterName=loop
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(port)
SlurmdPort=$(port)
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket,cred_expire=5
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
SlurmdTimeout=10
InactiveLimit=0
MaxArraySize=11
SlurmdParameters=config_overrides
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$folder/slurm.conf
PATH=$folder/bin:$PATH
slurmctld -f "$SLURM_CONF"
nice -n 10 slurmd -f "$SLURM_CONF"  # other tests run beside this
for ((tick = 0; tick < 120; ++tick)); do
  if sinfo --noheader --states=idle 2>/dev/null | grep -q .; then break; fi
  sleep 0.5
done
if ((tick == 120)); then
  printf 'Slurm does not start on this machine, so nothing was tried: %s\n' "$(tail -n 1 "$folder/slurmctld.log")"
  printf '0 passed, 0 failed\n'
  exit 0
fi

cd "$folder" || exit
words=(sweep --vary angle_deg=0:180 --vary supply_volts~230:2 --points "$points" --seed 7)
hash_of() { powbench db check --db "$1" --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["hash"])'; }
seconds() { date +%s.%N; }

start=$(seconds)
powbench "${words[@]}" --db serial.db -j 2 --progress none >serial.txt 2>/dev/null
serial=$(awk -v a="$start" -v b="$(seconds)" 'BEGIN { print b - a }')

powbench "${words[@]}" --db "$folder/all.db" --slurm 97 >script.sh
start=$(seconds)
answer=$(bash script.sh)
check "the script ends well" $? 0
check "it submits and says where the result will be" "${answer#job *writes }" "$folder/all.db.shards/result.txt when all shards are done; squeue --me shows them"

# slurmd dies when a third and when two thirds of the shards have begun, and with it what it runs: the node has lost its power.
kill_node() {
  local id
  kill -KILL "$(<slurmd.pid)"
  for id in $(pgrep -f "slurmstepd|$folder/all.db.shards"); do
    if tr '\0' '\n' 2>/dev/null <"/proc/$id/environ" | grep -qx "SLURM_CONF=$folder/slurm.conf"; then
      if [[ $(readlink "/proc/$id/exe") == "$powbench" ]]; then
        awk -v hertz="$(getconf CLK_TCK)" '{ print $14 / hertz, $15 / hertz }' "/proc/$id/stat" >>cpu.shard 2>/dev/null
      fi
      kill -KILL "$id" 2>/dev/null
    fi
  done
  scontrol update nodename="$host" state=down reason=power
  nice -n 10 slurmd -f "$SLURM_CONF"
  scontrol update nodename="$host" state=resume
}
killed=0
for ((tick = 0; tick < 3000 + points / 40; ++tick)); do
  left=$(squeue --noheader | wc -l) || left=1
  begun=$(find all.db.shards -name '*.db' 2>/dev/null | wc -l)
  if ((killed < 2 && begun > 32 * (killed + 1))); then
    killed=$((killed + 1))
    kill_node
  fi
  if ((left == 0)); then break; fi
  sleep 0.2
done
cluster=$(awk -v a="$start" -v b="$(seconds)" 'BEGIN { print b - a }')
check "no job is left" "$left" 0
check "slurmd was killed" "$killed" 2
check "shards" "$(find all.db.shards -name '*.db' | wc -l)" 97
check "the result is that of one run" "$(grep -v '^sweep\|added$' all.db.shards/result.txt | sort)" "$(grep -v '^sweep' serial.txt | sort)"
check "one content hash" "$(hash_of all.db)" "$(hash_of serial.db)"

mv cpu.shard cpu.shards
powbench "${words[@]}" --shard 5/97 --db again.db --progress none >/dev/null 2>&1
mv cpu.merge cpu.merged
mapfile -t parts < <(find all.db.shards -name '*.db' | sort)
mapfile -t shuffled < <(printf '%s\n' "${parts[@]}" | shuf --random-source=<(yes))
mapfile -t backwards < <(printf '%s\n' "${parts[@]}" | sort -r)
powbench db merge -o m1.db again.db "${parts[@]}" >/dev/null 2>&1
powbench db merge -o m2.db "${shuffled[@]}" again.db >/dev/null 2>&1
powbench db merge -o m3.db "${backwards[@]}" "${parts[@]}" >/dev/null 2>&1
for merged in m1 m2 m3; do check "$merged" "$(hash_of $merged.db)" "$(hash_of serial.db)"; done
cpu() { cat "$@" 2>/dev/null | awk '{ sum += $1 + $2 } END { printf "%.2f", sum }'; }
rate=$(awk -v a="$(cpu cpu.serial)" -v b="$(cpu cpu.shards cpu.merged cpu.collect)" 'BEGIN { printf "%.3f", a / b }')
printf 'CPU time, s: serial %s, shards %s, merge %s, collect %s: rate %s\n' "$(cpu cpu.serial)" "$(cpu cpu.shards)" "$(cpu cpu.merged)" \
  "$(cpu cpu.collect)" "$rate"
printf '%s points: serial on two threads %.1f s, 97 shards with two kills %.1f s\n' "$points" "$serial" "$cluster"
printf '%d passed, %d failed\n' "$passed" "$failed"
((failed == 0))
