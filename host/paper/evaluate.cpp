#include "host/paper/evaluate.h"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <utility>

#include "core/quantities.h"

namespace powbench::host {
namespace {

constexpr double angle_of_statements_deg = 0;

double value_of(const PublishedView& v, std::string_view quantity) {
  const std::array<std::pair<std::string_view, double>, 13> table{{{"t_core", v.t_xt1},
                                                                   {"t_ct1", v.t_ct1},
                                                                   {"t_ct_bon", v.t_ct_bon},
                                                                   {"t_ct2", v.t_ct2},
                                                                   {"t_xt1", v.t_xt1},
                                                                   {"t_xt_bon", v.t_xt_bon},
                                                                   {"t_xt2", v.t_xt2},
                                                                   {"i_m", v.i_m},
                                                                   {"x_m", v.x_m},
                                                                   {"bounce_interval_1", v.bounce_interval_1},
                                                                   {"bounce_interval_2", v.bounce_interval_2},
                                                                   {"F_bounce_1", v.F_bounce_1},
                                                                   {"F_bounce_2", v.F_bounce_2}}};
  for (const auto& [name, value] : table)
    if (name == quantity) return value;
  return unknown;
}

void add_note(TableRow& row, const std::string& text) {
  if (!row.note.empty()) row.note += "; ";
  row.note += text;
}

TableRow evaluate(const PublishedRow& published, const PublishedView& view) {
  TableRow row;
  row.published = published;
  row.excluded = published.excluded;
  row.note = published.note;
  row.ours = value_of(view, published.quantity) / si_per(published.unit);
  row.error_percent = relative_error_percent(row.ours, published.measurement);
  const bool curve_point = published.quantity == "i_m" || published.quantity == "x_m";
  if (!std::isfinite(row.ours)) {
    row.ours = unknown;
    row.excluded = true;
    add_note(row, curve_point ? "so no value of ours is comparable" : "not reached in our closing");
  } else if (!std::isfinite(row.error_percent) && published.measurement == 0) {
    add_note(row, "measured 0: a relative error does not exist");
  }
  return row;
}

}  // namespace

PublishedView published_view(const Events& events) {
  const auto of = [&](std::string_view symbol) { return find_quantity(symbol)->of(events).value; };
  PublishedView v;
  v.t_ct1 = of("t_ct1");
  v.t_ct_bon = of("t_ct_bon");
  v.t_ct2 = of("t_ct2");
  v.t_xt1 = of("t_xt1");
  v.t_xt_bon = of("t_xt_bon");
  v.t_xt2 = of("t_xt2");
  const auto& touches = timing_train(events).contacts;
  if (touches.size() > 1) v.bounce_interval_1 = touches[1].touch.value - touches[0].touch.value;
  if (touches.size() > 2) v.bounce_interval_2 = touches[2].touch.value - touches[1].touch.value;
  const auto& film = events.pvdf_a.contacts;
  if (!film.empty()) v.F_bounce_1 = film[0].peak.value;
  if (film.size() > 1) v.F_bounce_2 = film[1].peak.value;
  return v;
}

std::vector<TableRow> evaluate_tables(const ClosingProvider& closing, const ClosingProvider& held_out) {
  using Views = std::map<double, PublishedView>;
  Views views;
  Views blind;
  const auto at = [](Views& known, const ClosingProvider& provider,
                     double theta_deg) -> const PublishedView& {
    const auto found = known.find(theta_deg);
    return found != known.end() ? found->second : known.emplace(theta_deg, provider(theta_deg)).first->second;
  };
  std::vector<TableRow> rows;
  for (const auto& published : published_rows()) {
    const bool angle_known = std::isfinite(published.theta_deg);
    const double theta_deg = angle_known ? published.theta_deg : angle_of_statements_deg;
    rows.push_back(evaluate(published, at(views, closing, theta_deg)));
    if (held_out && published.table > 0) {
      const double value = value_of(at(blind, held_out, theta_deg), published.quantity);
      rows.back().held_out = value / si_per(published.unit);
      rows.back().held_out_error_percent =
          relative_error_percent(rows.back().held_out, published.measurement);
    }
    if (!angle_known) add_note(rows.back(), "ours at 0 deg");
  }
  return rows;
}

std::vector<TableSummary> summarise(const std::vector<TableRow>& rows) {
  std::vector<TableSummary> all;
  for (const auto& row : rows) {
    if (row.published.table == 0) continue;
    auto s = std::find_if(all.begin(), all.end(),
                          [&](const TableSummary& t) { return t.quantity == row.published.quantity; });
    if (s == all.end()) s = all.insert(all.end(), TableSummary{row.published.quantity});
    s->unit = row.published.unit;
    if (row.excluded) ++s->excluded;
    if (!row.excluded && std::isfinite(row.held_out_error_percent)) {
      const bool first_held = s->held_out_rows++ == 0;
      s->held_out_mean = (first_held ? 0 : s->held_out_mean) + row.held_out_error_percent;
      s->held_out_max =
          first_held ? row.held_out_error_percent : std::max(s->held_out_max, row.held_out_error_percent);
    }
    if (row.excluded || !std::isfinite(row.ours) || !std::isfinite(row.published.measurement)) continue;
    const double off = std::fabs(row.ours - row.published.measurement);
    s->ours_off = (s->rows == 0 ? 0 : s->ours_off) + off;
    s->ours_off_max = s->rows == 0 ? off : std::max(s->ours_off_max, off);
    ++s->rows;
    if (row.published.measurement == 0) continue;
    const double paper = row.published.recomputed_error_percent;
    const bool first = s->percent_rows++ == 0;
    s->ours_mean = (first ? 0 : s->ours_mean) + row.error_percent;
    s->paper_mean = (first ? 0 : s->paper_mean) + paper;
    s->ours_max = first ? row.error_percent : std::max(s->ours_max, row.error_percent);
    s->paper_max = first ? paper : std::max(s->paper_max, paper);
  }
  for (auto& s : all) {
    s.ours_off /= s.rows;
    s.ours_mean /= s.percent_rows;
    s.paper_mean /= s.percent_rows;
    if (s.held_out_rows > 0) s.held_out_mean /= s.held_out_rows;
  }
  return all;
}

}  // namespace powbench::host
