#include "host/config/rig_file.h"

#include <array>
#include <cmath>

#include "host/config/file_reader.h"
#include "host/config/specimen_file.h"

namespace powbench::host {
namespace {

void declare_rig(FileKind& kind, RigFile& r) {
  auto& c = r.config;
  kind.text("name", c.name, "what clients see as the rig's description");
  kind.text("serial", c.serial, "serial number of the rig");
  kind.text("listen", r.listen,
            "IPv4 address to serve on; the IIO port 30431 is fixed, so rigs differ by address");
  kind.text("specimen", r.specimen,
            "file of the mounted contactor; without it the built-in reference contactor");
  kind.number("sample_rate_hertz", c.sample_rate, {20e3, 1e6}, "of every channel, a whole number");
  kind.number("record_length_ms", c.record_length, {20, 2000}, "pre-trigger included");
  kind.number("pretrigger_ms", c.pretrigger, {1, 100},
              "recorded before switch-on; the device is at rest for so long");
  kind.number("integrator_tolerance", c.integrator_tolerance, {1e-12, 1e-2},
              "relative, of the plant's integrator");
}

void declare_force(FileKind& kind, rigs::SensorConfig& s) {
  kind.section("force", "PVDF film under each fixed contact, charge amplifier, converter");
  kind.number("charge_sensitivity_pC_per_N", s.charge_sensitivity, {0.1, 1000}, "of the glued film");
  kind.number("film_area_mm2", s.film_area, {0.1, 10'000}, "area of each film");
  kind.number("full_scale_N", s.force_full_scale, {0.1, 1e6}, "beyond it the channel saturates");
  kind.number("corner_hertz", s.corner_hertz, {1e-4, 1000}, "low corner of the charge amplifier (droop)");
  kind.number("bandwidth_hertz", s.bandwidth_hertz, {100, 1e6}, "two-pole low-pass of the amplifier");
  kind.number("noise_N", s.force_noise, {0, 1000}, "rms a sample");
  kind.number("hum_N", s.force_hum, {0, 1000}, "rms of mains pick-up");
  kind.number("crosstalk_percent", s.force_crosstalk, {0, 100},
              "share of each film's force that the other one shows");
  kind.number("coil_pickup_N", s.coil_pickup, {0, 1000}, "at 325 V of coil voltage");
  kind.yes_no("film_a_inverted", s.film_a_inverted, "film A is glued upside down");

  kind.section("ring", "three modes of the frame that ring after the core impact; one number for each mode");
  std::array<std::vector<double*>, 4> places;
  for (auto& mode : s.ring) {
    places[0].push_back(&mode.hertz);
    places[1].push_back(&mode.damping);
    places[2].push_back(&mode.gain_a);
    places[3].push_back(&mode.gain_b);
  }
  kind.numbers("mode_hertz", places[0], {1, 1e6}, "natural frequencies");
  kind.numbers("damping", places[1], {1e-6, 1}, "damping ratios");
  kind.numbers("gain_film_a", places[2], {-1, 1}, "N at film A per N on the core's stop");
  kind.numbers("gain_film_b", places[3], {-1, 1}, "N at film B per N on the core's stop");
}

void declare_electrical(FileKind& kind, rigs::SensorConfig& s) {
  kind.section("laser", "travel of the core, by triangulation");
  kind.number("rate_hertz", s.laser_rate, {100, 1e7}, "the laser's own measuring rate");
  kind.number("delay_us", s.laser_delay, {0, 10'000}, "transport delay");
  kind.number("noise_um", s.laser_noise, {0, 1000}, "rms");
  kind.number("scale_um_per_count", s.laser_scale, {1e-4, 100}, "of the converter");

  kind.section("electrical", "coil current, voltages, contact voltage, base accelerometer");
  kind.number("current_full_scale_A", s.current_full_scale, {1e-3, 1000}, "coil current");
  kind.number("current_noise_mA", s.current_noise, {0, 1000}, "rms");
  kind.number("voltage_full_scale_V", s.voltage_full_scale, {1, 10'000}, "coil and mains voltage");
  kind.number("voltage_noise_V", s.voltage_noise, {0, 100}, "rms");
  kind.number("contact_open_V", s.contact_open_voltage, {0.1, 100}, "across the open pole");
  kind.number("contact_full_scale_V", s.contact_full_scale, {0.1, 1000}, "contact voltage");
  kind.number("contact_noise_mV", s.contact_noise, {0, 10'000}, "rms");
  kind.number("accelerometer_full_scale_m_per_s2", s.accelerometer_full_scale, {1, 1e7}, "auxiliary input");
  kind.number("accelerometer_noise_m_per_s2", s.accelerometer_noise, {0, 1e6}, "rms");
}

void declare_deviations(FileKind& kind, rigs::SimRigConfig& c) {
  kind.section("device", "how the mounted device differs from its specimen file");
  kind.number("coil_resistance_percent", c.device.coil_resistance, {-50, 50}, "fixed deviation");
  kind.number("return_rate_percent", c.device.return_rate, {-50, 50}, "fixed deviation");
  kind.number("friction_percent", c.device.friction, {-100, 500}, "fixed deviation");
  kind.number("gap_mm", c.device.gap, {-5, 5}, "added to the contact gap");
  kind.number("tilt_gap_mm", c.device.tilt_gap, {-5, 5}, "break B opens this much wider than break A");
  kind.number("supply_percent", c.device.supply, {-50, 50}, "error of the source's calibration");

  kind.section("front_end", "errors of the inputs against their nominal scales, for a calibration to find");
  for (std::size_t i = 0; i < channel_count; ++i) {
    const std::string name(channel_table[i].name);
    kind.number(name + "_gain_percent", c.front_end.gain[i], {-50, 50}, "more counts than the scale says");
    kind.number(name + "_zero", c.front_end.zero[i], {-3000, 3000}, "counts at zero");
  }

  kind.section("scatter", "from shot to shot: standard deviations");
  kind.number("supply_percent", c.scatter.supply, {0, 20}, "supply voltage");
  kind.number("coil_temperature_K", c.scatter.coil_temperature, {0, 100}, "coil temperature");
  kind.number("friction_percent", c.scatter.friction, {0, 100}, "friction");
  kind.number("gap_mm", c.scatter.gap, {0, 2}, "contact gap");

  kind.section("faults", "faults on request, to try error paths");
  kind.integer("lost_samples", c.faults.lost_samples, {0, 100'000},
               "conversions lost once, 5 ms after switch-on");
  kind.yes_no("coil_open", c.faults.coil_open, "coil circuit interrupted");
  kind.yes_no("relay_welded", c.faults.relay_welded, "the safety relay does not open any more");
  kind.yes_no("relay_open", c.faults.relay_open, "the safety relay does not close");
  kind.yes_no("laser_dropout", c.faults.laser_dropout,
              "laser holds its value for 2 ms around the core impact");
  kind.seed("line_seed", c.faults.line.seed,
            "of a line to the rig on which bits flip, bytes vanish or come late, and connections close or go "
            "dead; 0: a "
            "good line");
  kind.number("line_every_bytes", c.faults.line.mean_bytes, {1e3, 1e12},
              "towards the host between two such faults, on average; towards the rig a hundredth");
  kind.number("mains_dip_percent", c.faults.mains_dip, {0, 150}, "supply from arming on, of its set-point");
}

void declare_supply(FileKind& kind, sim::Supply& s) {
  auto& m = s.mains;
  std::vector<double*> percent, degrees, starts, lengths, depths, jumps, opens, closes;
  for (auto& h : m.harmonics) {
    percent.push_back(&h.share);
    degrees.push_back(&h.phase);
  }
  for (auto& d : m.dips) {
    starts.push_back(&d.start);
    lengths.push_back(&d.duration);
    depths.push_back(&d.depth);
    jumps.push_back(&d.jump);
  }
  for (auto& b : s.coil_switch.bounces) {
    opens.push_back(&b.open);
    closes.push_back(&b.close);
  }
  kind.section("supply", "the mains behind the coil switch; volts, hertz and angle are the plan's");
  kind.choice("kind", m.kind, {"ac", "dc", "half_wave", "full_wave"},
              "dc: the plan's volts without a wave, angle and hertz play no part; half_wave, full_wave: a "
              "rectifier ahead of "
              "the switch");
  kind.number("rectifier_drop_V", m.rectifier_drop, {0, 10}, "forward voltage of its diodes in series");
  kind.number("resistance_ohm", m.resistance, {0, 1000}, "of the source");
  kind.number("inductance_mH", m.inductance, {0, 1000}, "of the source");
  kind.numbers("harmonic_percent", percent, {0, 100}, "3rd, 5th, 7th and 11th, of the fundamental");
  kind.numbers("harmonic_deg", degrees, {-360, 360}, "their phases at the fundamental's rising zero");
  kind.numbers("dip_start_ms", starts, {0, 10'000}, "two dips; after the coil is commanded on");
  kind.numbers("dip_length_ms", lengths, {0, 10'000}, "0: no dip");
  kind.numbers("dip_depth_percent", depths, {0, 100}, "voltage that is missing; 100: interruption");
  kind.numbers("dip_jump_deg", jumps, {-360, 360}, "by which the phase leads during the dip");

  auto& c = s.coil_switch;
  kind.section("switch", "the switch between mains and coil");
  kind.choice("kind", c.kind, {"ideal", "relay", "triac"},
              "ideal: closes at once and opens at the current's zero; relay: delays and bounces; triac: "
              "gate, latching "
              "and holding current");
  kind.number("closing_delay_ms", c.closing_delay, {0, 1000}, "relay: command to first touch");
  kind.number("opening_delay_ms", c.opening_delay, {0, 1000}, "relay: command to parting");
  kind.numbers("bounce_open_us", opens, {0, 100'000}, "relay: four re-openings, after its first touch");
  kind.numbers("bounce_close_us", closes, {0, 100'000}, "relay: their ends; 0: no bounce");
  kind.number("latching_current_mA", c.latching_current, {0, 10'000},
              "triac: stays on without its gate from here");
  kind.number("holding_current_mA", c.holding_current, {0, 10'000}, "triac: off below, without its gate");
  kind.number("gate_pulse_us", c.gate_pulse, {0, 1e6}, "triac: 0: driven as long as commanded");
  kind.number("gate_period_us", c.gate_period, {0, 1e6}, "triac: from pulse to pulse; 0: a single one");
  kind.number("hold_period_us", c.hold_period, {0, 1e6},
              "ideal: an economiser chops with this period; 0: none. Needs a suppression");
  kind.number("hold_after_ms", c.hold_after, {0, 10'000}, "ideal: from the command to the first chop");
  kind.number("hold_duty_percent", c.hold_duty, {1, 99},
              "ideal: share of the period in which the coil is fed");

  auto& p = s.suppression;
  kind.section("suppression", "what lies across the coil and carries its current when the switch is open");
  kind.choice("kind", p.kind, {"none", "diode", "varistor", "rc"},
              "diode: dc and rectified; varistor: every supply; rc: dc only");
  kind.number("forward_V", p.forward, {0.1, 20}, "diode: forward voltage");
  kind.number("resistance_ohm", p.resistance, {0, 1e6},
              "in series with diode (dc only) or capacitor (0.1 and more)");
  kind.number("capacitance_uF", p.capacitance, {1e-6, 1e6}, "rc");
  kind.number("clamp_V", p.clamp, {1, 1e5}, "varistor: voltage at clamp_current_A");
  kind.number("clamp_current_A", p.clamp_current, {1e-6, 1e4}, "varistor");
  kind.number("clamp_exponent", p.clamp_exponent, {0, 1},
              "varistor: e of V = clamp_V (i / clamp_current_A)^e");
}

FileKind kind_of(RigFile& r) {
  FileKind kind("rig", "one simulated bench");
  declare_rig(kind, r);
  declare_force(kind, r.config.sensors);
  declare_electrical(kind, r.config.sensors);
  declare_deviations(kind, r.config);
  declare_supply(kind, r.config.supply);
  return kind;
}

bool is_ipv4(const std::string& text) {
  int parts = 0, value = -1;
  for (const char c : text + ".") {
    if (c == '.') {
      if (value < 0 || value > 255) return false;
      ++parts;
      value = -1;
    } else if (c >= '0' && c <= '9') {
      value = (value < 0 ? 0 : value) * 10 + (c - '0');
      if (value > 255) return false;
    } else {
      return false;
    }
  }
  return parts == 4;
}

void check_switch(FileReader& reader, const sim::CoilSwitch& s) {
  double touched = 0;
  for (const auto& b : s.bounces) {
    if (b.open == 0 && b.close == 0) continue;
    if (b.open < touched || b.close < b.open)
      reader.fail("switch", "bounce_close_us", "is not in order", "open <= close <= next open");
    touched = b.close;
  }
  if (s.holding_current > s.latching_current)
    reader.fail("switch", "holding_current_mA", "is above the latching current",
                "at most latching_current_mA");
  if (s.gate_period > 0 && s.gate_period < s.gate_pulse)
    reader.fail("switch", "gate_period_us", "is shorter than the pulse", "0, or gate_pulse_us and more");
}

/// What the parts of the supply say about each other; values out of range are known by now.
void check_supply(FileReader& reader, const sim::Supply& s) {
  if (s.mains.kind != sim::Mains::Kind::ac && s.mains.inductance > 0)
    reader.fail("supply", "inductance_mH", "is not modelled behind a direct or rectified source", "0");
  if (s.mains.kind == sim::Mains::Kind::dc)
    for (const auto& h : s.mains.harmonics)
      if (h.share > 0) {
        reader.fail("supply", "harmonic_percent", "a direct source has none", "0");
        break;
      }
  if (s.suppression.kind == sim::Suppression::Kind::rc && s.suppression.resistance < 0.1)
    reader.fail("suppression", "resistance_ohm", "is too little for a capacitor",
                "0.1 and more with kind = rc");
  const std::string what = sim::unsuited(s);
  if (what.empty()) return;
  const auto dot = what.find('.'), colon = what.find(':');
  const auto key = what.substr(dot + 1, what.find_first_of(" :", dot) - dot - 1);
  const auto allowed = what.rfind("; allowed ");
  if (allowed == std::string::npos)
    reader.fail(what.substr(0, dot), key, what.substr(colon + 2));
  else
    reader.fail(what.substr(0, dot), key, what.substr(colon + 2, allowed - colon - 2),
                what.substr(allowed + 10));
}

void check(FileReader& reader, const RigFile& r) {
  const auto& c = r.config;
  if (!is_ipv4(r.listen)) reader.fail("", "listen", "is no IPv4 address; for example 127.0.0.7");
  if (c.pretrigger >= c.record_length)
    reader.fail("", "pretrigger_ms", "leaves nothing of the record after switch-on",
                "less than record_length_ms");
  if (c.sensors.bandwidth_hertz <= c.sensors.corner_hertz)
    reader.fail("force", "bandwidth_hertz", "is not above corner_hertz");
  if (c.sensors.contact_open_voltage > c.sensors.contact_full_scale)
    reader.fail("electrical", "contact_open_V", "saturates the channel", "at most contact_full_scale_V");
  check_switch(reader, c.supply.coil_switch);
  check_supply(reader, c.supply);
}

RigFile read_with(FileReader reader) {
  RigFile r;
  reader.read(kind_of(r));
  check(reader, r);
  reader.finish();
  return r;
}

}  // namespace

RigFile read_rig(const std::filesystem::path& path) {
  RigFile r = read_with(FileReader::open(path));
  r.folder = path.parent_path();
  return r;
}

RigFile parse_rig(std::string text, std::string file) {
  return read_with(FileReader(std::move(file), std::move(text)));
}

std::string rig_template() {
  RigFile r;
  r.specimen = "reference.specimen.toml";
  return kind_of(r).template_text();
}

std::vector<KeyLine> keys_of(const RigFile& rig) {
  RigFile r = rig;
  return kind_of(r).lines();
}

std::string resolved_text(const RigFile& rig) {
  RigFile r = rig;
  return kind_of(r).resolved_text();
}

sim::Specimen load_specimen(const RigFile& rig) {
  return rig.specimen.empty() ? sim::Specimen{} : read_specimen(rig.folder / rig.specimen);
}

}  // namespace powbench::host
