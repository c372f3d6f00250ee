#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/store/points.h"

/// One study on many machines: parts that do not know of each other.

namespace powbench::host {

/// What a verb with independent points is given to share them out.
struct ShardArgs {
  std::string database;                 ///< store of the points; "" = none is kept
  std::string shard;                    ///< I/N: only every Nth point, from the Ith, and no result; "" = all
  int slurm = 0;                        ///< print a script that submits so many shards; 0 = compute
  std::string store;                    ///< option that names the store: --points-db, or --db of `sweep`
  std::string verb;                     ///< for sentences
  bool threads = false;                 ///< the verb takes -j
  std::vector<std::string> words = {};  ///< the command again, without what each shard has of its own
};

/// Reads "3/97"; "" is the whole. Throws BadInput for anything but I/N with 1 <= I <= N <= 1 000 000.
Shard read_shard(const std::string& text);

/// Opens the points of a verb, or keeps none where no store is named. Throws BadInput for --shard without one.
Points open_points(const ShardArgs&);

/// One line to stderr: points computed and found, and, of a part, how the parts are put together.
void say_points(const Points&, const ShardArgs&);

/// A bash script for the login node of a cluster: submits the shards of the command as job arrays no longer than the
/// cluster's MaxArraySize allows, each with a store of its own in DATABASE.shards, and one job behind them that
/// merges the stores into `database` and runs the command on that, which computes what is missing, nothing as a rule,
/// and prints the result. A part that is run again goes on where it was. Throws BadInput where no store is named.
std::string slurm_script(const ShardArgs&, const std::string& database);

}  // namespace powbench::host
