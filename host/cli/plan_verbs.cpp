#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/counted.h"
#include "core/units.h"
#include "host/cli/verbs.h"
#include "host/compare/compare.h"
#include "host/config/solenoid_file.h"
#include "host/gather/scene.h"
#include "host/import/calibration.h"

namespace powbench::host {

Exit check_plan(const PlanArgs& args) {
  const Scene scene = load_scene(args.file);
  fmt::print(stderr, "{}: {} at {} on specimen {}: no mistakes found\n", args.file,
             counted(scene.shots.size(), "shot"), counted(scene.plan.angles.size(), "angle"),
             scene.specimen.name);
  return Exit::pass;
}

Exit show_plan(const PlanArgs& args) {
  const Scene scene = load_scene(args.file);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  if (!args.json)
    fmt::print("{:>5} {:>7} {:>10}  {:>8} {:>6}  {}\n", "shot", "repeat", "angle deg", "supply V", "Hz",
               "seed");
  for (const PlannedShot& s : scene.shots) {
    const double angle = degrees(effective_angle(s.conditions));
    if (args.json)
      list.push_back({{"number", s.index},
                      {"repeat", s.repeat},
                      {"angle_deg", angle},
                      {"supply_volts", s.conditions.supply_volts},
                      {"mains_hertz", s.conditions.mains_hertz},
                      {"seed", s.conditions.seed}});
    else
      fmt::print("{:>5} {:>7} {:>10.2f}  {:>8.1f} {:>6.2f}  {}\n", s.index + 1, s.repeat + 1, angle,
                 s.conditions.supply_volts, s.conditions.mains_hertz, s.conditions.seed);
  }
  if (args.json) fmt::print("{}\n", list.dump(2));
  return Exit::pass;
}

Exit print_template(const std::string& kind) {
  fmt::print("{}", kind == "rig"           ? rig_template()
                   : kind == "specimen"    ? specimen_template()
                   : kind == "solenoid"    ? solenoid_template()
                   : kind == "calibration" ? calibration_template()
                                           : plan_template());
  return Exit::pass;
}

}  // namespace powbench::host
