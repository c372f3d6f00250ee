#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/random.h"
#include "tests/effort.h"
#include "tests/fuzz/csv_case.h"
#include "tests/places.h"

using namespace powbench;

namespace {

std::vector<std::string> corpus() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(powbench::test::source_dir() + "/tests/fuzz/csv_corpus"))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> inputs;
  for (const auto& path : files) {
    std::ifstream file(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return inputs;
}

/// What goes wrong with files and instruments: bytes flipped, pieces cut, doubled, swapped, numbers replaced.
std::string mutant(const std::vector<std::string>& inputs, Random& random) {
  static const char* const pieces[] = {
      ",",    ";",      "\n",           "\r",  "nan", "inf",       "-",     "1e308", "-1e308", "9.91E+37",
      "0",    "1e-320", "\"",           "#",   "[N]", "[V]",       "[mm]",  "time",  "pvdf_b", "laser [mm]",
      "1e15", "-0",     "\xEF\xBB\xBF", ",,,", "1e5", "0.0000001", "99999", "e",     ".",      "+"};
  static const char* const numbers[] = {"nan", "",       "0",   "-1e4",  "9.91E+37",
                                        "inf", "1e-320", "0.5", "-3.25", "12"};
  std::string text = inputs[random.below(inputs.size())];
  for (std::uint64_t k = 1 + random.below(3); k > 0 && !text.empty(); --k) {
    const std::size_t at = random.below(text.size());
    const std::size_t length =
        std::min<std::size_t>(text.size() - at, 1 + random.below(random.below(4) == 0 ? 2000 : 8));
    switch (random.below(14)) {
      case 0:
        text[at] = static_cast<char>(random.below(256));
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(at, length));
        break;
      case 3:
        text.replace(at, length, pieces[random.below(std::size(pieces))]);
        break;
      case 4:
        text.insert(at, pieces[random.below(std::size(pieces))]);
        break;
      case 5:
      case 6:
      case 7:
      case 8:
      case 9: {  // one digit becomes another: still a number
        const std::size_t digit = text.find_first_of("0123456789", at);
        if (digit != std::string::npos) text[digit] = static_cast<char>('0' + random.below(10));
        break;
      }
      default: {  // one cell becomes something else: still a table
        const std::size_t start = text.find_first_of(",;\t", at),
                          end = text.find_first_of(",;\t\r\n", start + 1);
        if (start != std::string::npos && end != std::string::npos)
          text.replace(start + 1, end - start - 1, numbers[random.below(std::size(numbers))]);
      }
    }
  }
  return text;
}

int taken(int mutants, std::uint64_t seed) {
  const auto inputs = corpus();
  REQUIRE(inputs.size() >= 12);
  int count = 0;
  for (const auto& input : inputs) count += fuzz::run_csv(input);
  CHECK(count == static_cast<int>(inputs.size()) - 2);  // all but the empty ones
  Random random(seed);
  for (int i = 0; i < mutants; ++i) count += fuzz::run_csv(mutant(inputs, random));
  return count;
}

/// A record as no sensible rig would send it.
Record wild_record(Random& random) {
  Record r;
  r.sample_rate = std::pow(10.0, 3.0 + 3.0 * random.uniform());
  const std::size_t n = random.below(3) == 0 ? random.below(40) : random.below(1500);
  r.fire_sample = static_cast<std::int64_t>(random.below(2000)) - 300;
  r.conditions.hold_time = random.below(4) == 0 ? -1.0 : 0.2 * random.uniform();
  for (std::size_t k = 0; k < channel_count; ++k) {
    if (random.below(3) == 0) continue;
    ChannelRecord c;
    c.channel = static_cast<Channel>(k);
    c.scale = (random.below(5) == 0 ? -1 : 1) * std::pow(10.0, -5.0 * random.uniform());
    c.offset = random.below(3) == 0 ? 1000 * random.normal() : 0.0;
    c.delay = random.below(3) == 0 ? 1e-4 * random.normal() : 0.0;
    c.corner_hertz = random.below(2) == 0 ? 0.0 : 10 * random.uniform();
    const double swing = std::pow(10.0, 4.4 * random.uniform()), pole = random.uniform();
    double level = 0;
    for (std::size_t i = 0; i < n; ++i) {
      level = pole * level + swing * (random.uniform() - 0.5);
      if (random.below(200) == 0) level = swing * random.normal();
      c.raw.push_back(static_cast<std::int16_t>(std::clamp(level, -32768.0, 32767.0)));
    }
    if (random.below(3) == 0) c.clip_high = static_cast<std::int16_t>(swing / 3);
    if (random.below(4) == 0) c.gaps.push_back({static_cast<std::int64_t>(random.below(1500)) - 100, 40});
    r.channels.push_back(std::move(c));
  }
  if (random.below(4) == 0) r.gaps.push_back({static_cast<std::int64_t>(random.below(1000)), 100});
  return r;
}

void wild_records(int count, std::uint64_t seed) {
  Random random(seed);
  for (int i = 0; i < count; ++i) {
    const Record r = wild_record(random);
    Events e = dsp::extract_events(r);
    dsp::admit_doubt(e, r);
    fuzz::must_be_honest(e, r);
  }
}

}  // namespace

TEST_CASE("mutants of waveform files are refused with a sentence or give honest events") {
  CHECK(taken(2'000 / effort::every, 11) * effort::every > 300);
}

TEST_CASE("wild records give honest events") {
  wild_records(300 / effort::every, 12);
  SUCCEED();
}

TEST_CASE("twenty thousand mutants of waveform files", "[.slow]") {
  CHECK(taken(20'000, 23) > 2'000);
}

TEST_CASE("four thousand wild records", "[.slow]") {
  wild_records(4'000, 24);
  SUCCEED();
}

TEST_CASE("a hundred thousand mutants of waveform files", "[.long]") {
  CHECK(taken(100'000, 21) > 10'000);
}

TEST_CASE("twenty thousand wild records", "[.long]") {
  wild_records(20'000, 22);
  SUCCEED();
}
