#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/random.h"
#include "host/config/nearest.h"
#include "host/config/unit.h"
#include "sim/specimen/specimen_fields.h"

using namespace powbench;
using namespace powbench::host;

TEST_CASE("the unit of a key is its longest known suffix", "[config]") {
  CHECK(unit_of_key("gap_mm").text == "mm");
  CHECK(unit_of_key("rate_N_per_m").text == "N/m");
  CHECK(unit_of_key("inertia_g_mm2").text == "g mm2");
  CHECK(unit_of_key("bh_linear_A_per_m_per_T").text == "A/(m T)");
  CHECK(unit_of_key("repeats").text.empty());
  CHECK(unit_of_key("fringing").text.empty());
  CHECK(unit_of_key("seed").text.empty());
}

TEST_CASE("values become SI without a rounding of their own", "[config]") {
  CHECK(to_si(2.51, unit_of_key("gap_mm")) == 2.51e-3);
  CHECK(to_si(21, unit_of_key("s_pC_per_N")) == 21e-12);
  CHECK(to_si(0.1, unit_of_key("x_percent")) == 1e-3);
  CHECK(to_si(20, unit_of_key("ambient_degC")) == 293.15);
  CHECK(to_si(180, unit_of_key("angle_deg")) == pi);
  CHECK(to_si(0, unit_of_key("gap_mm")) == 0.0);
  CHECK(to_si(-7.5, unit_of_key("gap_um")) == -7.5e-6);
}

TEST_CASE("SI values are written so that they read back bit for bit", "[config]") {
  Random random(4);
  for (const char* key :
       {"a_mm", "a_um", "a_mm2", "a_g_mm2", "a_pC_per_N", "a_percent", "a_deg", "a_degC", "a_khz", "a"}) {
    const Unit& unit = unit_of_key(key);
    int differing = 0;
    for (int i = 0; i < 2000; ++i) {
      char text[40];  // what people write: up to 12 digits
      std::snprintf(text, sizeof text, "%.*g", 1 + static_cast<int>(random.below(12)),
                    (random.uniform() - 0.5) * std::pow(10.0, static_cast<double>(random.below(7)) - 2));
      const double si = to_si(std::strtod(text, nullptr), unit);
      differing += to_si(std::strtod(from_si(si, unit).c_str(), nullptr), unit) != si;
    }
    CAPTURE(key);
    CHECK(differing == 0);
  }
  CHECK(from_si(2.51e-3, unit_of_key("gap_mm")) == "2.51");
  CHECK(from_si(radians(30), unit_of_key("a_deg")) == "30");
  CHECK(from_si(293.15, unit_of_key("a_degC")) == "20");
}

TEST_CASE("specimen keys carry the unit that the simulator's table converts with", "[config]") {
  for (const auto& f : sim::specimen_fields()) {
    CAPTURE(f.key);
    CHECK(to_si(1.0, unit_of_key(f.key)) == f.si_per_unit);
  }
}

TEST_CASE("slips are counted as people make them", "[config]") {
  CHECK(slips("", "") == 0);
  CHECK(slips("repeats", "repeats") == 0);
  CHECK(slips("repeat", "repeats") == 1);
  CHECK(slips("reapets", "repeats") == 2);
  CHECK(slips("erpeats", "repeats") == 1);  // two letters swapped
  CHECK(slips("", "abc") == 3);
  CHECK(slips("seat_mm", "gap_mm") == 3);
}

TEST_CASE("the nearest key is named only when it is near", "[config]") {
  const std::vector<std::string> keys{"gap_mm", "mass_g", "repeats", "supply_volts", "angles_deg"};
  CHECK(nearest("gapmm", keys) == "gap_mm");
  CHECK(nearest("gap", keys) == "gap_mm");
  CHECK(nearest("gap_um", keys) == "gap_mm");
  CHECK(nearest("angle_deg", keys) == "angles_deg");
  CHECK(nearest("SUPPLY_VOLTS", keys) == "supply_volts");
  CHECK(nearest("temperature", keys).empty());
  CHECK(nearest("x", keys).empty());
}
