#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/events.h"
#include "core/record.h"
#include "dsp/events/film_paths.h"
#include "dsp/filter/event_filter.h"
#include "dsp/options.h"

/// Events behind a filter that somebody requested: judged by what it takes from the contacts before it is applied.

namespace powbench::dsp {

/// The filter on one force channel.
struct FilmFilter {
  Channel film = Channel::pvdf_a;
  double shortest = 1e-3;  ///< s: shortest contact or opening without the filter, 1 ms at most
  double contact_db =
      0;  ///< dB <= 0: share of the energy of a half sine of that length that the filter takes
  double vibration_db = 0;  ///< dB <= 0: what the filter leaves of the vibration's power
  bool found =
      false;  ///< vibration stands out; else `vibration_db` is the mean over the band it was looked for in
};

struct FilterJudgement {
  EventFilter filter;  ///< `judged` where it may be applied
  FilterEffect effect;
  std::vector<FilmFilter> films;
  std::string refused;  ///< why it is not applied, with the figures; empty where it is
};

/// Most of the energy of the shortest contact or opening that a filter may take, dB: one hundredth.
inline constexpr double most_taken_db = -20;

/// `unfiltered`: events of the record without the filter, and how they came.
FilterJudgement judge_filter(const Record&, const Events& unfiltered, const FilmPaths&,
                             const ExtractOptions&);

struct Extracted {
  Events events;
  std::optional<FilterJudgement> filter;  ///< where one was wanted
  FilmPaths bare;                         ///< without a filter
};

/// Events, behind the filter of the options where rate and length of the record allow it and it leaves contacts and
/// openings in, else without it; `method` says which. A record that was fired for is never lost to a filter. Throws
/// like extract_events.
Extracted extract_on_request(const Record&, const ExtractOptions&);

}  // namespace powbench::dsp
