#include "host/study/fit_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "host/store/json.h"
#include "host/study/problem.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* quantities[] = {"t_ct1", "t_ct_bon", "t_ct2", "t_xt1", "t_ot"};

double measured(const sim::MeasuredClosing& m, int quantity) {
  switch (quantity) {
    case 0:
      return m.touch.value;
    case 1:
      return m.bounce.value;
    case 2:
      return m.touch.value + m.bounce.value;
    case 3:
      return m.seat.value;
    default:
      return m.seat.value - m.touch.value;
  }
}

const Band& of(const Prediction& p, int quantity) {
  const Band* const bands[] = {&p.touch, &p.bounce, &p.settled, &p.seat, &p.overtravel_time};
  return *bands[quantity];
}

bool is_one_of(std::span<const double> angles, const sim::MeasuredClosing& m) {
  return std::ranges::any_of(angles, [&](double a) {
    return std::fabs(std::remainder(degrees(a - m.conditions.closing_angle), 360)) < 1e-3;
  });
}

/// Median of the quantity over the known closings but one.
double median_of_others(const std::vector<sim::MeasuredClosing>& all, std::size_t without, int quantity,
                        std::span<const double> unseen) {
  std::vector<double> values;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (k != without && !is_one_of(unseen, all[k]) && std::isfinite(measured(all[k], quantity)))
      values.push_back(measured(all[k], quantity));
  if (values.empty()) return unknown;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

std::string text_of(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : std::string("-");
}

std::string parameters_text(const FitJob& job, const FitReport& report) {
  const auto& told = report.full.identifiability;
  std::string out =
      fmt::format("{:<36} {:>11} {:>11} {:>24} {:>8}\n", "number", "value", "deviation", "bounds", "data %");
  if (report.full.best.point.empty()) return "";
  for (std::size_t i = 0; i < job.problem.parameters.size(); ++i) {
    const auto& p = job.problem.parameters[i];
    const double unit = p.field->si_per_unit;
    const double u = report.full.best.point[i];
    const double spread =
        0.5 * (p.value_at(u + told.deviation[i]) - p.value_at(u - told.deviation[i])) / unit;
    out += fmt::format("{:<36} {:>11.5g} {:>11.2g} {:>24} {:>8}{}\n", p.name(), p.value_at(u) / unit, spread,
                       fmt::format("{:.4g} .. {:.4g}", p.low / unit, p.high / unit),
                       told.data_share.empty() ? "-" : text_of(100 * told.data_share[i], 0),
                       u < 0.005 || u > 0.995 ? "  at a bound" : "");
  }
  out +=
      "\ndeviation: posterior, linear about the best point; data: share of the prior variance that the data "
      "take away, without a prior of that of the flat one between the bounds\n";
  return out;
}

std::string unseen_text(const FitJob& job, const FitReport& report) {
  const auto& told = report.full.identifiability;
  const std::size_t n = job.problem.parameters.size();
  std::string out;
  for (std::size_t i = 0; i < told.data_share.size(); ++i)
    if (told.data_share[i] < 0.1) out += (out.empty() ? "" : ", ") + job.problem.parameters[i].name();
  if (!out.empty()) out = "\nnot determined by the data (below 10 %): " + out + "\n";
  std::string pairs;
  for (std::size_t i = 0; i < n && told.correlation.size() == n * n; ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (std::fabs(told.correlation[i * n + k]) > 0.6)
        pairs += fmt::format("  {:+.2f}  {} and {}\n", told.correlation[i * n + k],
                             job.problem.parameters[k].name(), job.problem.parameters[i].name());
  if (!pairs.empty()) out += "correlated beyond 0.6:\n" + pairs;
  return out;
}

struct Mean {
  double sum = 0, largest = 0;
  int n = 0;
  void add(double v) {
    if (!std::isfinite(v)) return;
    sum += v;
    largest = std::max(largest, v);
    ++n;
  }
  std::string text() const { return n > 0 ? fmt::format("{:.2f} / {:.2f}", sum / n, largest) : "-"; }
  double mean() const { return n > 0 ? sum / n : unknown; }
};

struct Summary {
  Mean fitted, held_out, others;
};

Summary summary(const std::vector<FitCell>& cells, const char* quantity) {
  Summary s;
  const bool blind =
      std::ranges::any_of(cells, [](const FitCell& c) { return std::isfinite(c.held_out_percent); });
  for (const auto& c : cells) {
    if (c.quantity != quantity) continue;
    s.fitted.add(c.fitted_percent);
    s.held_out.add(c.held_out_percent);
    if (!blind || std::isfinite(c.held_out_percent)) s.others.add(c.others_percent);
  }
  return s;
}

/// How many held-out values lie within their bands; empty without any.
std::string covered_text(const std::vector<FitCell>& cells) {
  std::string out;
  int within = 0, of_all = 0;
  for (const char* q : quantities) {
    int inside = 0, known = 0;
    for (const auto& c : cells) {
      if (c.quantity != q || !std::isfinite(c.measured) || !std::isfinite(c.held_out.median)) continue;
      ++known;
      inside += c.measured >= c.held_out.low && c.measured <= c.held_out.high;
    }
    if (known > 0) out += fmt::format("{}{} {} of {}", out.empty() ? "" : ", ", q, inside, known);
    within += inside, of_all += known;
  }
  if (of_all == 0) return {};
  return fmt::format("\nheld out, within the band: {}; in all {} of {}, {:.0f} % (68 % would be right)\n",
                     out, within, of_all, 100.0 * within / of_all);
}

std::string cells_text(const std::vector<FitCell>& cells) {
  std::string out = fmt::format("{:>6}  {:<9} {:>9} {:>9} {:>7} {:>9} {:>7}  {}\n", "theta", "quantity",
                                "measured", "fitted", "%", "held out", "%", "band 16..84 %");
  constexpr double ms = 1e3;
  for (const auto& c : cells) {
    const bool band = std::isfinite(c.held_out.median);
    out +=
        fmt::format("{:>6.1f}  {:<9} {:>9} {:>9} {:>7} {:>9} {:>7}  {}\n", c.theta_deg, c.quantity,
                    text_of(c.measured * ms, 3), text_of(c.fitted * ms, 3), text_of(c.fitted_percent, 2),
                    text_of(c.held_out.median * ms, 3), text_of(c.held_out_percent, 2),
                    band ? fmt::format("{:.2f} .. {:.2f}", c.held_out.low * ms, c.held_out.high * ms) : "-");
  }
  out += fmt::format("\nmean / largest error, %   {:>16} {:>16} {:>24}\n", "fitted", "held out",
                     "median of other angles");
  for (const char* q : quantities) {
    const Summary s = summary(cells, q);
    out += fmt::format("  {:<22}  {:>16} {:>16} {:>24}\n", q, s.fitted.text(), s.held_out.text(),
                       s.others.text());
  }
  return out + covered_text(cells);
}

/// The error of each posterior's bounce at the known angles, and its weight in the pooled prediction.
std::string bounce_text(const FitFile& file) {
  std::string out;
  bool line = false;
  for (const auto& fold : file.folds) {
    const double weight = fold.held_out && fold.bounce ? sim::weight_of_samples(*fold.bounce) : unknown;
    if (!std::isfinite(weight)) continue;
    out += fmt::format("{:>6.1f} {:>28.2f} {:>26.2f} {:>18.2f}\n", *fold.held_out, fold.bounce->deviation,
                       without_model(*fold.bounce, 0).deviation, weight);
    line = line || !fold.bounce->line.empty();
  }
  if (out.empty()) return out;
  const char* other = line ? "line between angles" : "plain median";
  return fmt::format(
             "\nbounce held out: single samples and {}, error at the known angles; rms of ln(measured "
             "/ predicted)\n",
             other) +
         fmt::format("{:>6} {:>28} {:>26} {:>18}\n", "theta", "error of samples",
                     line ? "error of line" : "error of median", "weight of samples") +
         out;
}

OneMeasured of_one(const sim::MeasuredClosing& m) {
  const auto relative = [](const Measured& value) { return value.known() ? value.u / value.value : 0; };
  return {relative(m.touch), relative(m.seat),
          m.overtravel_time.known() ? m.overtravel_time.u
          : m.seat.known()          ? std::hypot(m.touch.u, m.seat.u)
                                    : 0};
}

}  // namespace

std::vector<FitCell> fit_cells(const FitFile& file, const std::vector<sim::MeasuredClosing>& closings,
                               std::span<const double> unseen, const sim::ClosingModel& model) {
  std::vector<FitCell> cells;
  std::vector<sim::Specimen> best;
  for (const auto& fold : file.folds)
    if (!fold.held_out && !fold.members.empty()) best = {specimens(file, fold).front()};
  for (std::size_t k = 0; k < closings.size(); ++k) {
    const auto& m = closings[k];
    const double theta = degrees(m.conditions.closing_angle);
    const bool is_fitted = !best.empty() && !is_one_of(unseen, m);
    const Prediction fitted = is_fitted ? predict(best, m.conditions, {}, {}, model) : Prediction{};
    Prediction blind;
    for (const auto& fold : file.folds)
      if (fold.held_out && std::fabs(std::remainder(*fold.held_out - theta, 360)) < 1e-3)
        blind = predict(specimens(file, fold), m.conditions, fold.bounce, of_one(m), model);
    for (int q = 0; q < static_cast<int>(std::size(quantities)); ++q) {
      FitCell c;
      c.theta_deg = theta;
      c.quantity = quantities[q];
      c.measured = measured(m, q);
      c.fitted = of(fitted, q).median;
      c.held_out = of(blind, q);
      c.fitted_percent = relative_error_percent(c.fitted, c.measured);
      c.held_out_percent = relative_error_percent(c.held_out.median, c.measured);
      c.others_percent = relative_error_percent(median_of_others(closings, k, q, unseen), c.measured);
      cells.push_back(c);
    }
  }
  return cells;
}

std::string fit_text(const FitJob& job, const FitReport& report, const std::vector<FitCell>& cells) {
  std::string out = parameters_text(job, report) + unseen_text(job, report);
  if (!report.full.best.point.empty()) {
    const auto d = sim::derived(report.full.best.specimen, job.problem.plausible.rated_volts);
    out += fmt::format(
        "\ninrush {:.0f} VA, holding {:.1f} VA, overtravel {:.0f} % of the gap, closed contact force {:.2f} "
        "N a "
        "break\n",
        d.inrush, d.holding, 100 * d.overtravel, d.contact_force);
  }
  return out + "\n" + cells_text(cells) + bounce_text(report.file);
}

std::string fit_json(const FitJob& job, const FitReport& report, const std::vector<FitCell>& cells,
                     const NextMeasurements& next) {
  Json j;
  j["misfit"] = json_of<Json>(report.full.best.misfit);
  j["evaluations_each"] = job.options.evaluations;
  j["parameters"] = Json::array();
  const auto& told = report.full.identifiability;
  for (std::size_t i = 0; i < report.full.best.point.size(); ++i) {
    const auto& p = job.problem.parameters[i];
    const double u = report.full.best.point[i];
    const double unit = p.field->si_per_unit;
    j["parameters"].push_back(
        {{"name", p.name()},
         {"value", p.value_at(u) / unit},
         {"low", p.low / unit},
         {"high", p.high / unit},
         {"deviation", 0.5 * (p.value_at(u + told.deviation[i]) - p.value_at(u - told.deviation[i])) / unit},
         {"told", told.data_share.empty() ? Json(nullptr) : json_of<Json>(told.data_share[i])}});
  }
  j["correlation"] = told.correlation;
  j["cells"] = Json::array();
  for (const auto& c : cells)
    j["cells"].push_back({{"theta_deg", c.theta_deg},
                          {"quantity", c.quantity},
                          {"measured", json_of<Json>(c.measured)},
                          {"fitted", json_of<Json>(c.fitted)},
                          {"error_percent", json_of<Json>(c.fitted_percent)},
                          {"held_out", json_of<Json>(c.held_out.median)},
                          {"held_out_low", json_of<Json>(c.held_out.low)},
                          {"held_out_high", json_of<Json>(c.held_out.high)},
                          {"held_out_error_percent", json_of<Json>(c.held_out_percent)},
                          {"median_of_others_error_percent", json_of<Json>(c.others_percent)}});
  j["bounce_held_out"] = Json::array();
  for (const auto& fold : report.file.folds)
    if (fold.held_out && fold.bounce) {
      j["bounce_held_out"].push_back({{"theta_deg", *fold.held_out},
                                      {"samples_deviation", json_of<Json>(fold.bounce->deviation)},
                                      {"median_s", json_of<Json>(fold.bounce->median)},
                                      {"median_deviation", json_of<Json>(fold.bounce->median_deviation)}});
      if (!fold.bounce->line.empty())
        j["bounce_held_out"].back()["line_deviation"] = fold.bounce->line_deviation;
    }
  j["summary"] = Json::array();
  for (const char* q : quantities) {
    const Summary s = summary(cells, q);
    j["summary"].push_back({{"quantity", q},
                            {"mean_error_percent", json_of<Json>(s.fitted.mean())},
                            {"mean_held_out_error_percent", json_of<Json>(s.held_out.mean())},
                            {"mean_median_of_others_error_percent", json_of<Json>(s.others.mean())}});
  }
  j["next"] = Json::array();
  for (const auto& n : next.list)
    j["next"].push_back({{"theta_deg", n.theta_deg},
                         {"quantity", n.quantity},
                         {"bits", n.bits},
                         {"spread", n.spread},
                         {"deviation", n.deviation},
                         {"shots", n.shots ? Json(*n.shots) : Json(nullptr)},
                         {"bounce_spread_then", n.bounce_left}});
  return j.dump(2) + "\n";
}

}  // namespace powbench::host
