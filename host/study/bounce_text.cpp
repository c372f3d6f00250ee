#include "host/study/bounce_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/models/rigid_closing.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

std::string spread_text(const sim::Spread& s) {
  return fmt::format("{:.3f} ({:.3f} .. {:.3f})", s.mean * 1e3, s.low * 1e3, s.high * 1e3);
}

std::string line(const BounceRow& row) {
  const auto& e = row.study.error;
  const auto& c = row.study.condition;
  return fmt::format("{:<14} {:>13} {:>10.1e} {:>13.1e}  {:>11.3g}  {}\n", row.name,
                     fmt::format("{}/{}", e.matched, e.reference), e.largest_dt * 1e6, e.distance * 1e6,
                     c.per_input,
                     row.study.error.reference == 0 ? "no contact closes"
                     : row.study.computable         ? "computable"
                     : c.diverged                   ? fmt::format("twin leaves at {:.2f} ms", c.horizon * 1e3)
                                  : fmt::format("leaves at {:.2f} ms", e.diverged_at * 1e3));
}

std::string times_text(const std::vector<BounceRow>& rows) {
  std::string out;
  for (const auto& row : rows) {
    if (!row.times) continue;
    if (out.empty())
      out = fmt::format("{:<14} {:>10} {:>8} {:>10} {:>16}\n", "closing", "touch ms", "bounces", "open ms",
                        "last closing ms");
    if (std::isnan(row.times->touch))
      out += fmt::format("{:<14} {:>10} {:>8} {:>10} {:>16}\n", row.name, "-", "-", "-", "-");
    else
      out += fmt::format("{:<14} {:>10.4f} {:>8} {:>10.4f} {:>16.4f}\n", row.name, row.times->touch * 1e3,
                         row.times->bounces, row.times->open * 1e3, row.times->last * 1e3);
  }
  return out;
}

/// When each stage begins; one that a closing does not reach, or skips, is a dash.
std::string stages_text(const std::vector<BounceRow>& rows) {
  std::string out;
  for (const auto& row : rows) {
    if (row.stages.empty()) continue;
    constexpr auto last = static_cast<int>(sim::ClosingStage::closed);
    std::string line = fmt::format("{:<14}", row.name), head = fmt::format("{:<14}", "stages begin");
    for (int k = 0; k <= last; ++k) {
      const auto stage = static_cast<sim::ClosingStage>(k);
      std::string begin = "-";
      for (const auto& s : row.stages)
        if (s.stage == stage) begin = fmt::format("{:.4f}", s.begin * 1e3);
      line += fmt::format(" {:>10}", begin);
      head += fmt::format(" {:>10}", sim::stage_name(stage));
    }
    if (out.empty()) out = head + "  ms\n";
    out += line + "\n";
  }
  return out;
}

Json spread_json(const sim::Spread& s) {
  return {{"mean_s", s.mean}, {"q05_s", s.low}, {"q50_s", s.median}, {"q95_s", s.high}};
}

}  // namespace

BounceRow bounce_row(const sim::Rung& rung, const std::string& name, const sim::Case& c,
                     const sim::BounceStudyOptions& options) {
  const auto run = [&](double tolerance, const sim::Factor& factor) {
    const sim::Case changed{sim::varied(c.specimen, factor), c.conditions, c.bench};
    return sim::contact_events(rung.run(changed, options.end, tolerance, 0).events);
  };
  auto closing = rung.run(c, options.end, options.tolerance, 0);
  if (closing.stages
          .empty())  // the plant's: the same equations, but it does not note when the core leaves its stop
    closing.stages =
        sim::simulate_rigid(c.specimen, c.conditions, options.end, 0, options.tolerance, false, c.bench)
            .stages;
  const auto events = sim::contact_events(closing.events);
  const auto seen = sim::bounce_summary(events, 0);
  BounceTimes times{seen.first_touch, seen.open_time, seen.last_closing, 0};
  if (std::ranges::none_of(events, [](const auto& e) { return e.contact == 0 && e.closes; }))
    times.touch = times.open = times.last = std::nan("");
  for (const auto& e : events) times.bounces += e.contact == 0 && !e.closes;
  return {name, sim::study_bounces(run, options), times, std::move(closing.stages)};
}

std::vector<BounceRow> bounces_of(std::span<const sim::Rung> rungs, const sim::Case& c,
                                  const sim::BounceStudyOptions& options) {
  std::vector<BounceRow> rows;
  for (const auto& rung : rungs) {
    if (rung.costly || !rung.settings.empty()) continue;
    rows.push_back(bounce_row(rung, rung.name(), c, options));
    rows.back().times.reset();  // the ladder's own table has them
    rows.back().stages.clear();
  }
  return rows;
}

std::string bounce_text(const std::vector<BounceRow>& rows, const sim::BounceStudyOptions& o) {
  std::string out =
      times_text(rows) + stages_text(rows) +
      fmt::format(
          "how far the bounces can be believed: tolerance {:.0e} against {:.0e}; twin with masses and gaps "
          "changed "
          "by {:.0e}\n{:<14} {:>13} {:>10} {:>13}  {:>11}\n",
          o.tolerance, o.truth, o.change, "closing", "events agree", "dt us", "states us", "condition s");
  bool ensembles = false;
  for (const auto& row : rows) {
    out += line(row);
    const auto& e = row.study.ensemble;
    if (e.runs == 0) continue;
    ensembles = true;
    out += fmt::format("  {} runs, ms: first touch {}, open after it {}, last closing {}\n", e.runs,
                       spread_text(e.first_touch), spread_text(e.open_time), spread_text(e.last_closing));
  }
  out +=
      "dt: largest time difference of events that agree; states: longest time for which a contact is open in "
      "one "
      "and\nclosed in the other; condition: s of event time per unit of relative input, no digit below "
      "condition "
      "times\nthe uncertainty of the inputs means anything\n";
  if (ensembles)
    out += fmt::format("ensembles: masses and gaps +- {:.0e}, mean and 5 .. 95 % quantiles, break A\n",
                       o.change);
  return out;
}

std::string bounce_json(const std::vector<BounceRow>& rows) {
  Json list = Json::array();
  for (const auto& row : rows) {
    const auto& e = row.study.error;
    const auto& c = row.study.condition;
    Json j{{"closing", row.name},
           {"matched", e.matched},
           {"events", e.reference},
           {"largest_dt_s", e.largest_dt},
           {"state_distance_s", e.distance},
           {"condition_s", c.per_input},
           {"computable", row.study.error.reference > 0 ? Json(row.study.computable) : Json()}};
    if (row.times) {
      j["touch_s"] = row.times->touch;
      j["bounces"] = row.times->bounces;
      j["open_s"] = row.times->open;
      j["last_closing_s"] = row.times->last;
    }
    for (const auto& s : row.stages) j["stages_s"][std::string(sim::stage_name(s.stage))] = s.begin;
    if (!row.study.computable && row.study.error.reference > 0) {
      const auto& s = row.study.ensemble;
      j["twin_horizon_s"] = c.horizon;
      j["ensemble"] = {{"runs", s.runs},
                       {"first_touch", spread_json(s.first_touch)},
                       {"open_time", spread_json(s.open_time)},
                       {"last_closing", spread_json(s.last_closing)}};
    }
    list.push_back(std::move(j));
  }
  return list.dump();
}

}  // namespace powbench::host
