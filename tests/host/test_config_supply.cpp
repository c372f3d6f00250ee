#include <catch2/catch.hpp>

#include "core/units.h"
#include "host/config/rig_file.h"

using namespace powbench;
using namespace powbench::host;

namespace {

std::vector<std::string> errors_of(const std::string& text) {
  try {
    parse_rig(text, "r.toml");
  } catch (const BadInput& e) {
    return e.errors();
  }
  return {};
}

}  // namespace

TEST_CASE("rig files say what feeds the coil, in the units of their keys", "[config]") {
  const std::string text =
      "[supply]\nresistance_ohm = 3\ninductance_mH = 1.5\nharmonic_percent = [5, 0, 2, 0]\n"
      "harmonic_deg = [180, 0, -90, 0]\ndip_start_ms = [10, 30]\ndip_length_ms = [5, 20]\n"
      "dip_depth_percent = [40, 100]\ndip_jump_deg = [90, 0]\n"
      "[switch]\nkind = \"relay\"\nclosing_delay_ms = 6\nopening_delay_ms = 2\n"
      "bounce_open_us = [300, 900, 0, 0]\nbounce_close_us = [600, 1000, 0, 0]\n";
  const RigFile r = parse_rig(text, "r.toml");
  const auto& m = r.config.supply.mains;
  CHECK(m.resistance == 3);
  CHECK(m.inductance == 1.5e-3);
  CHECK(m.harmonics[0].order == 3);
  CHECK(m.harmonics[0].share == 0.05);
  CHECK(m.harmonics[2].phase == Approx(-pi / 2));
  CHECK(m.dips[0].depth == 0.4);
  CHECK(m.dips[0].jump == Approx(pi / 2));
  CHECK(m.dips[1].start == 30e-3);
  const auto& s = r.config.supply.coil_switch;
  CHECK(s.kind == sim::CoilSwitch::Kind::relay);
  CHECK(s.closing_delay == 6e-3);
  CHECK(s.bounces[1].open == 900e-6);
  CHECK(resolved_text(parse_rig(resolved_text(r), "again")) == resolved_text(r));

  const auto triac = parse_rig(
      "[switch]\nkind = \"triac\"\nlatching_current_mA = 30\nholding_current_mA = 20\ngate_pulse_us = 100\n"
      "gate_period_us = 500\n",
      "r.toml");
  CHECK(triac.config.supply.coil_switch.kind == sim::CoilSwitch::Kind::triac);
  CHECK(triac.config.supply.coil_switch.holding_current == 0.02);
  CHECK(triac.config.supply.coil_switch.gate_period == 500e-6);
}

TEST_CASE("mistakes about supply and switch are told with key, value and range", "[config]") {
  const auto errors = errors_of(
      "[supply]\nresistance_ohm = -1\nharmonic_percent = [101, 0, 0, 0]\ndip_length_ms = [5]\n"
      "[switch]\nkind = \"valve\"\nholding_current_mA = 20\ngate_pulse_us = 500\ngate_period_us = 100\n"
      "bounce_open_us = [300, 200, 0, 0]\nbounce_close_us = [600, 1000, 0, 0]\nlatch_mA = 3\n");
  const auto told = [&](const std::string& part) {
    for (const auto& e : errors)
      if (e.find(part) != std::string::npos) return true;
    return false;
  };
  CHECK(told("[supply] resistance_ohm = -1: out of range; allowed 0..1000 ohm"));
  CHECK(told("[supply] harmonic_percent"));
  CHECK(told("[supply] dip_length_ms = [5]: has 1 items, must be a list of 2 numbers"));
  CHECK(told("[switch] kind = \"valve\""));
  CHECK(
      told("[switch] holding_current_mA = 20: is above the latching current; allowed at most "
           "latching_current_mA"));
  CHECK(told("[switch] gate_period_us = 100: is shorter than the pulse"));
  CHECK(told("[switch] bounce_close_us"));
  CHECK(told("latch_mA"));
  CHECK(told("unknown key"));
  CHECK(errors.size() == 8);
}

TEST_CASE("rig files with a direct or rectified source, a suppression and an economiser", "[config]") {
  const RigFile r = parse_rig(
      "[supply]\nkind = \"full_wave\"\nrectifier_drop_V = 1.4\n[switch]\nhold_period_us = 500\nhold_after_ms "
      "= 80\n"
      "hold_duty_percent = 25\n[suppression]\nkind = \"varistor\"\nclamp_V = 300\nclamp_current_A = 0.5\n"
      "clamp_exponent = 0.03\n",
      "r.toml");
  const auto& s = r.config.supply;
  CHECK(s.mains.kind == sim::Mains::Kind::full_wave);
  CHECK(s.mains.rectifier_drop == 1.4);
  CHECK(s.coil_switch.hold_period == 500e-6);
  CHECK(s.coil_switch.hold_after == 80e-3);
  CHECK(s.coil_switch.hold_duty == 0.25);
  CHECK(s.suppression.kind == sim::Suppression::Kind::varistor);
  CHECK(s.suppression.clamp == 300);
  CHECK(s.suppression.clamp_current == 0.5);
  CHECK(s.suppression.clamp_exponent == 0.03);
  CHECK(resolved_text(parse_rig(resolved_text(r), "again")) == resolved_text(r));
  const auto rc = parse_rig(
      "[supply]\nkind = \"dc\"\n[suppression]\nkind = \"rc\"\nresistance_ohm = 100\ncapacitance_uF = 0.47\n",
      "r.toml");
  CHECK(rc.config.supply.suppression.capacitance == Approx(0.47e-6).epsilon(1e-15));
  CHECK_NOTHROW(sim::require_valid(rc.config.supply));
}

TEST_CASE("parts of a supply that do not go together are told with line, key, value and what is allowed",
          "[config]") {
  const auto only = [](const std::string& text) {
    const auto errors = errors_of(text);
    return errors.size() == 1 ? errors[0] : std::to_string(errors.size()) + " errors";
  };
  CHECK(only("[suppression]\nkind = \"diode\"\n") ==
        "r.toml:2: [suppression] kind = \"diode\": shorts every second half-wave of alternating mains; "
        "allowed with "
        "supply.kind = dc, half_wave, full_wave");
  CHECK(
      only("[supply]\nkind = \"dc\"\ninductance_mH = 2\n") ==
      "r.toml:3: [supply] inductance_mH = 2: is not modelled behind a direct or rectified source; allowed 0");
  CHECK(only("[supply]\nkind = \"dc\"\nharmonic_percent = [5, 0, 0, 0]\n") ==
        "r.toml:3: [supply] harmonic_percent = [5, 0, 0, 0]: a direct source has none; allowed 0");
  CHECK(only("[supply]\nkind = \"dc\"\n[suppression]\nkind = \"rc\"\n") ==
        "r.toml:3: [suppression] resistance_ohm: is too little for a capacitor; allowed 0.1 and more with "
        "kind = rc");
  CHECK(only("[supply]\nkind = \"dc\"\n[switch]\nkind = \"triac\"\n") ==
        "r.toml:4: [switch] kind = \"triac\": never turns off without a zero of the current; allowed with "
        "supply.kind = ac");
  CHECK(only("[supply]\nkind = \"dc\"\n[switch]\nhold_period_us = 500\n")
            .find("hold_period_us = 500: an economiser") != std::string::npos);
  CHECK(only("[supply]\nkind = \"direct\"\n").find("kind = \"direct\"") != std::string::npos);
}
