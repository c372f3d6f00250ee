#include "host/paper/published.h"

#include <locale>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "host/paper/embedded.h"

namespace powbench::host {
namespace {

using Line = std::vector<std::string>;

/// Lines of a plain CSV (no quotes), without comments and the head.
std::vector<Line> lines_of(std::string_view csv, std::size_t columns) {
  std::vector<Line> lines;
  std::istringstream in{std::string(csv)};
  bool head = true;
  for (std::string text; std::getline(in, text);) {
    if (text.empty() || text.front() == '#') continue;
    Line line(1);
    for (const char c : text) {
      if (c == ',')
        line.emplace_back();
      else
        line.back() += c;
    }
    if (line.size() != columns) throw std::logic_error("published data: wrong number of columns: " + text);
    if (!head) lines.push_back(std::move(line));
    head = false;
  }
  return lines;
}

double number(const std::string& text) {
  if (text.empty()) return unknown;
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  double value = 0;
  if (!(in >> value) || !in.eof()) throw std::logic_error("published data: not a number: " + text);
  return value;
}

bool is_core_time(const std::string& quantity) {
  return quantity == "t_core" || quantity.starts_with("t_xt");
}

void explain(PublishedRow& row) {
  if (row.theta_deg == 90 && is_core_time(row.quantity)) {
    row.excluded = true;
    row.note = "impossible as printed: at 90 deg the core lands before the contacts touch";
  } else if (row.quantity == "i_m" || row.quantity == "x_m") {
    row.note = "read where the paper's two curves differ most; the instant is not printed";
  }
  if (row.misprinted()) {
    if (!row.note.empty()) row.note += "; ";
    row.note += "the printed error does not follow from the printed values";
  }
}

std::vector<PublishedRow> load() {
  std::vector<PublishedRow> rows;
  for (const auto& line : lines_of(closing_tables_csv, 7)) {
    PublishedRow row;
    row.paper = paper_closing;
    row.table = static_cast<int>(number(line[0]));
    row.theta_deg = number(line[1]);
    row.quantity = line[2];
    row.unit = line[3];
    row.simulation = number(line[4]);
    row.measurement = number(line[5]);
    row.printed_error_percent = number(line[6]);
    row.recomputed_error_percent = relative_error_percent(row.simulation, row.measurement);
    explain(row);
    rows.push_back(std::move(row));
  }
  for (const auto& line : lines_of(contact_pressure_csv, 4)) {
    PublishedRow row;
    row.paper = paper_pressure;
    row.quantity = line[0];
    row.unit = line[1];
    row.simulation = number(line[2]);
    row.measurement = number(line[3]);
    row.recomputed_error_percent = relative_error_percent(row.simulation, row.measurement);
    row.excluded = true;
    row.note = "another device; closing angle and thresholds not printed: for orientation only";
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

double relative_error_percent(double value, double reference) {
  if (!std::isfinite(value) || !std::isfinite(reference)) return unknown;
  if (value == reference) return 0;
  return reference == 0 ? unknown : 100 * std::fabs(value - reference) / std::fabs(reference);
}

const std::vector<PublishedRow>& published_rows() {
  static const std::vector<PublishedRow> rows = load();
  return rows;
}

const PublishedRow* find_published(const std::string& quantity, double theta_deg) {
  for (const auto& row : published_rows())
    if (row.table > 0 && row.quantity == quantity && std::fabs(row.theta_deg - theta_deg) < 1e-6) return &row;
  return nullptr;
}

double si_per(const std::string& unit) {
  if (unit == "N") return 1;
  if (unit == "ms" || unit == "mA" || unit == "mm") return 1e-3;
  throw std::invalid_argument("unit = " + unit + ": allowed ms, mA, mm, N");
}

}  // namespace powbench::host
