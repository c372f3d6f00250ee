#include "rigs/shot_set_points.h"

#include <cmath>

#include "core/commanded_phase.h"
#include "core/phase.h"
#include "core/units.h"

namespace powbench::rigs {

ShotSetPoints shot_set_points(const Conditions& c, bool with_source) {
  const auto milli = [](double x) { return static_cast<std::int64_t>(std::llrint(x * 1000.0)); };
  ShotSetPoints s;
  s.angle_centideg = to_centi_degrees(commanded_phase(c));
  s.hold_ms = milli(c.hold_time);
  s.tolerance_mdeg = milli(degrees(c.angle_tolerance));
  if (!with_source) return s;
  s.source.emplace();
  s.source->supply_millivolts = milli(c.supply_volts);
  s.source->mains_millihertz = milli(c.mains_hertz);
  s.source->ambient_millidegc = milli(c.ambient - zero_celsius);
  s.source->seed = static_cast<std::int64_t>(c.seed % 1'000'000'000'000'000'000ULL);
  return s;
}

bool has_latched(const SealedShot& shot, const ShotSetPoints& s) {
  const bool same = shot.angle_centideg == s.angle_centideg && shot.hold_ms == s.hold_ms &&
                    shot.touch_us == s.touch_us && shot.tolerance_mdeg == s.tolerance_mdeg &&
                    shot.source.has_value() == s.source.has_value();
  return same && (!s.source || (shot.source->supply_millivolts == s.source->supply_millivolts &&
                                shot.source->mains_millihertz == s.source->mains_millihertz &&
                                shot.source->ambient_millidegc == s.source->ambient_millidegc &&
                                shot.source->seed == s.source->seed));
}

}  // namespace powbench::rigs
