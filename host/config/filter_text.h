#pragma once

#include <string>
#include <string_view>

#include "dsp/filter/bands.h"
#include "dsp/options.h"

/// A filter and a band as people write them: on the command line and in the plan.

namespace powbench::host {

inline constexpr std::string_view filter_forms =
    "none, plain, lowpass:2kHz or bandstop:3.1kHz..3.6kHz (100 Hz..1 MHz; a band at least 5 % wide)";
inline constexpr std::string_view phase_forms = "zero or causal";
inline constexpr std::string_view band_forms =
    "LOW..HIGH such as 800Hz..18kHz (100 Hz..1 MHz, at least 5 % wide)";

/// Kind and edges; the phase stays. Returns what is wrong, "" when nothing is; then `filter` is set.
std::string read_filter(std::string_view text, dsp::EventFilter& filter);
std::string read_phase(std::string_view text, dsp::FilterPhase&);
std::string read_band(std::string_view text, dsp::Band&);

/// All three into the options; an empty text leaves what is there. Says what is wrong with the whole, too: `plain` is
/// zero phase.
struct FilterWords {
  std::string filter, phase, band;
};
struct FilterMistake {
  std::string key;  ///< filter, phase or band; "" = none
  std::string what;
  std::string_view allowed;
};
FilterMistake set_filter(dsp::ExtractOptions&, const FilterWords&);

/// `lowpass:2kHz`; reads back as the same filter.
std::string text_of(const dsp::EventFilter&);

}  // namespace powbench::host
