#pragma once

#include <cstdint>
#include <optional>

#include "core/conditions.h"
#include "firmware/source_device.h"
#include "rigs/sealed_shot.h"

/// The conditions of a shot in the whole numbers of the wire.

namespace powbench::rigs {

/// What a rig is told, and what its sealed shot says it has latched.
struct ShotSetPoints {
  std::int64_t angle_centideg = 0, hold_ms = 0, touch_us = 0, tolerance_mdeg = 0;
  std::optional<firmware::SetPoints> source;  ///< of a rig that has one
};

/// Each rounded to the nearest; the angle is the commanded phase. Of the seed the wire carries 18 decimal digits.
ShotSetPoints shot_set_points(const Conditions&, bool with_source);

/// The sealed shot is one with these set-points.
bool has_latched(const SealedShot&, const ShotSetPoints&);

}  // namespace powbench::rigs
