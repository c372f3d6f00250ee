#include "host/cli/scene_text.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace powbench::host {

std::string us_text(double seconds) {
  return std::isnan(seconds) ? "-" : std::isinf(seconds) ? "no" : fmt::format("{:.3g}", seconds * 1e6);
}

std::string known_or(double seconds) {
  return std::isnan(seconds) ? "not known" : us_text(seconds);
}

std::string axis_text(const sim::AxisError& e, std::size_t q) {
  if (!std::isnan(e.above[q])) return us_text(e.above[q]);
  return std::isnan(e.below[q]) ? "?" : "(" + us_text(e.below[q]) + ")";
}

std::string step_json(const sim::SceneStep& s) {
  using Json = nlohmann::ordered_json;
  return Json{{"rung", s.name},
              {s.setting_name, s.run.tolerance},
              {"times_s", s.run.times},
              {"step_error_s", s.step_error},
              {"field_error_s", s.fields.above},
              {"field_error_of_rung_below_s", s.fields.below},
              {"mechanics_error_s", s.mechanics.above},
              {"to_best_pair_s", s.to_best},
              {"mechanics_error_of_rung_below_s", s.mechanics.below},
              {"model_error_s", s.model_error},
              {"known_share_of_wanted", s.share},
              {"unknown", s.unknown},
              {"cpu_ms", s.run.cpu > 0 ? Json(s.run.cpu * 1e3) : Json()}}
      .dump();
}

}  // namespace powbench::host
