// A whole closing with deforming parts: cost and error by size of cell, beside the lumped model; with a picture.
//   bench_solid_closing [--json PATH] [--picture SVG] [--finest MM]   one more row, minutes for 1.5 mm

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/cpu_time.h"
#include "core/units.h"
#include "sim/models/closing.h"
#include "sim/models/solid_closing.h"
#include "sim/specimen/specimen_potential.h"

namespace {

using namespace powbench;
using namespace powbench::sim;

/// Keeps the most stressed state for the picture.
struct MostStressed {
  void operator()(const ExplicitSolid& s, const ContactorMesh& c) {
    const auto stress = s.cells().stresses(s.displacements());
    double sum = 0;
    for (const auto& k : stress) sum += von_mises(k);
    if (sum <= most) return;
    most = sum;
    contactor = c;
    time = s.time();
    mises.clear();
    for (const auto& k : stress) mises.push_back(von_mises(k));
    places.clear();
    for (int n = 0; n < static_cast<int>(c.mesh.nodes.size()); ++n)
      places.push_back(c.mesh.nodes[static_cast<std::size_t>(n)] + s.displacement(n));
  }

  double time = 0, most = -1;
  ContactorMesh contactor;
  std::vector<double> mises;
  std::vector<Vec3> places;
};

/// Faces that look at the viewer, far ones first, coloured by the stress of their cells.
std::string picture(const MostStressed& w) {
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
  for (int p = 0; p < static_cast<int>(w.contactor.mesh.parts.size()); ++p) {
    const SolidSurface skin =
        surface_of(w.contactor.mesh, p, w.contactor.materials[static_cast<std::size_t>(p)]);
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
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 -40 660 730\" font-family=\"sans-serif\">\n"
      "<rect y=\"-40\" width=\"660\" height=\"730\" fill=\"white\"/>\n";
  for (const Face& f : faces)
    svg += "<polygon points=\"" + f.points + "\" fill=\"" + f.colour +
           "\" stroke=\"#333\" stroke-width=\"0.3\"/>\n";
  char text[300];
  for (int k = 0; k <= 20; ++k) {
    const double s = k / 20.0;
    std::snprintf(text, sizeof text,
                  "<rect x=\"%d\" y=\"655\" width=\"11\" height=\"12\" fill=\"rgb(%.0f,%.0f,%.0f)\"/>\n",
                  20 + 11 * k, 60 + 195 * s, 90 + 130 * std::sin(3.14159 * s), 200 * (1 - s) + 30);
    svg += text;
  }
  std::snprintf(text, sizeof text,
                "<text x=\"260\" y=\"666\" font-size=\"13\">0 .. %.1f MPa von Mises stress, %.2f ms after "
                "switch-on</text>\n",
                1e-6 * top, 1e3 * w.time);
  return svg + text + "</svg>\n";
}

}  // namespace

int main(int argc, char** argv) {
  std::string json_path, svg;
  double finest_mm = 0;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--json") == 0) json_path = argv[i + 1];
    if (std::strcmp(argv[i], "--picture") == 0) svg = argv[i + 1];
    if (std::strcmp(argv[i], "--finest") == 0) finest_mm = std::atof(argv[i + 1]);
  }
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
  std::printf("%-10s %7s %10s %10s %9s %9s %9s %9s %9s %9s %9s %8s\n", "parts", "cells", "rigid", "deformed",
              "touch ms", "seat ms", "last ms", "openings", "peak N", "residual", "of coil", "CPU s");
  auto list = nlohmann::ordered_json::array();
  std::vector<SolidClosingResult> results;
  std::vector<double> cells{0, 6e-3, 4e-3, 3e-3};
  if (finest_mm > 0) cells.push_back(1e-3 * finest_mm);
  for (const double cell : cells) {
    SolidClosingOptions options;
    options.deform = cell > 0;
    options.cell = cell > 0 ? cell : 4e-3;
    options.end = 24e-3;
    options.solid.energy_bound = 1e-3;
    MostStressed watch;
    const bool watched = cell == 3e-3 && !svg.empty();
    const double start = process_cpu_seconds();
    const auto r = solid_closing(
        specimen, conditions, field, options,
        watched ? std::function<void(const ExplicitSolid&, const ContactorMesh&)>(std::ref(watch)) : nullptr);
    const double cpu = process_cpu_seconds() - start, of_coil = r.electric.residual() / r.electric.supplied;
    std::printf("%-10s %7ld %10ld %10ld %9.4f %9.4f %9.4f %9d %9.2f %9.1e %9.1e %8.1f\n",
                cell > 0 ? "deforming" : "rigid", r.cells, r.rigid_steps, r.deformed_steps,
                1e3 * r.first_touch, 1e3 * r.core_seat, 1e3 * r.last_touch, r.openings, r.peak_force,
                r.residual, of_coil, cpu);
    std::fflush(stdout);
    results.push_back(r);
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
                    {"coil_residual", of_coil},
                    {"cpu_s", cpu}});
    if (watched) std::ofstream(svg) << picture(watch);
  }
  const SolidClosingResult& finest = results.back();
  for (std::size_t k = 0; k + 1 < results.size(); ++k)
    std::printf(
        "%s, %ld cells, less the finest: touch %+.1f us, seat %+.1f us, last touch %+.1f us, peak %+.1f %%\n",
        k == 0 ? "rigid" : "deforming", results[k].cells, 1e6 * (results[k].first_touch - finest.first_touch),
        1e6 * (results[k].core_seat - finest.core_seat), 1e6 * (results[k].last_touch - finest.last_touch),
        100 * (results[k].peak_force / finest.peak_force - 1));
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
