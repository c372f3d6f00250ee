#pragma once

#include <cstdint>
#include <string>

/// Every parameter of the extraction, with its default. Printed with the results and hashed into them.

namespace powbench::dsp {

/// Columns: type | name | default | meaning with unit.
#define POWBENCH_EXTRACT_OPTIONS(X)                                                                         \
  X(double, mains_hertz, 50.0, "Hz: nominal mains frequency, the start of the frequency fit")               \
  X(double, min_hum_periods, 1.95, "mains periods the pre-trigger must hold before hum is fitted")          \
  X(int, hum_harmonics, 3, "highest mains harmonic removed from the force channels")                        \
  X(double, crosstalk_a, 0.0, "share of film B's force that film A shows, from the calibration")            \
  X(double, crosstalk_b, 0.0, "share of film A's force that film B shows, from the calibration")            \
  X(int, angle_harmonics, 7,                                                                                \
    "highest mains harmonic in the closing-angle fit: all odd ones, even ones to 4")                        \
  X(double, detection_width, 12e-6, "s: standard deviation of the Gaussian used to detect contacts")        \
  X(double, detection_width_max, 60e-6, "s: the Gaussian widens up to here when the noise asks for it")     \
  X(double, touch_sigmas, 6.0, "detection level for a touch, in standard deviations of the smoothed noise") \
  X(double, release_sigmas, 3.0, "detection level for a release, same unit")                                \
  X(double, touch_share, 0.08, "lowest detection level for a touch, as a share of the settled force")       \
  X(double, release_share, 0.04, "lowest detection level for a release, as a share of the settled force")   \
  X(double, min_closed, 20e-6, "s: shorter contacts are noise")                                             \
  X(double, min_open, 30e-6, "s: shorter openings seen by force are not resolved")                          \
  X(double, fit_margin, 150e-6, "s: open time on either side of a contact that enters its fit")             \
  X(double, edge_window, 300e-6, "s: closed time that enters the fit of a single edge")                     \
  X(double, exponent_min, 0.5, "smallest exponent of the contact pulse (1 = half sine, 1.5 = Hertz)")       \
  X(double, exponent_max, 3.0, "largest exponent of the contact pulse")                                     \
  X(double, chi2_confidence, 0.99, "two-sided band outside which a fit is flagged poor")                    \
  X(int, ring_modes, 5, "largest number of core-vibration modes; 0 = leave the ringing in")                 \
  X(double, ring_low_hertz, 800.0, "Hz: lowest core-vibration mode looked for")                             \
  X(double, ring_high_hertz, 18e3, "Hz: highest core-vibration mode looked for")                            \
  X(double, ring_damping_max, 0.04, "largest damping ratio of a core-vibration mode")                       \
  X(double, ring_tail, 12e-3, "s: length of the closed tail in which the modes are identified")             \
  X(int, ring_rounds, 4, "alternations between ring fit and contact fit")                                   \
  X(double, settled_window, 10e-3, "s: end of the closed time over which the settled force is averaged")    \
  X(double, min_open_voltage, 10e-6, "s: shortest opening counted on the contact-voltage channel")          \
  X(double, open_share, 0.5, "share of the open-circuit voltage above which the pole counts as open")       \
  X(double, merge_openings, 0.0,                                                                            \
    "s: bounce filter on request; openings up to here count as closed; 0 = off")                            \
  X(double, seat_window, 400e-6, "s: travel on either side of the core seat that enters its fit")           \
  X(double, seat_share, 0.25, "later velocity drop, as a share of the first, that counts as a core bounce") \
  X(int, display_order, 4, "order of the Butterworth low-pass of the displayed force")                      \
  X(double, display_hertz, 10e3, "Hz: its -3 dB frequency after both passes")

enum class FilterPhase : std::uint8_t { zero, causal };

/// A filter that somebody wants on the force channels before events are looked for; none unless requested.
struct EventFilter {
  enum class Kind : std::uint8_t {
    none,
    plain,  ///< low-pass at the end of the contact band, where the vibration leaves room for one (dsp/filter/bands.h)
    low,   ///< low-pass at `high_hertz`
    stop,  ///< band-stop between `low_hertz` and `high_hertz`
  };
  Kind kind = Kind::none;
  double low_hertz = 0,
         high_hertz = 0;  ///< Hz, -3 dB; of `plain` the end of its pass band, found by extract_on_request
  FilterPhase phase = FilterPhase::zero;
  bool judged =
      false;  ///< set by extract_on_request when the filter leaves the contacts in; only then it is applied

  bool wanted() const { return kind != Kind::none; }
};

struct ExtractOptions {
#define POWBENCH_X(type, name, value, meaning) type name = value;
  POWBENCH_EXTRACT_OPTIONS(POWBENCH_X)
#undef POWBENCH_X
  EventFilter filter;
};

/// Canonical text: one `name=value` a line in table order, doubles with 17 digits; behind it the filter, where one is
/// wanted. Equal options give equal text.
std::string to_text(const ExtractOptions&);

/// FNV-1a (64 bit) of to_text, 16 hexadecimal digits.
std::string parameters_hash(const ExtractOptions&);

/// Throws std::invalid_argument naming the option, its value and the allowed range.
void check(const ExtractOptions&);

}  // namespace powbench::dsp
