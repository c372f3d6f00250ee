// A whole closing with deforming parts: cost and error by size of cell, beside the lumped model; with films and pictures.
//   bench_solid_closing [--json PATH] [--files FOLDER] [--picture SVG]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/units.h"
#include "host/export/gltf.h"
#include "host/export/vtu.h"
#include "sim/closing.h"
#include "sim/solid/solid_closing.h"
#include "sim/specimen_potential.h"

namespace {

using namespace powbench;
using namespace powbench::sim;

double cpu_now() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Writes the states it is shown, keeps the motion for a film and the most stressed state for the picture.
class Watcher {
 public:
  explicit Watcher(std::string folder) : folder_(std::move(folder)) {}

  void operator()(const ExplicitSolid& s, const ContactorMesh& c) {
    contactor_ = c;
    if (!s.is_rigid(c.mover) && s.time() < next_) return;
    next_ = s.time() + 2e-4;
    times_.push_back(static_cast<float>(s.time() * 100));  // a hundredth of the speed
    for (int p = 0; p < static_cast<int>(c.mesh.parts.size()); ++p) {
      const Vec3 u = s.mean_displacement(p);
      shifts_[p].push_back({static_cast<float>(u.x), static_cast<float>(u.z), static_cast<float>(-u.y)});
    }
    const auto stress = s.cells().stresses(s.displacements());
    double sum = 0;
    for (const auto& k : stress) sum += von_mises(k);
    if (sum > most_) {
      most_ = sum;
      picture_time = s.time();
      mises.clear();
      for (const auto& k : stress) mises.push_back(von_mises(k));
      places.clear();
      for (int n = 0; n < static_cast<int>(c.mesh.nodes.size()); ++n)
        places.push_back(c.mesh.nodes[static_cast<std::size_t>(n)] + s.displacement(n));
    }
    if (!folder_.empty()) write_state(s, c, stress);
  }

  void finish() const {
    if (folder_.empty()) return;
    std::ofstream(folder_ + "/closing.pvd") << host::to_pvd(steps_);
    host::GltfFilm film{times_, {}};
    for (int p = 0; p < static_cast<int>(contactor_.mesh.parts.size()); ++p) film.bodies.push_back(body(p));
    std::ofstream(folder_ + "/closing.gltf") << host::to_gltf(film);
  }

  const ContactorMesh& contactor() const { return contactor_; }

  double picture_time = 0;
  std::vector<double> mises;
  std::vector<Vec3> places;

 private:
  host::GltfBody body(int part) const {
    host::GltfBody b;
    b.name = contactor_.mesh.parts[static_cast<std::size_t>(part)];
    b.shift = shifts_.at(part);
    b.colour = part == contactor_.mover  ? std::array<float, 4>{0.35F, 0.45F, 0.6F, 1}
               : part == contactor_.base ? std::array<float, 4>{0.6F, 0.6F, 0.6F, 1}
                                         : std::array<float, 4>{0.8F, 0.45F, 0.2F, 1};
    const SolidSurface skin =
        surface_of(contactor_.mesh, part, contactor_.materials[static_cast<std::size_t>(part)]);
    for (const int n : skin.nodes) {  // y is up in glTF
      const Vec3& p = contactor_.mesh.nodes[static_cast<std::size_t>(n)];
      b.points.push_back({static_cast<float>(p.x), static_cast<float>(p.z), static_cast<float>(-p.y)});
    }
    for (const Facet& f : skin.facets) {
      std::array<std::uint32_t, 4> k{};
      for (std::size_t c = 0; c < 4; ++c) k[c] = static_cast<std::uint32_t>(skin.place_of(f.nodes[c]));
      b.faces.push_back({k[0], k[1], k[2]});
      b.faces.push_back({k[0], k[2], k[3]});
    }
    return b;
  }

