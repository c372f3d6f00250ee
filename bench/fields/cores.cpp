// U- and C-cores: states of the own grid beside FreeFem++ on its own mesh, beside a finer own grid, and beside the
// own elements on FreeFem++'s mesh.
//   fields_cores [--json PATH]

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/fields/json_out.h"
#include "bench/fields/two_leg_peer.h"

namespace {

using namespace powbench;
using Json = nlohmann::ordered_json;

Json states(bool closed) {
  sim::MagnetDesign design;
  auto& s = design.shape;
  s.legs = 2;
  s.closed_leg = closed;
  s.ring_share = 0;
  s.outer_width = s.yoke = 12e-3;
  s.stack_factor = 1;
  design.steel = sim::builtin_steel("reference");
  design.residual_gap = 20e-6;
  sim::FieldOptions coarse, fine;
  coarse.sizes = sim::sizes_for(2e-3);
  fine.sizes = sim::sizes_for(2.5e-4);
  sim::MagnetField field(design, coarse), better(design, fine);
  const std::string folder = (std::filesystem::temp_directory_path() / "powbench_fields_cores").string();
  std::printf(
      "%s-core, %g turns: own grid %d unknowns, finer %d; differences of the own grid from them in %%, the "
      "last "
      "column a ratio\n",
      closed ? "C" : "U", design.turns, field.unknowns(), better.unknowns());
  std::printf("%7s %5s %12s %10s %9s %9s %9s %9s %9s %13s\n", "gap mm", "A", "flux Wb", "pull N", "psi fine",
              "F fine", "psi peer", "F peer", "peer dofs", "same mesh psi");
  Json list = Json::array();
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  for (const double gap : {0.1e-3, 0.5e-3, 2e-3, 5e-3})
    for (const double current : {0.2, 1.0, 3.0}) {
      field.set_gap(gap);
      better.set_gap(gap);
      const auto p = field.at_current(current, 0), q = better.at_current(current, 0);
      const double psi = field.fluxes(p).first, f_psi = psi / better.fluxes(q).first - 1,
                   f_pull = p.response.pull / q.response.pull - 1;
      const auto peer = bench::two_legs_by_freefem(folder, design, gap + design.residual_gap, current, 1);
      const double p_psi = peer ? psi / peer->flux - 1 : none,
                   p_pull = peer ? p.response.pull / peer->pull - 1 : none,
                   same = peer ? peer->same_mesh_flux / peer->flux - 1 : none;
      std::printf("%7.2f %5.1f %12.8f %10.4f %+9.3f %+9.3f %+9.3f %+9.3f %9d %+13.1e\n", gap * 1e3, current,
                  psi, p.response.pull, 100 * f_psi, 100 * f_pull, 100 * p_psi, 100 * p_pull,
                  peer ? peer->unknowns : 0, same);
      list.push_back({{"gap_m", gap},
                      {"current_A", current},
                      {"flux_Wb", psi},
                      {"pull_N", p.response.pull},
                      {"psi_to_fine", f_psi},
                      {"pull_to_fine", f_pull},
                      {"psi_to_peer", p_psi},
                      {"pull_to_peer", p_pull},
                      {"psi_on_peers_mesh", same}});
    }
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, nullptr, _IOLBF, 0);
  Json result{{"benchmark", "fields_cores"}};
  result["u_core"] = states(false);
  std::printf("\n");
  result["c_core"] = states(true);
  return bench::write_json(argc, argv, result);
}
