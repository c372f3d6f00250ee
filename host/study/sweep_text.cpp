#include "host/study/sweep_text.h"
#include "host/store/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/counted.h"
#include "core/units.h"
#include "sim/study/modes.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

std::vector<double> column(const std::vector<std::vector<double>>& rows, std::size_t k) {
  std::vector<double> values;
  for (const auto& row : rows)
    if (std::isfinite(row[k])) values.push_back(row[k]);
  std::sort(values.begin(), values.end());
  return values;
}

std::string modes_text(const std::vector<sim::Mode>& list, double scale) {
  std::string out;
  for (const auto& m : list)
    out += fmt::format("{}{:.0f} % at {:.3f} +- {:.3f}", out.empty() ? "" : ";  ", 100 * m.share,
                       m.mean * scale, m.deviation * scale);
  return out;
}

Json modes_json(const std::vector<sim::Mode>& list) {
  Json j = Json::array();
  for (const auto& m : list)
    j.push_back(
        {{"share", m.share}, {"mean", m.mean}, {"deviation", m.deviation}, {"low", m.low}, {"high", m.high}});
  return j;
}

constexpr double shares[] = {0.0, 0.05, 0.5, 0.95, 1.0};

}  // namespace

std::string metric_columns() {
  std::string names;
  for (const auto& m : sim::metric_table) names += (names.empty() ? "" : " ") + std::string(m.name);
  return names;
}

std::vector<double> metric_values(const sim::ClosingMetrics& metrics) {
  std::vector<double> values;
  for (const auto& m : sim::metric_table) values.push_back(metrics.*m.member);
  return values;
}

std::string sweep_text(const std::vector<std::vector<double>>& rows) {
  double closed = 0;
  for (const auto& row : rows) closed += row[0];
  std::string out = fmt::format("{}, {:.0f} closed ({:.2f} %)\n\n", counted(rows.size(), "closing"), closed,
                                100 * closed / static_cast<double>(rows.size()));
  out += fmt::format("{:<15} {:<5} {:>9} {:>9} {:>9} {:>9} {:>9}  {}\n", "metric", "", "least", "5 %",
                     "median", "95 %", "largest", "modes: share at mean +- deviation");
  for (std::size_t k = 1; k < sim::metric_table.size(); ++k) {
    const auto& m = sim::metric_table[k];
    const auto values = column(rows, k);
    if (values.empty()) continue;
    out += fmt::format("{:<15} {:<5}", m.name, m.unit);
    for (const double s : shares)
      out += fmt::format(" {:>9.3f}", sim::quantile_of_sorted(values, s) * m.per_si);
    out += "  " + modes_text(sim::modes(values), m.per_si) + "\n";
  }
  return out + "\nmore than one mode: the outcome is bistable there, and a mean of all says nothing\n";
}

std::string sweep_json(const sim::Design& design, const std::vector<std::vector<double>>& rows,
                       bool with_points) {
  Json j;
  j["points"] = rows.size();
  j["metrics"] = Json::array();
  for (std::size_t k = 0; k < sim::metric_table.size(); ++k) {
    const auto values = column(rows, k);
    if (values.empty()) continue;
    Json entry{{"name", sim::metric_table[k].name}};
    const char* names[] = {"least", "q05", "median", "q95", "largest"};
    for (std::size_t s = 0; s < std::size(shares); ++s)
      entry[names[s]] = json_of<Json>(sim::quantile_of_sorted(values, shares[s]));
    entry["modes"] = modes_json(sim::modes(values));
    j["metrics"].push_back(std::move(entry));
  }
  if (!with_points) return j.dump(2) + "\n";
  j["variables"] = Json::array();
  for (const auto& a : design.axes()) j["variables"].push_back(a.variable.name);
  j["rows"] = Json::array();
  for (std::size_t n = 0; n < rows.size(); ++n) {
    Json row{{"at", design.point(static_cast<std::int64_t>(n))}};
    for (std::size_t k = 0; k < sim::metric_table.size(); ++k)
      row[std::string(sim::metric_table[k].name)] = json_of<Json>(rows[n][k]);
    j["rows"].push_back(std::move(row));
  }
  return j.dump() + "\n";
}