  void write_state(const ExplicitSolid& s, const ContactorMesh& c, const std::vector<CellStress>& stress) {
    host::VtuGrid g;
    host::VtuField u{"displacement [m]", 3, {}}, v{"velocity [m/s]", 3, {}},
        m{"von Mises stress [Pa]", 1, {}};
    for (int n = 0; n < static_cast<int>(c.mesh.nodes.size()); ++n) {
      const Vec3 &p = c.mesh.nodes[static_cast<std::size_t>(n)], d = s.displacement(n), w = s.velocity(n);
      for (int i = 0; i < 3; ++i) {
        g.points.push_back(p[i] + d[i]);
        u.values.push_back(d[i]);
        v.values.push_back(w[i]);
      }
    }
    for (std::size_t e = 0; e < c.mesh.cells.size(); ++e) {
      const auto& n = c.mesh.cells[e].nodes;
      g.add_cell(host::VtkCell::hexahedron, {n.begin(), n.end()});
      m.values.push_back(von_mises(stress[e]));
    }
    g.point_fields = {u, v};
    g.cell_fields = {m};
    const std::string name = "closing_" + std::to_string(steps_.size()) + ".vtu";
    std::ofstream(folder_ + "/" + name, std::ios::binary) << host::to_vtu(g);
    steps_.push_back({s.time(), name, 0});
  }

  std::string folder_;
  ContactorMesh contactor_;
  std::vector<float> times_;
  std::map<int, std::vector<std::array<float, 3>>> shifts_;
  std::vector<host::PvdStep> steps_;
  double next_ = 0, most_ = -1;
};

/// Faces that look at the viewer, far ones first, coloured by the stress of their cells.
std::string picture(const Watcher& w) {
  const Vec3 view = unit({0.45, -0.8, 0.4}), right = unit(cross({0, 0, 1}, view)), up = cross(view, right);
  struct Face {
    double depth;
    std::string points, colour;
  };
  std::vector<Face> faces;
  std::vector<double> sorted = w.mises;
  std::sort(sorted.begin(), sorted.end());
  const double top = std::max(1.0, sorted[sorted.size() * 99 / 100]);
  constexpr double scale = 11000, cx = 330, cy = 290;
  for (int p = 0; p < static_cast<int>(w.contactor().mesh.parts.size()); ++p) {
    const SolidSurface skin =
        surface_of(w.contactor().mesh, p, w.contactor().materials[static_cast<std::size_t>(p)]);
    for (const Facet& f : skin.facets) {
      std::array<Vec3, 4> c{};
      Vec3 middle;
      for (std::size_t k = 0; k < 4; ++k)
        middle += 0.25 * (c[k] = w.places[static_cast<std::size_t>(f.nodes[k])]);
      const Vec3 normal = unit(facet_normal(c, 4));
      if (dot(normal, view) <= 0) continue;
      char text[200];
      std::string points;
      for (const Vec3& q : c) {
        std::snprintf(text, sizeof text, "%.1f,%.1f ", cx + scale * dot(q, right), cy - scale * dot(q, up));
        points += text;
      }
      const double s = std::min(1.0, w.mises[static_cast<std::size_t>(f.cell)] / top),
                   light = 0.75 + 0.25 * dot(normal, view);
      const double r = 60 + 195 * s, g = 90 + 130 * std::sin(3.14159 * s), b = 200 * (1 - s) + 30;
      std::snprintf(text, sizeof text, "rgb(%.0f,%.0f,%.0f)", r * light, g * light, b * light);
      faces.push_back({dot(middle, view), points, text});
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.depth < b.depth; });
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 -40 660 680\" font-family=\"sans-serif\">\n"
      "<rect y=\"-40\" width=\"660\" height=\"680\" fill=\"white\"/>\n";
  for (const Face& f : faces)
    svg += "<polygon points=\"" + f.points + "\" fill=\"" + f.colour +
           "\" stroke=\"#333\" stroke-width=\"0.3\"/>\n";
  char text[300];
  for (int k = 0; k <= 20; ++k) {
    const double s = k / 20.0;
    std::snprintf(text, sizeof text,
                  "<rect x=\"%d\" y=\"605\" width=\"11\" height=\"12\" fill=\"rgb(%.0f,%.0f,%.0f)\"/>\n",
                  20 + 11 * k, 60 + 195 * s, 90 + 130 * std::sin(3.14159 * s), 200 * (1 - s) + 30);
    svg += text;
  }
  std::snprintf(text, sizeof text,
                "<text x=\"260\" y=\"616\" font-size=\"13\">0 .. %.1f MPa von Mises stress, %.2f ms after "
                "switch-on</text>\n",
                1e-6 * top, 1e3 * w.picture_time);
  return svg + text + "</svg>\n";
}

}  // namespace

