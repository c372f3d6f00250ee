#include "sim/study/axis.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/normal.h"
#include "core/random.h"
#include "core/units.h"
#include "sim/study/parameter.h"

namespace powbench::sim {
namespace {

struct ConditionRow {
  const char* name;
  double si_per_unit, si_offset, low, high;
  double Conditions::*member;
};
constexpr ConditionRow conditions[] = {
    {"angle_deg", pi / 180, 0, -360, 720, &Conditions::closing_angle},
    {"supply_volts", 1, 0, 0, 10'000, &Conditions::supply_volts},
    {"mains_hertz", 1, 0, 1, 1000, &Conditions::mains_hertz},
    {"ambient_degC", 1, zero_celsius, -100, 300, &Conditions::ambient},
};

std::string text(double value) {
  std::string s = std::to_string(value);
  s.erase(s.find_last_not_of('0') + 1);
  return s.ends_with('.') ? s + '0' : s;
}

void check(const Axis& axis, double low, double high) {
  const Variable& v = axis.variable;
  if (low >= v.low && high <= v.high && low <= high && axis.steps >= 1) return;
  throw std::invalid_argument(v.name + " = " + text(low) + " .. " + text(high) +
                              ": allowed ascending, within " + text(v.low) + " .. " + text(v.high));
}

constexpr double cut = 3;  // deviations

/// The same permutation of 0 .. n - 1 for equal seeds, evaluated at one place: a Feistel network with cycle walking.
std::uint64_t permuted(std::uint64_t place, std::uint64_t n, std::uint64_t seed) {
  int bits = 1;
  while ((std::uint64_t{1} << (2 * bits)) < n) ++bits;
  const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
  do {
    std::uint64_t left = place >> bits;
    std::uint64_t right = place & mask;
    for (std::uint64_t round = 0; round < 6; ++round) {
      std::uint64_t state = seed ^ (round << 56) ^ right;
      const std::uint64_t next = left ^ (splitmix64(state) & mask);
      left = right;
      right = next;
    }
    place = left << bits | right;
  } while (place >= n);
  return place;
}

double uniform_of(std::uint64_t seed, std::int64_t number, std::size_t axis) {
  std::uint64_t state = seed;
  state = splitmix64(state) ^ static_cast<std::uint64_t>(number);
  state = splitmix64(state) ^ axis;
  return static_cast<double>(splitmix64(state) >> 11) * 0x1.0p-53;
}

}  // namespace

void Variable::set(Case& c, double value) const {
  const double si = value * si_per_unit + si_offset;
  if (field != nullptr)
    field->set(c.specimen, si);
  else
    c.conditions.*(conditions[condition].member) = si;
}

double Variable::get(const Case& c) const {
  const double si = field != nullptr ? field->get(c.specimen) : c.conditions.*(conditions[condition].member);
  return (si - si_offset) / si_per_unit;
}

Variable variable(std::string_view name) {
  Variable v;
  v.name = name;
  for (std::size_t k = 0; k < std::size(conditions); ++k) {
    const auto& row = conditions[k];
    if (name != row.name) continue;
    v.si_per_unit = row.si_per_unit;
    v.si_offset = row.si_offset;
    v.low = row.low;
    v.high = row.high;
    v.condition = static_cast<int>(k);
    return v;
  }
  try {
    v.field = &specimen_field(name);
  } catch (const std::invalid_argument&) {
    throw std::invalid_argument(
        "variable = " + std::string(name) +
        ": allowed angle_deg, supply_volts, mains_hertz, ambient_degC, or section.key "
        "of the specimen file, such as core.mass_g");
  }
  v.si_per_unit = v.field->si_per_unit;
  v.low = v.field->low;
  v.high = v.field->high;
  return v;
}

double Axis::at(double share) const {
  if (law == Law::uniform) return low + share * (high - low);
  // the part of the distribution within the cut, stretched to 0 .. 1
  constexpr double tail = 1.3498980316301e-3;
  return mean + deviation * normal_quantile(tail + share * (1 - 2 * tail));
}

Axis uniform_axis(std::string_view name, double low, double high, int steps) {
  Axis a;
  a.variable = variable(name);
  a.low = low;
  a.high = high;
  a.steps = steps;
  check(a, low, high);
  return a;
}

Axis normal_axis(std::string_view name, double mean, double deviation, int steps) {
  Axis a;
  a.variable = variable(name);
  a.law = Axis::Law::normal;
  a.mean = mean;
  a.deviation = deviation;
  a.steps = steps;
  check(a, mean - cut * deviation, mean + cut * deviation);
  return a;
}

Design::Design(std::vector<Axis> axes, Sampling sampling, std::int64_t count, std::uint64_t seed)
    : axes_(std::move(axes)), sampling_(sampling), size_(count), seed_(seed) {
  if (axes_.empty()) throw std::invalid_argument("a sweep needs at least one variable");
  constexpr double most = 1e8;
  if (sampling_ == Sampling::grid) {
    double points = 1;
    for (const auto& a : axes_) points *= a.steps;
    if (points > most)
      throw std::invalid_argument("grid: allowed up to 1e8 points; fewer steps or variables");
    size_ = static_cast<std::int64_t>(points);
  }
  if (size_ < 1 || static_cast<double>(size_) > most) throw std::invalid_argument("points: allowed 1 .. 1e8");
}

std::vector<double> Design::point(std::int64_t number) const {
  std::vector<double> values;
  std::int64_t rest = number;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const Axis& a = axes_[k];
    double share = 0.5;
    if (sampling_ == Sampling::grid) {
      const std::int64_t step = rest % a.steps;
      rest /= a.steps;
      if (a.steps > 1) share = static_cast<double>(step) / (a.steps - 1);
    } else {
      share = uniform_of(seed_, number, k);
      if (sampling_ == Sampling::latin) {
        std::uint64_t key = seed_ + 77 * (k + 1);
        const auto n = static_cast<std::uint64_t>(size_);
        const std::uint64_t cell = permuted(static_cast<std::uint64_t>(number), n, splitmix64(key));
        share = (static_cast<double>(cell) + share) / static_cast<double>(size_);
      }
    }
    values.push_back(a.at(share));
  }
  return values;
}

Case Design::apply(const Case& base, std::span<const double> values) const {
  Case c = base;
  for (std::size_t k = 0; k < axes_.size(); ++k) axes_[k].variable.set(c, values[k]);
  return c;
}

}  // namespace powbench::sim
