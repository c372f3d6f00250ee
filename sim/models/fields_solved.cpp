#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/magnetics/plane/drawn_magnet.h"
#include "sim/models/field_kinds.h"

namespace powbench::sim {
namespace {

/// The field as a potential that remembers its last solution. Not for two threads. Past the largest gap of its mesh, m,
/// the energy goes on linearly in the gap: steps that are tried look there.
template <class Field>
class SolvedPotential final : public MagneticPotential {
 public:
  template <class Design, class Options>
  SolvedPotential(const Design& design, const Options& options,
                  double largest_gap = std::numeric_limits<double>::infinity())
      : field_(design, options), largest_gap_(largest_gap) {}

  bool has_ring() const override { return field_.has_ring(); }
  MagneticResponse at(const MagneticState& s) const override {
    if (const double sum = s.psi + s.gap + (has_ring() ? s.ring : 0); !std::isfinite(sum)) {
      constexpr double nan = std::numeric_limits<double>::quiet_NaN();  // of a step that is tried in vain
      return {nan, nan, nan, nan, nan, nan, nan, nan, nan, nan};
    }
    field_.set_gap(std::clamp(s.gap, 0.0, largest_gap_));
    constexpr double nothing = 1e-30, little = 1e-9;  // Wb: no flux, and one that saturates nothing
    if (std::fabs(s.psi) < nothing && (!has_ring() || std::fabs(s.ring) < nothing)) {
      const auto linear = field_.at_flux(little, 0, {}).response;
      MagneticResponse none;
      none.current_psi = linear.current_psi;
      none.current_ring = linear.current_ring;
      none.ring_ring = linear.ring_ring;
      return none;
    }
    auto point = field_.at_flux(s.psi, s.ring, last_);
    last_ = point.newton.converged ? std::move(point.a) : std::vector<double>{};
    auto& r = point.response;
    if (const double past = s.gap - largest_gap_; past > 0) {
      r.energy += r.pull * past;
      r.current += r.current_gap * past;
      r.ring_current += r.ring_gap * past;
      r.beyond = true;
    }
    return r;
  }

 private:
  mutable Field field_;
  mutable std::vector<double> last_;
  double largest_gap_;
};

FieldRung solved_rung(const Specimen& s, FieldTables& tables) {
  if (s.drawn) return solved_field(s.drawn, {});
  const MagnetDesign design = magnet_design(s);
  return solved_field(design, plan_table(design, tables.options(s)).field);
}

}  // namespace

FieldRung solved_field(const MagnetDesign& design, const FieldOptions& options) {
  return {"solved", "plane finite elements solved at every step",
          [design, options](const Case&) {
            return std::make_shared<SolvedPotential<MagnetField>>(design, options);
          },
          false, true};
}

FieldRung solved_field(const std::shared_ptr<const DrawnMagnet>& drawing, const NewtonOptions& options) {
  return {"solved", "finite elements of the drawing solved at every step",
          [drawing, options](const Case&) {
            constexpr double spare = 0.99;
            const double largest = spare * usable_gaps(*drawing).second - drawing->residual_gap;
            return std::make_shared<SolvedPotential<DrawnField>>(drawing, options, largest);
          },
          false, true};
}

Fields solved_fields() {
  return {.name = "solved",
          .costly = true,
          .unknown = [](const Specimen& s) { return s.in_space ? has_three_dimensions(s) : no_elements(s); },
          .rung = solved_rung};
}

}  // namespace powbench::sim
