#include <catch2/catch.hpp>
#include <limits>

#include "core/commanded_phase.h"
#include "sim/specimen/specimen_fields.h"
#include "tests/fmu/importer.h"
#include "tests/fmu/specimens.h"

using namespace powbench;
using namespace powbench::test;

namespace {

const Unpacked& files2() {
  static const Unpacked u({}, fmu::Fmi::two);
  return u;
}

std::vector<double> outputs(Unit2& u) {
  return {u.get("coil_current"),
          u.get("flux_linkage"),
          u.get("core_position"),
          u.get("core_speed"),
          u.get("pole[2].bridge_position"),
          u.get("pole[1].force_a"),
          u.get("magnetic_force")};
}

void begin(Unit2& u, double volts = 230) {
  u.set("source.volts", volts);
  u.set("source.phase", 1.0);
  u.start();
}

void go(Unit2& u, int from, int to, double h = 1e-4) {
  for (int k = from; k < to; ++k) REQUIRE(u.step(k * h, h) == 0);
}

}  // namespace

TEST_CASE("calls in a wrong order are refused and leave the unit as it was") {
  Unit2 u(files2(), fmu::fmi2::co_simulation);
  const unsigned vr = u.reference("coil_current");
  double v = 0;
  CHECK(u.step(0, 1e-4) != 0);
  CHECK(u.call("fmi2GetReal", &vr, std::size_t{1}, &v) != 0);
  CHECK(u.call("fmi2ExitInitializationMode") != 0);
  CHECK(u.call("fmi2Terminate") != 0);
  CHECK(u.call("fmi2EnterEventMode") != 0);
  CHECK(u.call("fmi2EnterInitializationMode") == 0);
  CHECK(u.call("fmi2SetupExperiment", 0, 0.0, 0.0, 0, 0.0) != 0);
  CHECK(u.call("fmi2EnterInitializationMode") != 0);
  CHECK(u.call("fmi2ExitInitializationMode") == 0);
  CHECK(u.call("fmi2NewDiscreteStates", static_cast<fmu::fmi2::EventInfo*>(nullptr)) != 0);
  CHECK(u.call("fmi2GetContinuousStates", &v, std::size_t{1}) != 0);
  CHECK_THROWS(u.set("bridges.gap_mm", 2));  // fixed after the start
  CHECK_THROWS(u.set("core_position", 2));
  CHECK(u.step(0, 1e-4) == 0);
  CHECK(u.step(0, 1e-4) != 0);  // not where it stands
  CHECK(u.step(1e-4, -1e-4) != 0);
  CHECK(u.step(1e-4, std::numeric_limits<double>::quiet_NaN()) != 0);
  CHECK(u.step(1e-4, 1e-4) == 0);
  CHECK(u.call("fmi2Terminate") == 0);
  CHECK(u.get("coil_current") == 0);
  CHECK(u.step(2e-4, 1e-4) != 0);
  CHECK(u.call("fmi2Terminate") != 0);
}

TEST_CASE("null pointers, unknown references and impossible values are refused with a message") {
  const int before = logged;
  Unit2 u(files2(), fmu::fmi2::co_simulation);
  const unsigned wrong = 100000, right = u.reference("coil_voltage"), flag = u.reference("coil_closed");
  double v = std::numeric_limits<double>::infinity();
  const double* none = nullptr;
  const unsigned* nothing = nullptr;
  CHECK(u.call("fmi2SetReal", &wrong, std::size_t{1}, &v) != 0);
  CHECK(u.call("fmi2SetReal", &right, std::size_t{1}, &v) != 0);
  CHECK(u.call("fmi2SetReal", &flag, std::size_t{1}, &v) != 0);
  CHECK(u.call("fmi2SetReal", &right, std::size_t{1}, none) != 0);
  CHECK(u.call("fmi2SetReal", nothing, std::size_t{1}, &v) != 0);
  CHECK(u.call("fmi2SetReal", nothing, std::size_t{0}, none) == 0);
  CHECK(u.call("fmi2GetInteger", &right, std::size_t{1}, static_cast<int*>(nullptr)) != 0);
  CHECK(u.call("fmi2SetFMUstate", static_cast<void*>(&v)) != 0);
  CHECK(u.call("fmi2SerializedFMUstateSize", static_cast<void*>(nullptr),
               static_cast<std::size_t*>(nullptr)) != 0);
  CHECK(logged > before + 5);
  u.set("core.mass_g", -3);  // seen when all are known
  CHECK(u.call("fmi2EnterInitializationMode") == 0);
  CHECK(u.call("fmi2ExitInitializationMode") != 0);
  u.set("core.mass_g", 200);
  CHECK(u.call("fmi2ExitInitializationMode") == 0);

  for (const char* name :
       {"fmi2DoStep", "fmi2Reset", "fmi2Terminate", "fmi2EnterInitializationMode", "fmi2GetReal",
        "fmi2NewDiscreteStates", "fmi2GetFMUstate", "fmi2GetStatus", "fmi2SetString", "fmi3Reset",
        "fmi3DoStep", "fmi3GetFloat64", "fmi3GetBinary", "fmi3UpdateDiscreteStates"})
    CHECK(reinterpret_cast<int (*)(void*)>(fmu_symbol(name))(nullptr) != 0);
  reinterpret_cast<void (*)(void*)>(fmu_symbol("fmi2FreeInstance"))(nullptr);
  reinterpret_cast<void (*)(void*)>(fmu_symbol("fmi3FreeInstance"))(nullptr);
}

