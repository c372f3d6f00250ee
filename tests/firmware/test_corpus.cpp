#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "core/random.h"
#include "tests/fuzz/responder_case.h"
#include "tests/places.h"

using namespace powbench;

namespace {

std::vector<std::vector<std::uint8_t>> corpus() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(test::source_dir() + "/tests/fuzz/corpus"))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::vector<std::uint8_t>> inputs;
  for (const auto& path : files) {
    std::ifstream file(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return inputs;
}

}  // namespace

TEST_CASE("the fuzzer's inputs and their mutants leave the responder in step and the bench safe", "[iiod]") {
  const auto inputs = corpus();
  REQUIRE(inputs.size() >= 10);
  fuzz::ResponderCase fuzz;  // ends the program when something is wrong
  for (const auto& input : inputs) fuzz.run(input);
  Random random(3);
  for (int i = 0; i < 20'000; ++i) {
    auto mutant = inputs[random.below(inputs.size())];
    const auto& other = inputs[random.below(inputs.size())];
    if (random.below(3) == 0) mutant.insert(mutant.end(), other.begin(), other.end());
    for (std::uint64_t k = random.below(4); k > 0 && !mutant.empty(); --k)
      mutant[random.below(mutant.size())] = static_cast<std::uint8_t>(random.below(256));
    if (!mutant.empty())
      for (auto cut = random.below(std::min<std::size_t>(mutant.size(), 3)); cut > 0; --cut)
        mutant.pop_back();
    fuzz.run(mutant);
  }
  SUCCEED();
}
