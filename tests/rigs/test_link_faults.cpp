#include <catch2/catch.hpp>

#include "bench/link/link_trials.h"

/// The trials of the benchmark bench_link_faults in small: every row of its table, fewer seeds.

using namespace powbench::bench;

namespace {

void check_rows(const std::vector<FaultRow>& rows) {
  int struck = 0;
  for (const FaultRow& r : rows) {
    INFO(name(r.kind) << (r.to_rig ? " towards the rig" : " towards the host") << ": " << r.tried
                      << " tried, " << r.same << " same, " << r.fetched << " fetched, " << r.reported
                      << " reported");
    for (const std::string& sentence : r.wrong) UNSCOPED_INFO(sentence);
    CHECK(r.silent == 0);
    CHECK(r.lost == 0);
    CHECK(r.twice == 0);
    CHECK(r.same + r.fetched + r.reported >= r.tried);
    struck += r.struck;
  }
  CHECK(struck > 0);
}

}  // namespace

TEST_CASE("a fault on TCP costs time or the shot, never the truth", "[link]") {
  check_rows(tcp_faults(48, 11));
}

TEST_CASE("a fault on a serial line costs time or the shot, never the truth", "[link]") {
  check_rows(serial_faults(8, 11));
}

TEST_CASE("two hosts on one rig get their own records, or a refusal", "[link]") {
  const InterleavingRow row = interleavings(3, 5);
  CHECK(row.shots == 12);
  CHECK(row.foreign == 0);
  CHECK(row.own > 0);
}

TEST_CASE("an owner that vanishes leaves the coil off, whoever watches", "[link]") {
  for (const VanishRow& r : vanishing_owners()) {
    INFO(r.state << ", " << r.spectators << " spectators");
    CHECK(r.off);
    CHECK(r.virtual_ms <= 252);  // fault 8, and the slices it is looked at in
    CHECK((r.virtual_ms > 0) == (r.state == "energised" || r.state == "waiting for the angle"));
  }
}

TEST_CASE("faults by the hundred", "[link][.slow]") {
  check_rows(tcp_faults(240, 2));
  check_rows(serial_faults(20, 2));
  CHECK(interleavings(20, 2).foreign == 0);
}

TEST_CASE("faults by the thousand", "[link][.long]") {
  check_rows(tcp_faults(1200, 1));
  check_rows(serial_faults(100, 1));
  CHECK(interleavings(100, 1).foreign == 0);
}
