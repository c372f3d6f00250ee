#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/models/rung.h"
#include "sim/specimen/specimen_fields.h"

/// What a sweep varies, and the points it visits.

namespace powbench::sim {

/// A number that may vary: `section.key` of the specimen file, or angle_deg, supply_volts, mains_hertz, ambient_degC.
struct Variable {
  std::string name;
  double si_per_unit = 1;
  double si_offset = 0;                 ///< SI = value * si_per_unit + si_offset
  double low = 0, high = 0;             ///< allowed, in the unit of the name
  void set(Case&, double value) const;  ///< value in the unit of the name
  double get(const Case&) const;

  const SpecimenField* field = nullptr;  ///< nullptr: a condition
  int condition = 0;
};
/// Throws std::invalid_argument for an unknown name.
Variable variable(std::string_view name);

/// One variable with its span. A normal one is cut at three deviations.
struct Axis {
  Variable variable;
  enum class Law { uniform, normal } law = Law::uniform;
  double low = 0, high = 0;        ///< uniform, in the unit of the name
  double mean = 0, deviation = 0;  ///< normal
  int steps = 5;                   ///< of a grid, both ends included

  /// Value at a share of the distribution in [0, 1].
  double at(double share) const;
};
/// Uniform between bounds; or normal. Throw std::invalid_argument when a value could leave the allowed range.
Axis uniform_axis(std::string_view name, double low, double high, int steps = 5);
Axis normal_axis(std::string_view name, double mean, double deviation, int steps = 5);

enum class Sampling { grid, latin, monte_carlo };

/// The points of a sweep, by number: any of them can be made without the others, so that a sweep can be interrupted.
class Design {
 public:
  /// `count` is ignored for a grid. Throws std::invalid_argument for no axis, count < 1 or a grid beyond 10^8 points.
  Design(std::vector<Axis>, Sampling, std::int64_t count, std::uint64_t seed);

  std::int64_t size() const { return size_; }
  const std::vector<Axis>& axes() const { return axes_; }
  /// Values in the units of the names.
  std::vector<double> point(std::int64_t number) const;
  Case apply(const Case& base, std::span<const double> values) const;

 private:
  std::vector<Axis> axes_;
  Sampling sampling_;
  std::int64_t size_;
  std::uint64_t seed_;
};

}  // namespace powbench::sim
