#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/events/impact.h"
#include "core/record.h"

/// Records of one film for judging the extraction: impacts from their equation of motion, and what else a film shows.
/// Each class changes one thing. Reproducible bit for bit from the seed.

namespace powbench::bench {

struct Scene {
  Record record;
  std::vector<TrueContact> contacts;  ///< empty: nothing touches
};

struct SceneClass {
  std::string name;
  bool touches = true;
  Scene (*make)(std::uint64_t seed) = nullptr;
};

/// Families of pads first, then what disturbs, then records in which nothing touches.
const std::vector<SceneClass>& scene_classes();

}  // namespace powbench::bench