int main(int argc, char** argv) {
  std::string json_path, folder, svg;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--json") == 0) json_path = argv[i + 1];
    if (std::strcmp(argv[i], "--files") == 0) folder = argv[i + 1];
    if (std::strcmp(argv[i], "--picture") == 0) svg = argv[i + 1];
  }
  if (!folder.empty()) std::filesystem::create_directories(folder);
  const Specimen specimen;
  Conditions conditions;
  conditions.closing_angle = radians(90);
  const auto lumped = simulate(specimen, conditions, 0.04, 0).truth;
  const SpecimenPotential field(specimen);
  std::printf(
      "Closing at 90 deg, 230 V, to 24 ms; lumped model: touch %.3f, seat %.3f, settled %.3f ms, %zu "
      "openings\n",
      1e3 * lumped.touch.value_or(0), 1e3 * lumped.core_seat.value_or(0), 1e3 * lumped.settled.value_or(0),
      lumped.openings.size());
  std::printf("%-10s %7s %10s %10s %9s %9s %9s %9s %9s %9s %8s\n", "parts", "cells", "rigid", "deformed",
              "touch ms", "seat ms", "last ms", "openings", "peak N", "residual", "CPU s");
  auto list = nlohmann::ordered_json::array();
  for (const double cell : {0.0, 6e-3, 4e-3, 3e-3}) {
    SolidClosingOptions options;
    options.deform = cell > 0;
    options.cell = cell > 0 ? cell : 4e-3;
    options.end = 24e-3;
    options.solid.energy_bound = 0.1;
    Watcher watch(cell == 3e-3 ? folder : "");
    const bool watched = cell == 3e-3 && (!folder.empty() || !svg.empty());
    const double start = cpu_now();
    const auto r = solid_closing(
        specimen, conditions, field, options,
        watched ? std::function<void(const ExplicitSolid&, const ContactorMesh&)>(std::ref(watch)) : nullptr);
    const double cpu = cpu_now() - start;
    std::printf("%-10s %7ld %10ld %10ld %9.3f %9.3f %9.3f %9d %9.1f %9.1e %8.1f\n",
                cell > 0 ? "deforming" : "rigid", r.cells, r.rigid_steps, r.deformed_steps,
                1e3 * r.first_touch, 1e3 * r.core_seat, 1e3 * r.last_touch, r.openings, r.peak_force,
                r.residual, cpu);
    list.push_back({{"cell_m", cell},
                    {"cells", r.cells},
                    {"rigid_steps", r.rigid_steps},
                    {"deformed_steps", r.deformed_steps},
                    {"touch_s", r.first_touch},
                    {"seat_s", r.core_seat},
                    {"last_touch_s", r.last_touch},
                    {"openings", r.openings},
                    {"peak_force_N", r.peak_force},
                    {"energy_residual", r.residual},
                    {"cpu_s", cpu}});
    if (!watched) continue;
    watch.finish();
    if (!svg.empty()) std::ofstream(svg) << picture(watch);
  }
  if (!json_path.empty()) {
    std::ofstream out(json_path);
    out << nlohmann::ordered_json{{"benchmark", "solid_closing"}, {"rows", list}}.dump(2) << '\n';
    if (!out) {
      std::fprintf(stderr, "solid_closing: cannot write %s\n", json_path.c_str());
      return 2;
    }
  }
  return 0;
}
