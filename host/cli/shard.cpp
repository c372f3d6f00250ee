#include "host/cli/shard.h"

#include <fmt/format.h>

#include <charconv>

#include "core/counted.h"
#include "host/cli/program.h"
#include "host/config/bad_input.h"

namespace powbench::host {
namespace {

/// A word as bash reads it back.
std::string quoted(const std::string& word) {
  constexpr std::string_view plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./%@";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

}  // namespace

Shard read_shard(const std::string& text) {
  if (text.empty()) return {};
  Shard s;
  const char *at = text.data(), *end = at + text.size();
  const auto first = std::from_chars(at, end, s.index);
  const bool bar = first.ec == std::errc() && first.ptr != end && *first.ptr == '/';
  const auto second = bar ? std::from_chars(first.ptr + 1, end, s.of) : first;
  if (!bar || second.ec != std::errc() || second.ptr != end || s.index < 1 || s.index > s.of ||
      s.of > 1'000'000)
    throw BadInput({"--shard " + text + ": allowed I/N, part I of N, such as 3/97"});
  return s;
}

Points open_points(const ShardArgs& args) {
  const Shard shard = read_shard(args.shard);
  if (!args.database.empty()) return {args.database, args.verb, shard, program_identity()};
  if (shard.of > 1)
    throw BadInput({"--shard " + args.shard + ": name a store for its points with --points-db"});
  return {};
}

void say_points(const Points& points, const ShardArgs& args) {
  if (!points.stored()) return;
  fmt::print(stderr, "{}: {} of {} computed, {} found in {}\n", args.verb, points.computed(),
             counted(static_cast<std::size_t>(points.computed() + points.found()), "point"), points.found(),
             args.database);
  if (points.part())
    fmt::print(stderr,
               "shard {}: powbench db merge -o ALL.db PART.db... puts the shards together, this command with "
               "--points-db ALL.db and without --shard prints the result\n",
               args.shard);
}

std::string slurm_script(const ShardArgs& args, const std::string& database) {
  if (database.empty()) throw BadInput({"--slurm: name a store for the points with --points-db"});
  std::string words = "powbench";
  for (const std::string& word : args.words) words += " " + quoted(word);
  const char* threads = args.threads ? " -j \"${SLURM_CPUS_PER_TASK:-1}\"" : "";
  return fmt::format(R"(#!/bin/bash
# {0} shards of one study, as job arrays no longer than this cluster allows, and a job that puts them together.
# More for every job, such as a partition or a time limit: SBATCH_PARTITION, SBATCH_TIMELIMIT and their like.
set -euo pipefail
command -v sbatch scontrol >/dev/null ||
  {{ echo "no sbatch here: run this on a machine that submits to Slurm" >&2; exit 1; }}
export POWBENCH_DB={1} POWBENCH_SHARDS={0}
folder=$POWBENCH_DB.shards
mkdir -p "$folder"
most=$(scontrol show config | awk '$1 == "MaxArraySize" {{ print $3 }}')
jobs=
for ((first = 1; first <= POWBENCH_SHARDS; first += most)); do
  last=$((POWBENCH_SHARDS - first < most ? POWBENCH_SHARDS - first : most - 1))
  job=$(POWBENCH_FIRST=$first sbatch --parsable --requeue --export=ALL --array=0-$last --job-name=powbench \
    --output="$folder/%A_%a.log" <<'JOB'
#!/bin/bash
set -euo pipefail
shard=$((POWBENCH_FIRST + SLURM_ARRAY_TASK_ID))
exec {2} --shard "$shard/$POWBENCH_SHARDS" {3} "$POWBENCH_DB.shards/$shard.db"{4}
JOB
)
  jobs=$jobs:${{job%%;*}}
done
last=$(sbatch --parsable --requeue --export=ALL --dependency="afterok$jobs" --kill-on-invalid-dep=yes \
  --job-name=powbench-merge \
  --output="$folder/result.txt" <<'JOB'
#!/bin/bash
set -euo pipefail
powbench db merge -o "$POWBENCH_DB" "$POWBENCH_DB.shards"/*.db
exec {2} {3} "$POWBENCH_DB"{4}
JOB
)
echo "job ${{last%%;*}} writes $folder/result.txt when all shards are done; squeue --me shows them"
)",
                     args.slurm, quoted(database), words, args.store, threads);
}

}  // namespace powbench::host
