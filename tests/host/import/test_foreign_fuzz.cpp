#include "tests/host/import/foreign_fuzz.h"

#include <catch2/catch.hpp>

using namespace powbench::host;

TEST_CASE("broken files of every kind are read or refused in words, the whole ones are read",
          "[import][fuzz]") {
  for (const Foreign& f : fuzz_corpus()) {
    INFO(f.name);
    if (f.name == "DCC")
      CHECK(gain_of(parse_dcc(f.bytes, f.file), "N", f.file).gain == 10.02);
    else if (f.name == "COMTRADE")
      CHECK(whole(to_table(parse_comtrade(f.header, f.bytes, "x.cfg", "x.dat"))));
    else
      CHECK(whole(f.header.empty() ? parse_table(f.bytes, f.file)
                                   : parse_wvf(f.header, f.bytes, "x.hdr", "x.wvf")));
  }
  const FuzzTally tally = fuzz_foreign(20261124, 20'000);
  INFO(tally.wrong);
  CHECK(tally.wrong.empty());
  for (const auto& [name, n] : tally.read_refused) {
    INFO(name);
    CHECK(n.first > 0);
    CHECK(n.second > 0);
  }
}
