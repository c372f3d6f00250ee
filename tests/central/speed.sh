#!/usr/bin/env bash
# What `powbench db push` and `db pull` take compared with `db merge` and a plain copy of the file: three campaigns on the simulated rig,
# a server of the package postgresql on a socket of its own. By hand; the best of REPEATS runs counts.
#   speed.sh POWBENCH [CLOSINGS_AN_ANGLE] [REPEATS]
set -euo pipefail
powbench=$(realpath "$1")
closings=${2-24}
repeats=${3-5}
scenes=$(realpath "$(dirname "$0")/../../scenes")
bin=$(printf '%s\n' /usr/lib/postgresql/*/bin | tail -n 1)
[[ -x $bin/initdb ]] || { printf 'speed.sh: PostgreSQL is not installed (Debian: postgresql)\n' >&2; exit 1; }
folder=$(mktemp -d)
as=()
if [[ $(id -u) == 0 ]]; then
  as=(setpriv --reuid=postgres --regid=postgres --clear-groups)
  chown postgres "$folder"
fi
chmod 755 "$folder"
finish() {
  "${as[@]}" "$bin/pg_ctl" -D "$folder/data" -m immediate stop >/dev/null 2>&1 || true
  rm -rf "$folder"
}
trap finish EXIT
cd "$folder"
"${as[@]}" "$bin/initdb" -D data -U lab -A trust -E UTF8 --locale=C.UTF-8 >/dev/null
"${as[@]}" "$bin/pg_ctl" -D data -w -l log -o "-k $folder -c listen_addresses=''" start >/dev/null
server=$(head -n 1 data/postmaster.pid)

mkdir work
cp "$scenes"/reference.specimen.toml work/
sed "s/^repeats = .*/repeats = $closings/" "$scenes/demo.plan.toml" >work/plan.toml
store=work/store.db
for bench in 1 2 3; do
  "$powbench" run work/plan.toml --rig sim: --db work/bench$bench.db --seed $bench --progress none >/dev/null 2>&1
done
"$powbench" db merge -o $store work/bench?.db >/dev/null
shots=$((21 * closings))
megabytes=$(awk -v b="$(stat -c %s $store)" 'BEGIN { print b / 1e6 }')

# Processor time of the server and its children that have ended, and of those that run, s.
server_cpu() {
  local pid all=0 part
  for pid in $server $(cat /proc/"$server"/task/*/children); do
    part=$(awk '{ print $14 + $15 + $16 + $17 }' "/proc/$pid/stat" 2>/dev/null || echo 0)
    all=$((all + part))
  done
  awk -v t="$all" -v h="$(getconf CLK_TCK)" 'BEGIN { print t / h }'
}
address() { printf 'postgresql://lab@/%s?host=%s' "$1" "$folder"; }
fresh() { "$bin/psql" -q -h "$folder" -U lab -d postgres -c "DROP DATABASE IF EXISTS $1" -c "CREATE DATABASE $1" 2>/dev/null; }
# row NAME PREPARE COMMAND: wall clock, processor time of the client and of the server; the best of all
row() {
  local name=$1 prepare=$2 i before
  shift 2
  TIMEFORMAT='%R %U %S'
  for ((i = 0; i < repeats; ++i)); do
    eval "$prepare"
    before=$(server_cpu)
    { time "$@" >/dev/null 2>&1; } 2>times
    sleep 0.3  # until the server has the time of those that served
    awk -v a="$before" -v b="$(server_cpu)" '{ print $1, $2 + $3, b - a }' times
  done | awk -v name="$name" -v shots=$shots -v mb="$megabytes" '
    NR == 1 || $1 < wall { wall = $1 }
    NR == 1 || $2 < client { client = $2 }
    NR == 1 || $3 < server { server = $3 }
    END { printf "%-38s %8.2f %10.2f %10.2f %10.0f %8.0f\n", name, wall, client, server, shots / wall, mb / wall }'
}
copy() { cp $store work/copy.db && sync work/copy.db; }
at_once() {
  local i pids=()
  for i in 1 2 3; do "$powbench" db push "$(address b1)" --db work/bench$i.db & pids+=($!); done
  wait "${pids[@]}"
}

printf '%d closings, %.1f MB; the best of %d runs; server and client on one machine\n\n' $shots "$megabytes" "$repeats"
printf '%-38s %8s %10s %10s %10s %8s\n' '' 's' 'client s' 'server s' 'closings/s' 'MB/s'
row 'cp and sync' 'rm -f work/copy.db' copy
row 'db check' : "$powbench" db check --db $store
row 'db merge into a new store' 'rm -f work/merged.db*' "$powbench" db merge -o work/merged.db $store
row 'db push into a new database' 'fresh b1' "$powbench" db push "$(address b1)" --db $store
row 'db push once more: nothing is new' : "$powbench" db push "$(address b1)" --db $store
row 'db pull into a new store' 'rm -f work/pulled.db*' "$powbench" db pull "$(address b1)" --db work/pulled.db
row 'db push of three benches at once' 'fresh b1' at_once
"$powbench" db check --db $store | tail -n 1
"$powbench" db check --db work/pulled.db | tail -n 1
"$bin/psql" -h "$folder" -U lab -d b1 -At -c "SELECT 'the database takes ' || round(pg_database_size('b1') / 1e6, 1) || ' MB'"
