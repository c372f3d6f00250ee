#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/events.h"
#include "core/record.h"
#include "dsp/events/vibration.h"
#include "dsp/options.h"
#include "host/report/vibration.h"

/// From records to what is shown about the core's vibration.

namespace powbench::host {

/// Collects closings; then says where the core vibrates and draws one of them.
class VibrationFinder {
 public:
  explicit VibrationFinder(dsp::ExtractOptions options) : options_(options) {}

  /// A measured closing; the first with vibration on a film is the one drawn. At most 40 count for the bands.
  void add(int shot, const Record&, const Events&);
  /// Nothing without a film.
  std::optional<VibrationView> finish();

 private:
  struct Film {
    Channel channel;
    std::vector<dsp::Closing> closings;
    std::optional<dsp::FilmVibration> drawn;
    double shortest = 1e-3;
  };
  dsp::ExtractOptions options_;
  Film films_[2] = {{Channel::pvdf_a, {}, {}, 1e-3}, {Channel::pvdf_b, {}, {}, 1e-3}};
  int shot_ = 0;
  double angle_ = 0;
};

/// A laboratory's rule in place of powbench's own definitions; what is not given stays as it is.
struct LabRule {
  std::optional<double> force_percent, voltage_percent, min_opening_us;
  bool any() const { return force_percent || voltage_percent || min_opening_us; }
};

/// Sets the options that the extraction itself has for the rule.
void set_rule(dsp::ExtractOptions&, const LabRule&);

/// Replaces the films' trains by crossings of a level where a share of the settled force is given.
void apply_rule(Events&, const Record&, const dsp::ExtractOptions&, const LabRule&);

/// Bands of one closing alone, with the options and paths of its extraction, as JSON text, one entry a film: {"film",
/// "modes_hertz": [], "contact_hertz", "ring_in_contact_db", "pulse_in_core_db", "overlaps", "filter", "canceller"};
/// without vibration only "film" and no modes.
std::string bands_json(const Record&, const Events&, const dsp::ExtractOptions&, const dsp::FilmPaths&);

/// The same, one line a film, for the terminal.
std::vector<std::string> band_lines(const Record&, const Events&, const dsp::ExtractOptions&,
                                    const dsp::FilmPaths&);

}  // namespace powbench::host
