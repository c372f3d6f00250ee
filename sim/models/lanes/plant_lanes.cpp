#include "sim/models/lanes/plant_lanes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "sim/models/lanes/lane_block.h"
#include "sim/models/plant_impl.h"

namespace powbench::sim {

class PlantLanes {
 public:
  PlantLanes(const std::function<LaneRun()>& next, const std::function<void(Plant&)>& done,
             const LaneFailure& failed, LaneKernel kernel)
      : next_(next), done_(done), failed_(failed), kernel_(kernel) {}

  void run() {
    while (true) {
      for (int k = 0; k < lane_width; ++k) prepare(k);
      if (taken_ == 0) return;
      kernel_(layout_, *block_);
      for (int k = 0; k < lane_width; ++k)
        if (seat(k).plant != nullptr) judge(k);
    }
  }

 private:
  struct Seat {
    Plant* plant = nullptr;
    double t_end = 0, step = 0;
    bool loaded = false;    ///< state and modes of the plant are in the lane
    bool rejected = false;  ///< a try of this step failed
  };
  struct Waiting {
    LaneRun run;
    LaneLayout layout;
  };
  Seat& seat(int k) { return seats_[static_cast<std::size_t>(k)]; }
  static Plant::Impl& inside(Plant& p) { return *p.impl_; }

  /// Until its lane has something to step, or nothing is left.
  void prepare(int k) {
    while (seat(k).plant != nullptr || take(k)) {
      if (begin(k)) return;
      leave(k);
    }
  }

  /// A plant for lane k: one that waits, or the next that has the number of states of its neighbours. Others wait until
  /// the lanes are empty; where many do, the lanes run empty for them.
  bool take(int k) {
    constexpr std::size_t most_waiting = 64;
    const auto fits = [&](const Waiting& w) { return taken_ == 0 || w.layout == layout_; };
    if (const auto it = std::find_if(waiting_.begin(), waiting_.end(), fits); it != waiting_.end()) {
      const Waiting w = *it;
      waiting_.erase(it);
      seat_at(k, w);
      return true;
    }
    while (!all_taken_ && waiting_.size() < most_waiting) {
      Waiting w{next_(), {}};
      all_taken_ = w.run.plant == nullptr;
      if (all_taken_) return false;
      const Plant::Impl& p = inside(*w.run.plant);
      if (p.at_rest || p.integrator.end() >= w.run.t_end || !p.model.lane_layout(w.layout)) {
        finish(*w.run.plant, w.run.t_end);
      } else if (fits(w)) {
        seat_at(k, w);
        return true;
      } else {
        waiting_.push_back(w);
      }
    }
    return false;
  }

  void seat_at(int k, const Waiting& w) {
    layout_ = w.layout;
    ++taken_;
    seat(k) = {w.run.plant, w.run.t_end};
    const Plant::Impl& p = inside(*w.run.plant);
    p.model.put_numbers(*block_, k);
    for (int i = 0; i < layout_.size; ++i)
      block_->tolerance[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] =
          p.integrator.tolerance() * p.model.scale(i);
  }

  /// The next try of its step; false: the lanes do not know the modes it is in now.
  bool begin(int k) {
    Seat& s = seat(k);
    const auto lane = static_cast<std::size_t>(k);
    Plant::Impl& p = inside(*s.plant);
    if (!s.rejected && (p.integrator.open_step() || !s.loaded)) {
      LaneLayout l;
      if (!p.model.lane_layout(l) || l != layout_) return false;
      load(k);
    }
    s.step = block_->step[lane] = p.integrator.next_step();
    block_->begin[lane] = p.integrator.begin();
    if (block_->one_sine[lane] != 0) return true;
    for (std::size_t stage = 1; stage < stage_times.size(); ++stage)
      block_->source[stage][lane] =
          p.model.supply().voltage(p.integrator.begin() + stage_times[stage] * s.step);
    return true;
  }

  void load(int k) {
    Seat& s = seat(k);
    const auto lane = static_cast<std::size_t>(k);
    Plant::Impl& p = inside(*s.plant);
    const ContactorModel::State& y = p.integrator.end_state();
    ContactorModel::State slope;
    p.integrator.first_slope(slope);
    for (std::size_t i = 0; i < static_cast<std::size_t>(layout_.size); ++i)
      block_->y[i][lane] = y[i], block_->first_slope[i][lane] = slope[i];
    p.model.put_modes(*block_, k);
    put_source(p.model.supply(), k);
    block_->accepted[lane] = 0;
    s.loaded = true;
  }

