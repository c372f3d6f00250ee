#include "host/paper/table_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

namespace powbench::host {
namespace {

constexpr const char* row_format =
    "{:>5} {:>5}  {:<17} {:<3} {:>9} {:>9} {:>8} {:>8} {:>8} {:>7} {:>8} {:>7}  {}\n";

std::string text_of(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : std::string("-");
}

int decimals_of(const PublishedRow& row) {
  return row.unit == "mA" || row.unit == "N" ? 1 : 2;
}

/// Footnotes: one letter per distinct note, in order of appearance.
std::string footnote(std::vector<std::string>& notes, const std::string& note) {
  if (note.empty()) return "";
  auto at = std::find(notes.begin(), notes.end(), note);
  if (at == notes.end()) at = notes.insert(notes.end(), note);
  return fmt::format("({})", std::distance(notes.begin(), at) + 1);
}

std::string summary_text(const std::vector<TableRow>& rows) {
  std::string out =
      "\nerror, rows without mark x: in the unit over all of them, in per cent over those whose measured "
      "value is not 0\n";
  out +=
      fmt::format("{:<12} {:>5} {:>9}   {:>9} {:>8}   {:>5} {:>10} {:>10}   {:>13} {:>12}   {:>10} {:>10}\n",
                  "quantity", "rows", "excluded", "ours mean", "max", "rows", "ours mean", "ours max",
                  "held out mean", "held out max", "paper mean", "paper max");
  for (const auto& s : summarise(rows))
    out += fmt::format(
        "{:<12} {:>5} {:>9}   {:>6} {:<2} {:>5} {:<2}   {:>5} {:>8} % {:>8} %   {:>11} % {:>10} %   {:>8} % "
        "{:>8} %\n",
        s.quantity, s.rows, s.excluded, text_of(s.ours_off, 2), s.unit, text_of(s.ours_off_max, 2), s.unit,
        s.percent_rows, text_of(s.ours_mean, 2), text_of(s.ours_max, 2), text_of(s.held_out_mean, 2),
        text_of(s.held_out_max, 2), text_of(s.paper_mean, 2), text_of(s.paper_max, 2));
  return out;
}

nlohmann::ordered_json json_of(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace

std::string tables_text(const std::vector<TableRow>& rows) {
  std::string out;
  std::vector<std::string> notes;
  std::string paper;
  for (const auto& row : rows) {
    const PublishedRow& p = row.published;
    if (p.paper != paper) {
      paper = p.paper;
      out += fmt::format("{}{}\n\n", out.empty() ? "" : "\n", paper);
      out += fmt::format(row_format, "table", "theta", "quantity", "", "paper sim", "paper mea", "printed",
                         "recomp.", "ours", "error", "held out", "error", "note");
      out += fmt::format(row_format, "", "deg", "", "", "", "", "%", "%", "", "%", "", "%", "");
    }
    const int decimals = decimals_of(p);
    out += fmt::format(row_format, p.table > 0 ? std::to_string(p.table) : "-", text_of(p.theta_deg, 0),
                       p.quantity, p.unit, text_of(p.simulation, decimals), text_of(p.measurement, decimals),
                       text_of(p.printed_error_percent, 2) + (p.misprinted() ? "*" : " "),
                       text_of(p.recomputed_error_percent, 2), text_of(row.ours, decimals),
                       text_of(row.error_percent, 2), text_of(row.held_out, decimals),
                       text_of(row.held_out_error_percent, 2),
                       (row.excluded ? "x " : "  ") + footnote(notes, row.note));
  }
  out += summary_text(rows);
  out +=
      "\nerror = |ours - paper measurement| / |paper measurement|; * printed error recomputed differently;";
  out += " x excluded from the summary\n";
  out +=
      "held out = median of specimens identified without the angle of the row (`powbench fit`); bounce "
      "calibrated by and pooled with the other angles; t_ct2 = t_ct1 + t_ct_bon\n";
  for (std::size_t i = 0; i < notes.size(); ++i) out += fmt::format("({}) {}\n", i + 1, notes[i]);
  return out;
}

std::string tables_json(const std::vector<TableRow>& rows) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& row : rows) {
    const PublishedRow& p = row.published;
    nlohmann::ordered_json entry;
    entry["paper"] = p.paper;
    entry["table"] = p.table > 0 ? nlohmann::ordered_json(p.table) : nlohmann::ordered_json(nullptr);
    entry["theta_deg"] = json_of(p.theta_deg);
    entry["quantity"] = p.quantity;
    entry["unit"] = p.unit;
    entry["published_simulation"] = json_of(p.simulation);
    entry["published_measurement"] = json_of(p.measurement);
    entry["published_error_percent"] = json_of(p.printed_error_percent);
    entry["ours"] = json_of(row.ours);
    entry["error_percent"] = json_of(row.error_percent);
    entry["held_out"] = json_of(row.held_out);
    entry["held_out_error_percent"] = json_of(row.held_out_error_percent);
    entry["excluded"] = row.excluded;
    entry["recomputed_published_error_percent"] = json_of(p.recomputed_error_percent);
    entry["note"] = row.note;
    list.push_back(std::move(entry));
  }
  return list.dump(2) + "\n";
}

}  // namespace powbench::host