std::string sensitivity_text(std::span<const sim::Sensitivity> rows, const sim::MetricInfo& metric) {
  std::string out =
      fmt::format("change of {} in {}\n\n{:>8} {:<24} {:>12} {:>10} {:>12} {:>12}\n", metric.name,
                  metric.unit, "theta", "variable", "step", "centre", "step down", "step up");
  for (const auto& r : rows) {
    const auto change = [&](double v) {
      return std::isfinite(v - r.centre) ? fmt::format("{:+.4f}", (v - r.centre) * metric.per_si)
                                         : std::string("no closing");
    };
    out += fmt::format("{:>8.1f} {:<24} {:>12.5g} {:>10.3f} {:>12} {:>12}\n", degrees(r.angle), r.name,
                       r.step, r.centre * metric.per_si, change(r.low), change(r.high));
  }
  return out;
}

std::string sensitivity_json(std::span<const sim::Sensitivity> rows, const sim::MetricInfo& metric) {
  Json j = Json::array();
  for (const auto& r : rows)
    j.push_back({{"theta_deg", degrees(r.angle)},
                 {"variable", r.name},
                 {"step", r.step},
                 {"metric", metric.name},
                 {"low", json_of<Json>(r.low)},
                 {"centre", json_of<Json>(r.centre)},
                 {"high", json_of<Json>(r.high)}});
  return j.dump(2) + "\n";
}

std::string best_angle_text(const sim::BestAngle& b, const sim::MetricInfo& metric) {
  const double s = metric.per_si;
  if (b.closed[b.best] == 0) return "no device closes at any angle: there is no best one\n";
  std::string out =
      fmt::format("{:>8} {:>10} {:>10} {:>21} {:>6} {:>8}\n", "theta", "mean " + std::string(metric.unit),
                  "deviation", "95 % of the mean", "modes", "closing");
  for (std::size_t k = 0; k < b.angles.size(); ++k) {
    const std::string closing = fmt::format("{}/{}", b.closed[k], b.draws);
    if (b.closed[k] == 0)
      out += fmt::format("{:>8.1f} {:>10} {:>10} {:>21} {:>6} {:>8}\n", degrees(b.angles[k]), "-", "-", "-",
                         "-", closing);
    else
      out += fmt::format("{:>8.1f} {:>10.3f} {:>10.3f} {:>21} {:>6} {:>8}{}\n", degrees(b.angles[k]),
                         b.mean[k] * s, b.deviation[k] * s,
                         fmt::format("{:.3f} .. {:.3f}", b.low[k] * s, b.high[k] * s), b.mode_count[k],
                         closing, k == b.best ? "  best" : "");
  }
  out += fmt::format(
      "\nbest closing angle for {}: {:.1f} deg (and + 180), {:.3f} {}; within {:.0f} deg of it in {:.0f} % "
      "of "
      "bootstraps, 95 % of them {:.1f} .. {:.1f} deg\n",
      metric.name, degrees(b.angles[b.best]), b.mean[b.best] * s, metric.unit, degrees(b.near),
      100 * b.confidence, degrees(b.first), degrees(b.last));
  out += fmt::format("closing at random: {:.3f} {}; gain {:.1f} % (95 %: {:.1f} .. {:.1f} %)\n",
                     b.random_mean * s, metric.unit, 100 * b.gain, 100 * b.gain_low, 100 * b.gain_high);
  if (std::ranges::any_of(b.closed, [&](std::size_t n) { return n < b.draws; }))
    out +=
        "closing: devices that do; all other numbers are of those, and an angle at which fewer close is not "
        "the best\n";
  return out;
}

std::string best_angle_json(const sim::BestAngle& b, const sim::MetricInfo& metric) {
  if (b.closed[b.best] == 0)
    return Json{{"metric", metric.name}, {"draws", b.draws}, {"closed", 0}, {"best_deg", nullptr}}.dump(2) +
           "\n";
  Json j{{"metric", metric.name},         {"best_deg", degrees(b.angles[b.best])},
         {"best_mean", b.mean[b.best]},   {"confidence", b.confidence},
         {"first_deg", degrees(b.first)}, {"last_deg", degrees(b.last)},
         {"random_mean", b.random_mean},  {"gain", b.gain},
         {"gain_low", b.gain_low},        {"gain_high", b.gain_high}};
  j["draws"] = b.draws;
  j["angles"] = Json::array();
  for (std::size_t k = 0; k < b.angles.size(); ++k)
    j["angles"].push_back({{"theta_deg", degrees(b.angles[k])},
                           {"closed", b.closed[k]},
                           {"mean", b.mean[k]},
                           {"deviation", b.deviation[k]},
                           {"low", b.low[k]},
                           {"high", b.high[k]},
                           {"modes", b.mode_count[k]}});
  return j.dump(2) + "\n";
}

}  // namespace powbench::host
