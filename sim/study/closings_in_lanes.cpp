#include "sim/study/closings_in_lanes.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <stdexcept>

#include "sim/mechanics/contact_damping.h"
#include "sim/models/lanes/plant_lanes.h"
#include "sim/specimen/validate.h"

namespace powbench::sim {
namespace {

struct Beside {
  std::size_t number;
  double off, duration;
  Plant plant;
};

class ClosingQueue {
 public:
  using Next = std::function<std::optional<LaneClosing>()>;
  using Done = std::function<void(std::size_t, const ClosingTruth&)>;
  ClosingQueue(const Next& next, const Done& done, OnFailure on_failure)
      : next_(next), done_(done), tries_(on_failure == OnFailure::no_closing) {}

  void run() {
    LaneFailure failed;
    if (tries_) failed = [this](Plant& p) { done_(taken(p)->number, {}); };
    advance_in_lanes([this] { return begin(); }, [this](Plant& p) { finish(*taken(p)); }, failed);
  }

 private:
  /// The next one that can be begun.
  LaneRun begin() {
    while (const auto c = next_()) {
      if (!tries_) return seated(*c);
      if (validate(c->what.specimen).empty() && rigid_only(c->what.specimen).empty()) return seated(*c);
      done_(c->number, {});
    }
    return {};
  }

  LaneRun seated(const LaneClosing& c) {
    const double off = std::min(c.what.conditions.hold_time, c.duration);
    all_.push_back(std::make_unique<Beside>(
        Beside{c.number, off, c.duration,
               closing_plant(c.what.specimen, c.what.conditions, c.tolerance, c.what.bench)}));
    return {&all_.back()->plant, off};
  }

  std::unique_ptr<Beside> taken(const Plant& plant) {
    const auto at =
        std::find_if(all_.begin(), all_.end(), [&](const auto& b) { return &b->plant == &plant; });
    std::unique_ptr<Beside> b = std::move(*at);
    all_.erase(at);
    return b;
  }

  void finish(Beside& b) const {
    ClosingTruth truth;
    try {
      if (b.duration > b.off) {
        b.plant.gate(false);
        b.plant.advance(b.duration, {}, {});
      }
      truth = closing_truth(b.plant.events(), b.off);
    } catch (const std::runtime_error&) {
      if (!tries_) throw;
    }
    done_(b.number, truth);
  }

  const Next& next_;
  const Done& done_;
  bool tries_;
  std::vector<std::unique_ptr<Beside>> all_;
};

}  // namespace

void closings_in_lanes(const std::function<std::optional<LaneClosing>()>& next,
                       const std::function<void(std::size_t, const ClosingTruth&)>& done,
                       OnFailure on_failure) {
  ClosingQueue(next, done, on_failure).run();
}

std::vector<ClosingTruth> tried_closings(std::span<const Attempt> list, double tolerance, Team& team,
                                         const ClosingModel& model) {
  std::vector<ClosingTruth> truths(list.size());
  if (model.run) {
    for_each_index(team, static_cast<int>(list.size()), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      truths[k] = model.run(*list[k].specimen, *list[k].conditions, list[k].duration, tolerance);
    });
    return truths;
  }
  std::atomic<std::size_t> begun{0};
  team.run([&](int) {
    closings_in_lanes(
        [&]() -> std::optional<LaneClosing> {
          const std::size_t i = begun.fetch_add(1);
          if (i >= list.size()) return std::nullopt;
          return LaneClosing{i, {*list[i].specimen, *list[i].conditions}, list[i].duration, tolerance};
        },
        [&](std::size_t i, const ClosingTruth& t) { truths[i] = t; }, OnFailure::no_closing);
  });
  return truths;
}

}  // namespace powbench::sim
