#include "sim/magnetics/space/medium.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace powbench::sim::space {
namespace {

constexpr double mu0 = 4e-7 * std::numbers::pi;

}  // namespace

Medium air() {
  return {mu0, nullptr, 0, 1};
}

Medium solid(const Steel& steel) {
  return {0, std::make_shared<const Steel>(steel), 0, 1};
}

Medium laminated(const Steel& steel, double share, int axis) {
  if (!(share > 0 && share <= 1))
    throw std::invalid_argument("medium: share of iron " + std::to_string(share) +
                                ", allowed above 0 up to 1");
  if (share == 1) return solid(steel);
  const double across = std::min(mu0 / (1 - share), mu0 * steel.peak_permeability());
  return {0, std::make_shared<const Steel>(steel.stacked(share)), across, axis};
}

SteelInverse::SteelInverse(const Steel& steel) : steel_(&steel) {
  for (const auto& k : steel.knots()) h_.push_back(k.h);
}

double SteelInverse::b(double h, SteelPoint& point) const {
  const auto& knots = steel_->knots();
  const auto above = static_cast<std::size_t>(std::upper_bound(h_.begin(), h_.end(), h) - h_.begin());
  assert(above > 0);
  const auto& last = knots[above - 1];
  if (above == h_.size()) {
    const double b = last.b + mu0 * (h - last.h);
    point = steel_->at(b);
    return b;
  }
  double low = last.b, high = knots[above].b;
  double b = low + (high - low) * (h - last.h) / (knots[above].h - last.h);
  for (int k = 0; k < 60; ++k) {
    point = steel_->at(b);
    const double excess = point.h - h;
    (excess > 0 ? high : low) = b;
    const double step = excess / point.dh_db;
    if (std::fabs(step) <= 1e-13 * b) break;
    b = b - step > low && b - step < high ? b - step : 0.5 * (low + high);
  }
  return b;
}

MediumLaw::MediumLaw(const Medium& medium) : medium_(medium) {
  if (medium.steel) inverse_ = std::make_shared<const SteelInverse>(*medium.steel);
}

MediumPoint MediumLaw::at(const Vec3& field) const {
  MediumPoint p;
  if (linear()) {
    for (int k = 0; k < 3; ++k) {
      p.b[k] = medium_.permeability * field[k];
      p.slope[k] = medium_.permeability;
      p.coenergy += 0.5 * p.b[k] * field[k];
    }
    return p;
  }
  Vec3 h = field;  // the part that the steel's curve answers
  if (medium_.across > 0) h[medium_.axis] = 0;
  const double size = std::sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
  SteelPoint steel;
  const double b = inverse_->b(size, steel);
  const double slope = 1 / steel.dh_db;
  const double chord = size > 1e-9 ? b / size : slope;
  p.coenergy = size * b - steel.energy;
  Vec3 n{};
  for (int k = 0; k < 3; ++k) {
    n[k] = size > 1e-9 ? h[k] / size : 0;
    p.b[k] = chord * h[k];
  }
  constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  for (int s = 0; s < 6; ++s) p.slope[s] = (slope - chord) * n[row[s]] * n[column[s]] + (s < 3 ? chord : 0);
  if (medium_.across > 0) {
    const int k = medium_.axis;
    p.slope[k] = medium_.across;
    p.b[k] = medium_.across * field[k];
    p.coenergy += 0.5 * medium_.across * field[k] * field[k];
  }
  return p;
}

}  // namespace powbench::sim::space
