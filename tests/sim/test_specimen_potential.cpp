#include <catch2/catch.hpp>
#include <cmath>

#include "sim/specimen/specimen_potential.h"

namespace powbench::sim {
namespace {

using Part = double MagneticState::*;
using Value = double MagneticResponse::*;

/// Central difference of `of` by `by`, refined once (Richardson).
double slope(const SpecimenPotential& w, const MagneticState& at, Part by, double step, Value of) {
  const auto once = [&](double h) {
    MagneticState up = at, down = at;
    up.*by += h;
    down.*by -= h;
    return (w.at(up).*of - w.at(down).*of) / (2 * h);
  };
  return (4 * once(step / 2) - once(step)) / 3;
}

void check_derivatives(const Specimen& specimen) {
  const SpecimenPotential w(specimen);
  for (const double gap : {-15e-6, 2e-6, 0.4e-3, 3e-3})
    for (const double psi : {-0.3, 0.05, 0.7, 1.4}) {
      const MagneticState s{psi, 0.5 * psi / specimen.coil.turns, gap};
      const MagneticResponse r = w.at(s);
      INFO("psi " << psi << " gap " << gap);
      const auto agree = [&](double exact, Part by, double step, Value of, double scale) {
        CHECK(slope(w, s, by, step, of) == Approx(exact).epsilon(1e-5).margin(1e-8 * scale));
      };
      const double ring_scale = std::fabs(r.ring_current) + std::fabs(r.current) * specimen.coil.turns;
      agree(r.current, &MagneticState::psi, 1e-4, &MagneticResponse::energy, std::fabs(r.current));
      agree(r.pull, &MagneticState::gap, 4e-7, &MagneticResponse::energy, std::fabs(r.pull));
      agree(r.current_psi, &MagneticState::psi, 1e-4, &MagneticResponse::current, r.current_psi);
      agree(r.current_gap, &MagneticState::gap, 4e-7, &MagneticResponse::current, std::fabs(r.current_gap));
      agree(r.pull_gap, &MagneticState::gap, 4e-7, &MagneticResponse::pull, std::fabs(r.pull_gap));
      agree(r.current_gap, &MagneticState::psi, 1e-4, &MagneticResponse::pull, std::fabs(r.current_gap));
      if (!w.has_ring()) {
        CHECK(r.ring_ring == 0.0);
        continue;
      }
      agree(r.ring_current, &MagneticState::ring, 1e-7, &MagneticResponse::energy, ring_scale);
      agree(r.current_ring, &MagneticState::ring, 1e-7, &MagneticResponse::current,
            std::fabs(r.current_ring));
      agree(r.ring_ring, &MagneticState::ring, 1e-7, &MagneticResponse::ring_current, r.ring_ring);
      agree(r.ring_gap, &MagneticState::gap, 4e-7, &MagneticResponse::ring_current, std::fabs(r.ring_gap));
      agree(r.ring_gap, &MagneticState::ring, 1e-7, &MagneticResponse::pull, std::fabs(r.ring_gap));
    }
}

}  // namespace

TEST_CASE("the specimen's circuit is one potential: every derivative is the slope of what it derives") {
  Specimen specimen;
  check_derivatives(specimen);
  specimen.magnet.shaded_share = 0;
  check_derivatives(specimen);
}

}  // namespace powbench::sim
