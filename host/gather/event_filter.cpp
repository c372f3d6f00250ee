#include "host/gather/event_filter.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/channels.h"
#include "dsp/events/extract.h"
#include "host/config/bad_input.h"
#include "host/config/filter_text.h"

namespace powbench::host {

namespace {

std::string decibels(double db) {
  return std::isfinite(db) ? fmt::format("{:.1f} dB", db) : std::string("nothing");
}

}  // namespace

FilteredEvents extract_filtered(const Record& record, const RunOptions& options, bool keep_refused) {
  FilteredEvents out;
  out.used = out.bare = options.extract;
  out.bare.filter = {};
  dsp::Extracted e = dsp::extract_on_request(record, options.extract);
  out.events = std::move(e.events);
  out.filter = std::move(e.filter);
  out.films = std::move(e.bare);
  if (out.filter) {
    if (!out.filter->refused.empty() && !keep_refused)
      throw BadInput({"filter " + text_of(options.extract.filter) + " refused: " + out.filter->refused});
    out.used.filter = out.filter->filter.judged ? out.filter->filter : dsp::EventFilter{};
  }
  dsp::check_angle(out.events, record.conditions, options.angle_tolerance);
  return out;
}

std::string filter_json(const dsp::FilterJudgement& j) {
  using Json = nlohmann::ordered_json;
  const auto number = [](double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); };
  Json films = Json::array();
  for (const dsp::FilmFilter& f : j.films)
    films.push_back({{"film", info(f.film).name},
                     {"shortest_s", f.shortest},
                     {"contact_db", number(f.contact_db)},
                     {"vibration_db", number(f.vibration_db)},
                     {"vibration_found", f.found}});
  const bool applied = j.refused.empty();
  const dsp::FilterEffect& e = j.effect;
  return Json{{"filter", text_of(j.filter)},
              {"phase", j.filter.phase == dsp::FilterPhase::zero ? "zero" : "causal"},
              {"applied", applied},
              {"refused", applied ? Json(nullptr) : Json(j.refused)},
              {"delay_s", e.delay},
              {"u_touch_s", dsp::u_touch(e)},
              {"u_release_s", dsp::u_release(e)},
              {"resolves_s", e.rise},
              {"films", films}}
      .dump();
}

std::vector<std::string> filter_lines(const dsp::FilterJudgement& j) {
  if (!j.refused.empty())
    return {fmt::format("filter {} refused, events without it: {}", text_of(j.filter), j.refused)};
  const dsp::FilterEffect& e = j.effect;
  std::vector<std::string> lines{
      fmt::format("filter: {}; delay {:.1f} us{}; adds {:.1f} us to u of a touch, {:.1f} us to that of a "
                  "release; resolves {:.0f} us",
                  dsp::name_of(j.filter), e.delay * 1e6, e.delay > 0 ? " taken out of the times" : "",
                  dsp::u_touch(e) * 1e6, dsp::u_release(e) * 1e6, e.rise * 1e6)};
  for (const dsp::FilmFilter& f : j.films)
    lines.push_back(fmt::format(
        "{}: leaves {} of {}; takes {} of the energy of the shortest contact or opening ({:.3f} ms)",
        f.film == Channel::pvdf_a ? "film A" : "film B", decibels(f.vibration_db),
        f.found ? "the core's vibration" : "the band looked at, no core vibration stands out",
        decibels(f.contact_db), f.shortest * 1e3));
  return lines;
}

}  // namespace powbench::host
