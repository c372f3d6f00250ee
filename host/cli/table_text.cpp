#include "host/cli/table_text.h"

#include <fmt/format.h>

namespace powbench::host {

std::string missed_accuracy(const sim::PotentialTable& t, double asked, std::string_view finer_mesh,
                            std::string_view finer_table) {
  const double table = t.worst_error();
  if (t.mesh_error <= asked && table <= asked) return "";
  std::string why;
  if (t.mesh_error > asked) why = fmt::format("mesh {:.2g} %: {}", t.mesh_error * 100, finer_mesh);
  if (table > asked)
    why += fmt::format("{}table {:.2g} %: {}", why.empty() ? "" : "; ", table * 100, finer_table);
  return fmt::format("MISSED: {:.3g} % was asked for; {}", asked * 100, why);
}

std::string table_head(const FieldTableChoice& choice, const std::string& missed) {
  const sim::PotentialTable& t = choice.table;
  return fmt::format(
      "{} ({})\n  {}\n  expected error: mesh {:.2g} %, table {:.2g} % in the current, {:.2g} % in the "
      "pull\n{}",
      choice.file.string(), choice.reused ? "as stored" : "built", t.description, t.mesh_error * 100,
      t.worst_current_error() * 100, t.worst_pull_error() * 100, missed.empty() ? "" : "  " + missed + "\n");
}

std::string extrapolated_text(const sim::PotentialTable& t, const sim::ExtrapolatedShare& e) {
  if (t.steel_field.empty()) return "what share is extrapolated is not known";
  if (e.share == 0) return fmt::format("no state is above the B-H data, which end at {:.3g} T", t.data_end);
  return fmt::format(
      "somewhere above the B-H data, which end at {:.3g} T, in {:.3g} % of the states, from {:.3g} Wb on",
      t.data_end, e.share * 100, e.from_psi);
}

}  // namespace powbench::host
