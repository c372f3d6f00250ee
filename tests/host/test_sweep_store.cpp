#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "host/store/hash.h"
#include "host/store/seal.h"
#include "host/store/store.h"
#include "host/store/sweep_store.h"
#include "tests/host/store_samples.h"

using namespace powbench::host;

TEST_CASE("sweeps live beside campaigns in one store: blocks once, in order, NaN kept, damage told",
          "[store]") {
  const Folder folder;
  SweepInfo info;
  info.design = "{}";
  info.design_hash = "abc";
  info.points = 4;
  info.columns = "a b";
  info.program_version = "x";
  std::int64_t id = 0;
  {
    SweepStore store(folder.file());
    id = store.open_sweep(info);
    CHECK(store.open_sweep(info) == id);
    info.design_hash = "def";
    CHECK(store.open_sweep(info) != id);
    const std::vector<double> second{5, 6, 7, 8};
    const std::vector<double> first{1, 2, std::nan(""), 4};
    store.put(id, std::vector<SweepBlock>{{2, 2, second}, {0, 2, first}});
    store.put(id, std::vector<SweepBlock>{{0, 2, second}});  // there already: kept as it is
  }
  {
    const SweepStore store(folder.file());
    const auto blocks = store.blocks(id);
    REQUIRE(blocks.size() == 2);
    CHECK(blocks[0].first == 0);
    CHECK(blocks[0].numbers[0] == 1);
    CHECK(std::isnan(blocks[0].numbers[2]));
    CHECK(blocks[1].numbers == std::vector<double>{5, 6, 7, 8});
    CHECK(store.sweeps().size() == 2);
    CHECK(store.sweeps()[0].design == "{}");
  }
  CHECK(Store(folder.file()).campaigns().empty());
}

TEST_CASE("a hash of parts is that of the whole", "[store]") {
  std::string text(200'000, ' ');
  for (std::size_t i = 0; i < text.size(); ++i) text[i] = static_cast<char>(i * i % 251);
  Sha256 parts;
  Seal seal;
  std::string sealed;
  for (std::size_t at = 0, n = 1; at < text.size(); at += n, n = n * 3 + 1) {
    const std::string part = text.substr(at, n);
    parts.add(part);
    seal.add(part);
    sealed += std::to_string(part.size()) + ':' + part;  // as its declaration says
  }
  CHECK(parts.hex() == sha256_hex(text));
  CHECK(seal.hex() == sha256_hex(sealed));
}
