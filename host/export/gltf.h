#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// Moving bodies as glTF 2.0: one file that any viewer plays.

namespace powbench::host {

/// A body drawn by triangles of its skin, at rest, with its own colour and its motion.
struct GltfBody {
  std::string name;
  std::vector<std::array<float, 3>> points;         ///< m, at rest
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< corners anticlockwise from outside
  std::array<float, 4> colour{0.7F, 0.7F, 0.7F, 1.0F};
  std::vector<std::array<float, 3>> shift;  ///< m, at each time of the film
  std::vector<std::array<float, 4>>
      turn;  ///< unit quaternion x y z w at each time, about `centre`; empty: none
  std::array<float, 3> centre{0, 0, 0};  ///< m, at rest
};

struct GltfFilm {
  std::vector<float> times;  ///< s, ascending, as the viewer shall play them
  std::vector<GltfBody> bodies;
};

/// The film as one glTF text with its numbers inside (base64). Throws std::invalid_argument where a body's motion has
/// not one entry a time, a face names a missing point, times do not ascend, or a body is empty.
std::string to_gltf(const GltfFilm&);

}  // namespace powbench::host
