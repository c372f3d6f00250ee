#include <cstdlib>

#include "tests/host/import/foreign_fuzz.h"

/// fuzz_foreign COUNT [SEED]: broken files for every importer; ends with 1 at the first that is neither read nor
/// refused.

int main(int argc, char** argv) {
  const long count = argc > 1 ? std::atol(argv[1]) : 100'000;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
  const auto tally = powbench::host::fuzz_foreign(seed, count);
  fmt::print("{:<40} {:>10} {:>10}\n", "broken files of", "read", "refused");
  for (const auto& [name, n] : tally.read_refused)
    fmt::print("{:<40} {:>10} {:>10}\n", name, n.first, n.second);
  fmt::print("{} inputs, seed {}{}{}\n", tally.count, seed, tally.wrong.empty() ? "" : ": ", tally.wrong);
  return tally.wrong.empty() ? 0 : 1;
}
