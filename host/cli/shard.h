#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// One study on many machines: parts that do not know of each other.

namespace powbench::host {

/// Part `index` of `of`, both from 1. Blocks of points go round: block b, from 0, is of part b % of + 1.
struct Shard {
  std::int64_t index = 1, of = 1;
  bool has(std::int64_t block) const { return block % of == index - 1; }
};

/// Reads "3/97"; "" is the whole. Throws BadInput for anything but I/N with 1 <= I <= N <= 1 000 000.
Shard read_shard(const std::string& text);

/// A bash script for the login node of a cluster: submits `shards` parts of the command as job arrays no longer than the cluster's
/// MaxArraySize allows, each with a store of its own in DATABASE.shards, and one job behind them that merges the stores into `database`
/// and runs the command on that, which simulates what is missing, nothing as a rule, and prints the result. A part that is run again goes
/// on where it was. `command`: words without --db, -j, --shard and --slurm.
std::string slurm_script(const std::vector<std::string>& command, const std::string& database, int shards);

}  // namespace powbench::host