  void put_source(const SupplyModes& supply, int k) {
    const auto lane = static_cast<std::size_t>(k);
    const double rate = supply.rate(), phase = supply.phase();
    const bool bounded = std::fabs(rate * seat(k).t_end + phase) < sine_bound - 1;  // a step may pass the end
    block_->one_sine[lane] = supply.one_sine() && bounded ? -1 : 0;
    block_->amplitude[lane] = supply.amplitude();
    block_->rate[lane] = rate;
    block_->phase[lane] = phase;
  }

  void judge(int k) {
    bool over = false;
    try {
      over = stepped(k);
    } catch (const std::runtime_error&) {
      if (!failed_) throw;
      Plant& plant = *seat(k).plant;
      free(k);
      failed_(plant);
      return;
    }
    if (over) leave(k);
  }

  /// What came of the try of its step; true: it is at its end.
  bool stepped(int k) {
    Seat& s = seat(k);
    const auto lane = static_cast<std::size_t>(k);
    Plant::Impl& p = inside(*s.plant);
    block_->accepted[lane] = 0;
    if (!p.integrator.judge(s.step, block_->error[lane], s.rejected)) {
      if (s.step <= p.integrator.smallest_step) p.refuse_step();
      s.rejected = true;
      return false;
    }
    s.rejected = false;
    const bool change_due = p.model.supply().next_change() - (p.integrator.begin() + s.step) < 0;
    const bool looked = block_->interesting[lane] != 0 || change_due;
    double share = 1;
    if (looked) {
      unload(k);
      share = p.integrator.locate_zero(samples(k));
    }
    p.integrator.close_step(share);
    const bool over = p.integrator.end() >= s.t_end, weighed = ++p.steps % 32 == 0;
    if (!looked && (over || weighed)) unload(k);
    if (weighed) p.judge_energy();
    if (share == 1) block_->accepted[lane] = -1;
    return over;
  }

  /// The step taken, out of the lane.
  void unload(int k) {
    const auto lane = static_cast<std::size_t>(k);
    inside(*seat(k).plant).integrator.take([&](auto& dense, auto& y) {
      for (std::size_t i = 0; i < static_cast<std::size_t>(layout_.size); ++i) {
        y[i] = block_->result[i][lane];
        for (std::size_t c = 0; c < dense.c.size(); ++c) dense.c[c][i] = block_->dense[c][i][lane];
      }
    });
  }

  /// The guards of its step as the kernel found them, and those that it does not know.
  const EventIntegrator<ContactorModel>::Samples& samples(int k) {
    const auto lane = static_cast<std::size_t>(k), contacts = static_cast<std::size_t>(layout_.contacts);
    const Plant::Impl& p = inside(*seat(k).plant);
    for (std::size_t part = 0; part < samples_.size(); ++part) {
      auto& g = samples_[part];
      for (std::size_t i = 0; i <= contacts; ++i) g[i] = block_->guard[part][i][lane];
      g[contacts + 1] = 1;  // nothing of the coil is watched
      const double share = static_cast<double>(part) / EventIntegrator<ContactorModel>::parts;
      g[contacts + 2] = p.model.supply().next_change() - (p.integrator.begin() + share * seat(k).step);
    }
    return samples_;
  }

  /// Alone to its end, where it is not there yet.
  void leave(int k) {
    Plant& plant = *seat(k).plant;
    const double t_end = seat(k).t_end;
    free(k);
    finish(plant, t_end);
  }

  void free(int k) {
    seat(k) = {};
    --taken_;
    all_taken_ = false;
  }

  void finish(Plant& plant, double t_end) {
    all_taken_ = false;
    try {
      plant.advance(t_end, {}, {});
    } catch (const std::runtime_error&) {
      if (!failed_) throw;
      failed_(plant);
      return;
    }
    done_(plant);
  }

  const std::function<LaneRun()>& next_;
  const std::function<void(Plant&)>& done_;
  const LaneFailure& failed_;
  const LaneKernel kernel_;
  std::unique_ptr<LaneBlock> block_ = std::make_unique<LaneBlock>();
  std::array<Seat, lane_width> seats_{};
  std::vector<Waiting> waiting_;
  LaneLayout layout_;
  EventIntegrator<ContactorModel>::Samples samples_{};
  int taken_ = 0;
  bool all_taken_ = false;  ///< there is none until one more has ended
};

void advance_in_lanes(const std::function<LaneRun()>& next, const std::function<void(Plant&)>& done,
                      const LaneFailure& failed, LaneKernel kernel) {
  PlantLanes(next, done, failed, kernel).run();
}

}  // namespace powbench::sim
