#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "sim/magnetics/plane/core_mesh.h"
#include "sim/specimen/specimen_fields.h"

namespace sim = powbench::sim;

namespace {

/// The first word of every error of a shape.
std::vector<std::string> keys_of(const sim::MagnetShape& s) {
  std::vector<std::string> keys;
  for (const auto& e : sim::shape_errors(s)) keys.push_back(e.key);
  return keys;
}

bool refuses(const sim::MagnetShape& s, const std::string& key) {
  const auto keys = keys_of(s);
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

}  // namespace

TEST_CASE("a length of the shape given in m where mm are meant, or the other way round, is out of range") {
  for (const auto& f : sim::specimen_fields()) {
    if (f.section != "shape" || !f.key.ends_with("_mm")) continue;
    const std::string key = "shape." + std::string(f.key);
    sim::Specimen specimen;
    const double value = f.get(specimen);
    CAPTURE(key, value);
    if (value == 0) continue;  // a centre leg that is not shorter has no unit
    f.set(specimen, value * 1000);
    CHECK(refuses(specimen.shape, key));
    f.set(specimen, value / 1000);
    if (f.low > 0) CHECK(refuses(specimen.shape, key));
  }
}

TEST_CASE("parts of a core that overlap or do not fit are named, all at once, and the mesh is refused") {
  const sim::MagnetShape good;
  CHECK(keys_of(good).empty());
  struct Case {
    const char* key;
    double sim::MagnetShape::*length;
    double value;
  };
  for (const auto& c : {Case{"shape.coil_width_mm", &sim::MagnetShape::coil_width, 9.1e-3},
                        Case{"shape.coil_height_mm", &sim::MagnetShape::coil_height, 16.5e-3},
                        Case{"shape.coil_height_mm", &sim::MagnetShape::coil_offset, 3e-3},
                        Case{"shape.ring_slot_mm", &sim::MagnetShape::ring_slot, 4e-3},
                        Case{"shape.ring_depth_mm", &sim::MagnetShape::ring_depth, 9e-3},
                        Case{"shape.ring_share", &sim::MagnetShape::ring_share, 1.0},
                        Case{"shape.centre_gap_mm", &sim::MagnetShape::centre_gap, 1.9e-3},
                        Case{"shape.centre_gap_mm", &sim::MagnetShape::centre_gap, -0.1e-3},
                        Case{"shape.stack_factor", &sim::MagnetShape::stack_factor, 1.1}}) {
    sim::MagnetShape s;
    s.*c.length = c.value;
    CAPTURE(c.key, c.value);
    CHECK(refuses(s, c.key));
    CHECK_THROWS_WITH(sim::core_mesh(s, {}, 6e-3), Catch::Contains(c.key) && Catch::Contains("allowed"));
  }
  sim::MagnetShape s;
  s.ring_slot = 5e-3;
  s.coil_width = 20e-3;
  CHECK(keys_of(s).size() == 3);  // and no room is left for the ring beside the leg
}
