#pragma once

#include <memory>

#include "sim/magnetics/potential.h"
#include "sim/models/closing.h"

namespace powbench::sim {

/// Counts the states of the steps taken, and of these the ones that its potential had to extrapolate: a step that was
/// tried in vain may have looked anywhere. For one run.
class CountingPotential final : public MagneticPotential {
 public:
  explicit CountingPotential(std::shared_ptr<const MagneticPotential> inner) : inner_(std::move(inner)) {}

  bool has_ring() const override { return inner_->has_ring(); }
  MagneticResponse at(const MagneticState& s) const override {
    const MagneticResponse r = inner_->at(s);
    ++tried_.states, tried_.beyond += r.beyond ? 1 : 0;
    return r;
  }
  void tried(bool taken) const override {
    if (taken) states_ += tried_.states, beyond_ += tried_.beyond;
    tried_ = {};
  }
  Trajectory told(Trajectory t) const {
    tried(true);  // by an engine that tells nothing, or after its last step
    t.field_states = states_, t.field_beyond = beyond_;
    return t;
  }

 private:
  std::shared_ptr<const MagneticPotential> inner_;
  mutable std::int64_t states_ = 0, beyond_ = 0;
  struct Tried {
    std::int64_t states = 0, beyond = 0;
  };
  mutable Tried tried_;  ///< since the last step
};

}  // namespace powbench::sim