TEST_CASE("a unit with another token, another folder or damaged resources is not made") {
  Unpacked other({}, fmu::Fmi::two);
  other.token = "{0}";
  CHECK(Unit2(other, fmu::fmi2::co_simulation).c == nullptr);
  Unpacked three({}, fmu::Fmi::three);
  three.token = "";
  CHECK(Unit3(three, false, false).c == nullptr);
  CHECK_THROWS(fmu::folder_of_uri("http://x/y"));
  CHECK(fmu::folder_of_uri("file:///a%20b/c") == "/a b/c");
  CHECK(fmu::folder_of_uri("file:/a/c") == "/a/c");
  CHECK(fmu::folder_of_uri("file://host/c") == "/c");
  CHECK_THROWS(fmu::read_resource("/nowhere"));

  sim::Specimen s;
  s.magnet.steel = "sheet", s.magnet.steel_b = {0.5, 1, 1.5}, s.magnet.steel_h = {50, 100.0 / 3, 1e3};
  const std::string text = fmu::resource_text(s, "x");
  const auto back = fmu::parse_resource(text);
  CHECK(fmu::resource_text(back, "x") == text);
  CHECK(back.magnet.steel_h == s.magnet.steel_h);
  for (const auto& f : sim::specimen_fields()) CHECK(f.get(back) == f.get(s));
  for (std::size_t cut = 0; cut + 30 < text.size(); cut += 97)
    CHECK_THROWS_AS(fmu::parse_resource(text.substr(0, cut)), std::invalid_argument);
  CHECK_THROWS_AS(fmu::parse_resource(text + "more = 1\n"), std::invalid_argument);
  CHECK(fmu::token_of(text) != fmu::token_of(text + " "));
}

TEST_CASE("two units at once do not meet, reset begins anew, and a saved state is gone back to bit for bit") {
  Unit2 alone(files2(), fmu::fmi2::co_simulation);
  begin(alone);
  go(alone, 0, 200);
  const auto expected = outputs(alone);

  Unit2 a(files2(), fmu::fmi2::co_simulation), b(files2(), fmu::fmi2::co_simulation);
  begin(a), begin(b, 190);
  void* saved = nullptr;
  for (int k = 0; k < 200; ++k) {
    go(a, k, k + 1), go(b, k, k + 1);
    if (k == 99) REQUIRE(a.call("fmi2GetFMUstate", &saved) == 0);
  }
  CHECK(outputs(a) == expected);
  CHECK(outputs(b) != expected);
  CHECK(b.call("fmi2SetFMUstate", saved) != 0);  // another unit's
  const double touch = a.get("pole[1].touch_time");
  REQUIRE(a.call("fmi2SetFMUstate", saved) == 0);
  go(a, 100, 200);
  CHECK(outputs(a) == expected);
  CHECK(a.get("pole[1].touch_time") == touch);
  REQUIRE(a.call("fmi2FreeFMUstate", &saved) == 0);
  CHECK(saved == nullptr);

  REQUIRE(b.call("fmi2Reset") == 0);
  begin(b);
  go(b, 0, 200);
  CHECK(outputs(b) == expected);
}

TEST_CASE("the clock of the unit may begin anywhere") {
  Unit2 u(files2(), fmu::fmi2::co_simulation);
  u.set("source.volts", 230);
  u.set("source.phase", 1.0);
  u.start(5);  // 250 periods later
  for (int k = 0; k < 250; ++k) REQUIRE(u.step(5 + k * 1e-4, 1e-4) == 0);
  Unit2 zero(files2(), fmu::fmi2::co_simulation);
  begin(zero);
  go(zero, 0, 250);
  CHECK(u.get("seat_time") - 5 == Approx(zero.get("seat_time")).margin(1e-7));
}
