#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/events.h"
#include "core/record.h"
#include "dsp/events/requested.h"
#include "host/run/campaign.h"

/// Events behind a filter that somebody requested, and what the filter does, for people and for programs.

namespace powbench::host {

struct FilteredEvents {
  Events events;
  std::optional<dsp::FilterJudgement> filter;  ///< where one was wanted
  dsp::ExtractOptions used;                    ///< with the filter as it was applied, if it was
  dsp::ExtractOptions bare;                    ///< without it: for what is said about the vibration itself
  dsp::FilmPaths films;                        ///< how the events came without it
};
/// extract_checked, with all that is known of the filter. Throws BadInput where the filter is refused, unless
/// `keep_refused`.
FilteredEvents extract_filtered(const Record&, const RunOptions&, bool keep_refused);

/// {"filter", "phase", "applied", "refused", "delay_s", "u_touch_s", "u_release_s", "resolves_s", "films": [{"film",
/// "shortest_s", "contact_db", "vibration_db", "vibration_found"}]} as JSON text.
std::string filter_json(const dsp::FilterJudgement&);
/// The same for the terminal.
std::vector<std::string> filter_lines(const dsp::FilterJudgement&);

}  // namespace powbench::host
