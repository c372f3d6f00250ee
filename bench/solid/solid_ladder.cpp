// The rungs of mechanics on one impact: a copper contact bridge (24 x 6 x 1.5 mm) falls with 0.6 m/s from 30 um on two
// sprung pads at its ends. Rigid, reduced to n modes, deformable with cells of h: error in first touch, in the time it
// stays down and in the peak force, against CPU time; reference is the finest deformable run.
//   bench_solid_ladder [--json PATH] [--picture SVG]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/cpu_time.h"
#include "sim/solid/explicit_solid.h"
#include "sim/solid/modal_body.h"

namespace {

using namespace powbench::sim;

constexpr double length = 24e-3, wide = 6e-3, high = 1.5e-3, pad = 2e-3;
constexpr double pad_rate = 3e6, drop = 30e-6, speed = 0.6, until = 400e-6;

struct Impact {
  std::string rung, setting;
  double touch = -1, down = 0, peak = 0;  ///< s, s, N
  double cpu = 0;                         ///< s
};

struct Scene {
  SolidMesh mesh;
  SolidMaterial copper = known_material("copper");
  std::vector<SolidPlane> pads{2};
  std::vector<Attachment> attachments{2};
};

/// Each pad's spring is spread over its square as the area is, so that it is the same on every mesh.
Scene scene(int along, int across, int through) {
  Scene s;
  add_box(s.mesh, s.mesh.add_part("bridge"), {0, 0, 0}, {length, wide, high}, along, across, through);
  s.copper.small_displacement = true;
  const auto share = [](double at, double from, double to, double step) {
    const double lo = std::max(from, at - step / 2), hi = std::min(to, at + step / 2);
    return std::max(0.0, (hi - lo) / (to - from));
  };
  for (std::size_t k = 0; k < 2; ++k) {
    const double from = k == 0 ? 0 : length - pad;
    s.pads[k].point = {0, 0, -drop};
    for (int n = 0; n < static_cast<int>(s.mesh.nodes.size()); ++n) {
      const Vec3& p = s.mesh.nodes[static_cast<std::size_t>(n)];
      const double part = share(p.x, from, from + pad, length / along) *
                          share(p.y, wide / 2 - pad / 2, wide / 2 + pad / 2, wide / across);
      if (p.z > 1e-9 || part < 1e-9) continue;
      s.pads[k].nodes.push_back(n);
      s.pads[k].stiffness.push_back(pad_rate * part);
      s.attachments[k].at.nodes.push_back(n);
      s.attachments[k].at.shares.push_back(part);
    }
  }
  return s;
}

/// Steps any of the rungs until `until`; touch and release are put where the force begins and ends.
template <class Body>
Impact run(Body& body, std::string rung, std::string setting) {
  Impact r{std::move(rung), std::move(setting)};
  double released = 0, before = 0;
  const double start = powbench::process_cpu_seconds();
  while (body.time() < until) {
    body.step();
    const double force = body.plane_force();
    if (force > 0 && r.touch < 0) r.touch = body.time() - body.dt();
    if (force == 0 && before > 0) released = body.time() - body.dt();
    r.peak = std::max(r.peak, force);
    before = force;
  }
  r.cpu = powbench::process_cpu_seconds() - start;
  r.down = released - r.touch;
  return r;
}

Impact explicit_run(int along, int across, int through) {
  const Scene s = scene(along, across, through);
  SolidOptions options;
  options.ledger_every = 0;
  ExplicitSolid body(s.mesh, {s.copper}, options);
  for (const auto& p : s.pads) body.add_plane(p);
  body.set_velocity(0, {0, 0, -speed});
  char name[40];
  std::snprintf(name, sizeof name, "h = %.2f mm", 1e3 * length / along);
  return run(body, "deformable", name);
}

Impact modal_run(int modes, bool attached) {
  const Scene s = scene(48, 12, 3);
  const ModalBody body =
      reduce(s.mesh, s.copper, modes, attached ? s.attachments : std::vector<Attachment>{});
  ModalMotion motion(body, s.mesh, s.pads);
  motion.set_velocity({0, 0, -speed});
  return run(motion, attached ? "modal" : "rigid",
             attached ? std::to_string(body.modes() - 6) + " modes" : "-");
}

double axis(double value, double low, double top) {
  return std::log(std::clamp(value, low, top) / low) / std::log(top / low);
}

/// Peak force's error against CPU time, both logarithmic; a line for each rung.
std::string picture(const std::vector<Impact>& all, const Impact& exact) {
  constexpr double x0 = 80, x1 = 640, y0 = 380, y1 = 50, slow = 1, fast = 1e-5, least = 1e-4, most = 1;
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 700 450\" font-family=\"sans-serif\" "
      "font-size=\"13\">\n<rect width=\"700\" height=\"450\" fill=\"white\"/>\n";
  char text[400];
  for (int d = -5; d <= 0; ++d) {
    const double x = x0 + (x1 - x0) * axis(std::pow(10, d), fast, slow);
    std::snprintf(text, sizeof text,
                  "<path d=\"M%.1f %g V%g\" stroke=\"#ddd\"/><text x=\"%.1f\" y=\"%g\" "
                  "text-anchor=\"middle\">%g</text>\n",
                  x, y0, y1, x, y0 + 18, std::pow(10, d));
    svg += text;
  }
  for (int d = -4; d <= 0; ++d) {
    const double y = y0 + (y1 - y0) * axis(std::pow(10, d), least, most);
    std::snprintf(text, sizeof text,
                  "<path d=\"M%g %.1f H%g\" stroke=\"#ddd\"/><text x=\"%g\" y=\"%.1f\" "
                  "text-anchor=\"end\">%g %%</text>\n",
                  x0, y, x1, x0 - 6, y + 4, 100 * std::pow(10, d));
    svg += text;
  }
  const std::pair<const char*, const char*> colours[] = {
      {"rigid", "#15803d"}, {"modal", "#0b6fa4"}, {"deformable", "#c2410c"}};
  for (const auto& [rung, colour] : colours) {
    for (const bool peak : {true, false}) {
      std::string line;
      for (const Impact& r : all) {
        if (r.rung != rung) continue;
        const double error = peak ? r.peak / exact.peak - 1 : r.down / exact.down - 1;
        const double x = x0 + (x1 - x0) * axis(r.cpu, fast, slow),
                     y = y0 + (y1 - y0) * axis(std::fabs(error), least, most);
        std::snprintf(text, sizeof text, "%.1f,%.1f ", x, y);
        line += text;
        std::snprintf(text, sizeof text,
                      "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"%s\" stroke=\"%s\"/>", x, y,
                      peak ? colour : "white", colour);
        svg += text;
        if (peak) {  // modal ones lie close together
          const bool modal = std::strcmp(rung, "modal") == 0;
          std::snprintf(text, sizeof text,
                        "<text x=\"%.1f\" y=\"%.1f\" fill=\"%s\" font-size=\"11\">%s</text>\n",
                        modal ? x - 5 : x + 8, modal ? y + 18 : y - 6, colour,
                        modal              ? r.setting.substr(0, r.setting.find(' ')).c_str()
                        : r.setting == "-" ? "rigid"
                                           : r.setting.c_str());
          svg += text;
        }
      }
      svg += "<polyline points=\"" + line + "\" fill=\"none\" stroke=\"" + colour + "\"" +
             (peak ? "" : " stroke-dasharray=\"5 4\"") + "/>\n";
    }
  }
  return svg +
         "<text x=\"500\" y=\"80\" fill=\"#0b6fa4\">modal, n modes</text>\n<text x=\"500\" y=\"98\" "
         "fill=\"#c2410c\">deformable, cells h</text>\n<text x=\"360\" y=\"425\" text-anchor=\"middle\">CPU "
         "time of 0.4 ms, s</text>\n<text x=\"80\" "
         "y=\"30\">Error "
         "of the peak force (full) and of the time in touch (dashed) against the finest "
         "cells</text>\n</svg>\n";
}

}  // namespace

