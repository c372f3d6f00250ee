#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host/export/base64.h"
#include "host/export/gltf.h"

using namespace powbench::host;

namespace {

GltfFilm triangle() {
  GltfBody b;
  b.name = "bridge";
  b.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  b.faces = {{0, 1, 2}};
  b.centre = {0.5F, 0, 0};
  b.shift = {{0, 0, 0}, {0, 0, 2}};
  b.turn = {{0, 0, 0, 1}, {0, 0, 1, 0}};
  return {{0, 1}, {b}};
}

}  // namespace

TEST_CASE("a film is valid glTF: every index points at something of the right size") {
  const auto file = nlohmann::json::parse(to_gltf(triangle()));
  CHECK(file["asset"]["version"] == "2.0");
  const auto& views = file["bufferViews"];
  const std::size_t length = file["buffers"][0]["byteLength"];
  const std::size_t width[] = {1, 3, 4};
  for (const auto& a : file["accessors"]) {
    const auto& view = views.at(a["bufferView"].get<std::size_t>());
    const std::string type = a["type"];
    const std::size_t n = type == "SCALAR" ? width[0] : type == "VEC3" ? width[1] : width[2];
    CHECK(view["byteLength"] == 4 * n * a["count"].get<std::size_t>());
    CHECK(view["byteOffset"].get<std::size_t>() % 4 == 0);
    CHECK(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>() <= length);
  }
  const auto& animation = file["animations"][0];
  for (const auto& c : animation["channels"]) {
    const auto& s = animation["samplers"].at(c["sampler"].get<std::size_t>());
    const auto& in = file["accessors"].at(s["input"].get<std::size_t>());
    CHECK(in["count"] == file["accessors"].at(s["output"].get<std::size_t>())["count"]);
    CHECK(in["min"][0] == 0.0);
    CHECK(in["max"][0] == 1.0);
    CHECK(c["target"]["node"].get<std::size_t>() < file["nodes"].size());
  }
  const auto& primitive = file["meshes"][0]["primitives"][0];
  const auto& places = file["accessors"].at(primitive["attributes"]["POSITION"].get<std::size_t>());
  CHECK(places["min"] == nlohmann::json({-0.5, 0.0, 0.0}));  // about the centre
  CHECK(file["accessors"].at(primitive["indices"].get<std::size_t>())["count"] == 3);
  const std::string uri = file["buffers"][0]["uri"];
  CHECK(uri.size() - uri.find(',') - 1 == (length + 2) / 3 * 4);
}

TEST_CASE("a film whose parts do not fit together is refused") {
  GltfFilm backwards = triangle();
  backwards.times = {1, 1};
  CHECK_THROWS_AS(to_gltf(backwards), std::invalid_argument);
  GltfFilm short_motion = triangle();
  short_motion.bodies[0].shift.pop_back();
  CHECK_THROWS_AS(to_gltf(short_motion), std::invalid_argument);
  GltfFilm loose = triangle();
  loose.bodies[0].faces[0][1] = 3;
  CHECK_THROWS_AS(to_gltf(loose), std::invalid_argument);
}

TEST_CASE("base64 pads as the standard says") {
  CHECK(base64("") == "");
  CHECK(base64("f") == "Zg==");
  CHECK(base64("fo") == "Zm8=");
  CHECK(base64("foobar") == "Zm9vYmFy");
}
