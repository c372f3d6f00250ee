#include "rigs/phase_words.h"

#include <catch2/catch.hpp>

#include "firmware/phase_estimate.h"

using powbench::rigs::phase_words;

TEST_CASE("what a rig says of its mains is a sentence", "[phase]") {
  CHECK(phase_words("0 none", "4 12") == "u = 0.004 deg now, 0.012 deg 20 ms ahead");
  CHECK(
      phase_words("144 cross_check disturbed", "900 1200") ==
      "not valid: the phase-locked loop differs by more than 3 deg; the waveform is not that of a cycle ago");
  CHECK(phase_words("256 brand_new", "1 1") == "not valid: brand_new");
  for (const char* text : {"", "none", "x y", "0"}) CHECK(phase_words(text, "") == "not known");
}

TEST_CASE("every fault of the phase has words", "[phase]") {
  for (const std::string_view name : powbench::firmware::phase_fault_names) {
    INFO(name);
    const std::string words = phase_words("1 " + std::string(name), "1 1");
    CHECK(words.find(name == "amplitude" || name == "frequency" ? "its " : " ") != std::string::npos);
    CHECK(words != "not valid: " + std::string(name));
  }
}
