#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/channel_set.h"
#include "core/outcome.h"
#include "core/quantities.h"
#include "core/units.h"
#include "host/config/bad_input.h"
#include "host/config/filter_text.h"
#include "host/config/key_line.h"
#include "host/config/test_record.h"
#include "sim/specimen/specimen.h"

/// The plan file: what a campaign does. Owner: the operator.

namespace powbench::host {

enum class Order : std::uint8_t {
  random,
  sequential,
  by_hand,  ///< nothing was planned: single closings, or imported waveforms; `run` refuses it
};
enum class Polarity : std::uint8_t { positive, negative, alternate };

/// Allowed interval of one quantity (the Limit of that quantity once it is named), SI; NaN = not limited on that side.
struct Interval {
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

struct Plan {
  std::string name = "plan";
  std::string
      specimen;  ///< specimen file as written, relative to the plan's folder; "" = the built-in reference
  std::vector<double> angles;            ///< rad, commanded closing angles, [0, 2 pi)
  int repeats = 3;                       ///< closings at each angle
  Order order = Order::random;           ///< within each repeat
  std::uint64_t seed = 1;                ///< of order and of everything random in the shots
  double supply_volts = 230.0;           ///< V rms
  double mains_hertz = 50.0;             ///< Hz
  double hold_time = 0.100;              ///< s: how long the coil stays switched on
  double pause = 0.0;                    ///< s between two shots, for the coil to cool down
  double ambient = 20.0 + zero_celsius;  ///< K
  /// Relative: standard uncertainty of the measured voltage's scale; NaN = 0.5 %.
  double supply_u = std::numeric_limits<double>::quiet_NaN();
  double coil_temperature_u = std::numeric_limits<double>::quiet_NaN();  ///< K, standard; NaN = 2 K
  Polarity polarity = Polarity::positive;
  Decision decision = Decision::simple;         ///< of the limits
  double angle_tolerance = radians(1.0);        ///< rad: a shot whose reached angle is further off fails
  double crosstalk_a = 0.0, crosstalk_b = 0.0;  ///< share of the other film's force that film a, b shows
  double limits_vs_simulation = std::numeric_limits<double>::quiet_NaN();  ///< relative; NaN = no such limit
  std::array<Interval, quantity_table.size()> limits{};  ///< in the order of the quantity table
  /// Wanted error of the simulated touch, seat and settled time, as a share of the touch time; NaN = not wanted.
  std::array<double, 3> wanted{std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::quiet_NaN()};
  std::string fields, mechanics;  ///< of the simulation, by name or `auto`; "" = no wish
  TestRecord test;
  FilterWords
      events;  ///< filter of the force channels, its phase, where vibration is looked for; "" = the default
  std::string channels;  ///< that the simulation records, by name; "" = all

  std::filesystem::path folder;  ///< of the plan file; not part of the resolved text
};

/// Throws BadInput with all mistakes.
Plan read_plan(const std::filesystem::path&);
Plan parse_plan(std::string text, std::string file);

/// Commented file with every key.
std::string plan_template();

/// Every key with its value.
std::vector<KeyLine> keys_of(const Plan&);

/// Canonical text: equal plans give equal bytes. Hash and store this. parse_plan reads it back.
std::string resolved_text(const Plan&);

/// The specimen the plan names, or the built-in reference contactor. Throws BadInput.
sim::Specimen load_specimen(const Plan&);

/// The channels a plan wants of its simulation.
ChannelSet wanted_channels(const Plan&);

}  // namespace powbench::host
