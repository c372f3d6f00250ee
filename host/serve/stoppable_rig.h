#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "rigs/rig.h"

namespace powbench::host {

/// A rig that fires nothing once a stop is asked for. `inside` is raised before the stop is looked at: whoever sets
/// the stop first and then finds nobody inside knows that nothing will be fired.
class StoppableRig final : public rigs::Rig {
 public:
  StoppableRig(std::unique_ptr<rigs::Rig> rig, const std::atomic<bool>& stop, std::atomic<bool>& inside)
      : rig_(std::move(rig)), stop_(stop), inside_(inside) {
    rig_->stop_when([this] { return stop_ || (asked_ && asked_()); });
  }

  const rigs::RigInfo& info() const override { return rig_->info(); }
  rigs::Shot fire(const Conditions& c, std::chrono::milliseconds limit) override {
    const Inside inside(inside_);
    if (stop_) return stopped();
    rigs::Shot shot = rig_->fire(c, limit);
    if (stop_ && shot.outcome != Outcome::pass &&
        shot.reason != rigs::stopped_words) {  // its own words are of any client that stops
      shot.outcome = Outcome::aborted;
      // to the rig this stop came by another line
      constexpr std::string_view stranger = ": stopped by a client that is not the owner";
      if (shot.reason.ends_with(stranger)) shot.reason.resize(shot.reason.size() - stranger.size());
      shot.reason = "stopped by the operator; the rig: " + shot.reason;
    }
    return shot;
  }
  std::optional<rigs::Shot> recover(std::chrono::milliseconds limit) override {
    const Inside inside(inside_);
    if (stop_) return stopped();
    return rig_->recover(limit);
  }
  void stop_when(std::function<bool()> asked) override { asked_ = std::move(asked); }
  bool abort() override { return rig_->abort(); }
  bool reconnect() override { return rig_->reconnect(); }

 private:
  struct Inside {
    explicit Inside(std::atomic<bool>& f) : flag(f) { flag = true; }
    ~Inside() { flag = false; }
    std::atomic<bool>& flag;
  };
  static rigs::Shot stopped() {
    rigs::Shot shot;
    shot.outcome = Outcome::aborted;
    shot.reason = rigs::stopped_words;
    return shot;
  }

  std::unique_ptr<rigs::Rig> rig_;
  const std::atomic<bool>& stop_;
  std::function<bool()> asked_;
  std::atomic<bool>& inside_;
};

}  // namespace powbench::host