int main(int argc, char** argv) {
  std::string json_path, svg;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--json") == 0) json_path = argv[i + 1];
    if (std::strcmp(argv[i], "--picture") == 0) svg = argv[i + 1];
  }
  std::vector<Impact> all{modal_run(0, false)};
  for (const int modes : {0, 2, 6, 12}) all.push_back(modal_run(modes, true));
  for (const int fine : {1, 2, 4}) all.push_back(explicit_run(12 * fine, 3 * fine, fine == 4 ? 3 : fine));
  const Impact exact = explicit_run(96, 24, 6);
  all.push_back(exact);
  std::printf(
      "Bridge on two pads: first touch, time in touch, peak force, and their errors against the last "
      "line\n%-10s %-12s %10s %10s %9s %9s %9s %9s %9s\n",
      "rung", "setting", "touch us", "down us", "peak N", "touch us", "down %", "peak %", "CPU s");
  auto rows = nlohmann::ordered_json::array();
  for (const Impact& r : all) {
    const double touch = 1e6 * (r.touch - exact.touch), down = 100 * (r.down / exact.down - 1),
                 peak = 100 * (r.peak / exact.peak - 1);
    std::printf("%-10s %-12s %10.3f %10.3f %9.2f %+9.3f %+9.3f %+9.3f %9.4f\n", r.rung.c_str(),
                r.setting.c_str(), 1e6 * r.touch, 1e6 * r.down, r.peak, touch, down, peak, r.cpu);
    rows.push_back({{"rung", r.rung},
                    {"setting", r.setting},
                    {"touch_s", r.touch},
                    {"in_touch_s", r.down},
                    {"peak_N", r.peak},
                    {"touch_error_us", touch},
                    {"in_touch_error_percent", down},
                    {"peak_error_percent", peak},
                    {"cpu_s", r.cpu}});
  }
  if (!svg.empty()) std::ofstream(svg) << picture({all.begin(), all.end() - 1}, exact);
  if (!json_path.empty()) {
    std::ofstream out(json_path);
    out << nlohmann::ordered_json{{"benchmark", "solid_ladder"}, {"rows", rows}}.dump(2) << '\n';
    if (!out) {
      std::fprintf(stderr, "solid_ladder: cannot write %s\n", json_path.c_str());
      return 2;
    }
  }
  return 0;
}
