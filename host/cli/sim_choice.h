#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/cli/verbs.h"
#include "host/gather/scene.h"
#include "host/study/scene_fields.h"
#include "sim/study/scene_choice.h"

/// Which model `powbench sim` takes, and what is known of its error.

namespace powbench::host {

/// What is asked of the simulation; nothing: the plant of the simulated rig.
struct Wish {
  std::string fields, mechanics;
  sim::WantedTimes wanted{};
  bool accuracy = false;
  bool any() const { return accuracy || !fields.empty() || !mechanics.empty(); }
};

Wish wish_of(const SimArgs&, const Plan&);

/// What the scene needs at each of its angles.
struct JudgedAngles {
  std::vector<std::pair<double, sim::SceneChoice>> all;  ///< closing angle, deg, ascending
  bool others_left_out = false;                          ///< a closing takes seconds: the least angle alone

  /// What is taken for all angles: the highest that one needs, at the finest setting.
  const sim::SceneChoice& taken() const;
  /// The angle where it is furthest from what is wanted.
  const std::pair<double, sim::SceneChoice>& worst() const;
  sim::Reached reached() const { return worst().second.reached(); }
};

/// At every closing angle of the scene. Where neither an accuracy nor a choice is asked for, and where a closing takes
/// seconds: at the least angle alone.
JudgedAngles choose(const Wish&, const Scene&, const sim::Supply& bench, const FieldCache&,
                    const sim::CpuClock&);

void print_choice(const JudgedAngles&, const Wish&, const sim::Specimen&);
std::string choice_json(const JudgedAngles&, bool wanted);

}  // namespace powbench::host
