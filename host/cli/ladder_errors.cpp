#include "host/cli/ladder_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/models/mechanics.h"
#include "sim/study/scene_choice.h"

namespace powbench::host {

sim::LadderTimes ModelError::known() const {
  return whole ? part : sim::nan_times;
}

ModelError model_error_of(std::size_t rung, std::span<const sim::Rung> rungs, const sim::Ladder& ladder) {
  const auto place = [](const std::string& name) { return static_cast<int>(sim::place_of_fields(name)); };
  const auto detail = [](const std::string& name) { return sim::mechanics_named(name).detail; };
  ModelError error{sim::nan_times};
  bool fields = false, mechanics = false;
  for (const auto& m : ladder.models) {
    if (m.rung != rung && m.other != rung) continue;
    const sim::Rung &mine = rungs[rung], &other = rungs[m.rung == rung ? m.other : m.rung];
    const int f = place(other.fields) - place(mine.fields);
    const int k = detail(other.mechanics) - detail(mine.mechanics);
    if (f < 0 || k < 0 || (f == 0 && k == 0)) continue;
    fields = fields || f > 0;
    mechanics = mechanics || k > 0;
    for (std::size_t q = 0; q < error.part.size(); ++q)
      if (!(error.part[q] >= m.difference[q])) error.part[q] = m.difference[q];
  }
  error.whole = fields && mechanics;
  return error;
}

std::string or_not_known(double seconds) {
  return std::isnan(seconds)   ? "not known"
         : std::isinf(seconds) ? "no"
                               : fmt::format("{:.1e}", seconds * 1e6);
}

std::string three_errors_text(const sim::Ladder& ladder, std::span<const sim::Rung> rungs,
                              const sim::LadderTimes& input) {
  std::string text = fmt::format(
      "\nthree errors, us: step at the finest setting of the table, model to the rungs above (+?: nothing is "
      "above in fields or in mechanics), input (0.5 % of the voltage, 2 K of the coil; the specimen's own "
      "numbers: not known)\n{:<18}",
      "rung");
  for (const auto q : sim::ladder_quantities)
    text += fmt::format(" {:>12} {:>10} {:>10}", fmt::format("{}: step", q), "model", "input");
  text += "\n";
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    const auto last = std::find_if(ladder.rows.rbegin(), ladder.rows.rend(),
                                   [&](const auto& row) { return row.run.rung == r; });
    if (last == ladder.rows.rend()) continue;
    const ModelError model = model_error_of(r, rungs, ladder);
    text += fmt::format("{:<18}", rungs[r].name());
    for (std::size_t q = 0; q < input.size(); ++q)
      text +=
          fmt::format(" {:>12} {:>10} {:>10}", or_not_known(last->estimate[q]),
                      or_not_known(model.part[q]) + (model.whole || std::isnan(model.part[q]) ? "" : "+?"),
                      or_not_known(input[q]));
    text += "\n";
  }
  return text;
}

}  // namespace powbench::host
