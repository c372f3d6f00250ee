#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/store/maintain.h"
#include "host/store/store.h"

/// Many benches, one database: what stores hold, in a PostgreSQL server and back. A database is named by its address,
/// postgresql://USER@HOST:PORT/DATABASE; a password in it is refused, for it comes from PGPASSWORD, ~/.pgpass or a
/// service file.

namespace powbench::host {

/// The server cannot be reached, does not take connections, or was lost on the way. One sentence: what and what to do.
class ServerError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Pushed {
  std::int64_t campaigns = 0, shots = 0, events = 0, annotations = 0, sweep_blocks = 0,
               points = 0;  ///< added
  std::int64_t bytes = 0;   ///< of samples, of numbers of sweeps and of points, as stored
};
/// Adds what the store at `path` holds to the database, whose schema `powbench` is made where it is missing. What is
/// there already, by its content hash, is not sent again. Nothing is pushed where the two differ in what is there
/// once (as merge_stores). In transactions of a few shots, each under a lock of its campaign: several may push at
/// once, and a push that was killed goes on where it stopped. Throws WrongStore for what the caller can mend,
/// StoreError for a damaged store or a newer schema, ServerError.
Pushed push_store(const std::string& path, const std::string& address, const Step& = {});

/// Whether a campaign of the database is wanted, by its row and its annotations.
using CampaignChoice = std::function<bool(const CampaignInfo&, const std::vector<Annotation>&)>;

/// Writes the chosen campaigns (without a choice all of them, the sweeps and the points) to the store at `path`: as a
/// new file that is whole or not there, or merged into one that exists. Each row is compared with its hash, and the
/// samples with theirs. Throws as push_store; StoreError also for a row of the database that does not match,
/// WrongStore where no campaign is chosen: `why_none()`.
Merged pull_store(const std::string& address, const std::string& path, const CampaignChoice& = {},
                  const std::function<std::string()>& why_none = {}, const Step& = {});

}  // namespace powbench::host
