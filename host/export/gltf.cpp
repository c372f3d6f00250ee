#include "host/export/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host/export/base64.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr int float_type = 5126, index_type = 5125, vertex_target = 34962, index_target = 34963;

void check(const GltfFilm& film) {
  if (film.times.empty() || film.bodies.empty())
    throw std::invalid_argument("glTF film: needs at least one time and one body");
  if (std::adjacent_find(film.times.begin(), film.times.end(), [](float a, float b) { return b <= a; }) !=
      film.times.end())
    throw std::invalid_argument("glTF film: times must ascend");
  for (const GltfBody& b : film.bodies) {
    if (b.points.empty() || b.faces.empty())
      throw std::invalid_argument("glTF body '" + b.name + "': has no points or no faces");
    if (b.shift.size() != film.times.size() || (!b.turn.empty() && b.turn.size() != film.times.size()))
      throw std::invalid_argument(fmt::format("glTF body '{}': {} shifts and {} turns for {} times", b.name,
                                              b.shift.size(), b.turn.size(), film.times.size()));
    for (const auto& f : b.faces)
      for (const auto corner : f)
        if (corner >= b.points.size())
          throw std::invalid_argument(
              fmt::format("glTF body '{}': face corner {} outside [0, {})", b.name, corner, b.points.size()));
  }
}

/// One buffer; every array gets its view and its accessor.
class Builder {
 public:
  Json views = Json::array(), accessors = Json::array();

  template <class T>
  int add(const T* data, std::size_t count, const char* type, int component, int target, bool bounds) {
    const std::size_t offset = bytes_.size(), size = count * sizeof(T);
    bytes_.append(reinterpret_cast<const char*>(data), size);
    while (bytes_.size() % 4 != 0) bytes_ += '\0';
    Json view{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}};
    if (target > 0) view["target"] = target;
    views.push_back(view);
    const bool scalar = std::strcmp(type, "SCALAR") == 0;
    Json accessor{{"bufferView", views.size() - 1},
                  {"componentType", component},
                  {"count", scalar ? size / 4 : count},
                  {"type", type}};
    if (bounds) {  // the standard asks for them on positions and on times
      const std::size_t width = scalar ? 1 : sizeof(T) / 4;
      std::vector<float> lo(width, 3e38F), hi(width, -3e38F);
      const auto* numbers = reinterpret_cast<const float*>(data);
      for (std::size_t k = 0; k < size / 4; ++k) {
        lo[k % width] = std::min(lo[k % width], numbers[k]);
        hi[k % width] = std::max(hi[k % width], numbers[k]);
      }
      accessor["min"] = lo;
      accessor["max"] = hi;
    }
    accessors.push_back(accessor);
    return static_cast<int>(accessors.size()) - 1;
  }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace

std::string to_gltf(const GltfFilm& film) {
  check(film);
  Builder b;
  Json nodes = Json::array(), meshes = Json::array(), materials = Json::array(), samplers = Json::array(),
       channels = Json::array();
  std::vector<int> roots;
  const int times = b.add(film.times.data(), film.times.size(), "SCALAR", float_type, 0, true);
  for (const GltfBody& body : film.bodies) {
    auto local = body.points;  // about the centre, so that a turn is about it
    for (auto& p : local)
      for (std::size_t i = 0; i < 3; ++i) p[i] -= body.centre[i];
    const int places = b.add(local.data(), local.size(), "VEC3", float_type, vertex_target, true);
    const int corners =
        b.add(body.faces.data(), body.faces.size(), "SCALAR", index_type, index_target, false);
    materials.push_back(
        {{"name", body.name},
         {"doubleSided", true},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", body.colour}, {"metallicFactor", 0.2}, {"roughnessFactor", 0.6}}}});
    meshes.push_back({{"name", body.name},
                      {"primitives", Json::array({{{"attributes", {{"POSITION", places}}},
                                                   {"indices", corners},
                                                   {"material", materials.size() - 1},
                                                   {"mode", 4}}})}});
    const int node = static_cast<int>(nodes.size());
    roots.push_back(node);
    nodes.push_back({{"name", body.name}, {"mesh", meshes.size() - 1}, {"translation", body.centre}});
    auto where = body.shift;
    for (auto& p : where)
      for (std::size_t i = 0; i < 3; ++i) p[i] += body.centre[i];
    const auto animate = [&](int output, const char* path) {
      samplers.push_back({{"input", times}, {"output", output}, {"interpolation", "LINEAR"}});
      channels.push_back({{"sampler", samplers.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
    };
    animate(b.add(where.data(), where.size(), "VEC3", float_type, 0, false), "translation");
    if (!body.turn.empty())
      animate(b.add(body.turn.data(), body.turn.size(), "VEC4", float_type, 0, false), "rotation");
  }
  const Json file{
      {"asset", {{"version", "2.0"}, {"generator", "powbench"}}},
      {"scene", 0},
      {"scenes", Json::array({{{"nodes", roots}}})},
      {"nodes", nodes},
      {"meshes", meshes},
      {"materials", materials},
      {"animations", Json::array({{{"name", "closing"}, {"samplers", samplers}, {"channels", channels}}})},
      {"accessors", b.accessors},
      {"bufferViews", b.views},
      {"buffers", Json::array({{{"byteLength", b.bytes().size()},
                                {"uri", "data:application/octet-stream;base64," + base64(b.bytes())}}})}};
  return file.dump();
}

}  // namespace powbench::host
