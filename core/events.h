#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

/// What happened in one closing, extracted from a record by `dsp/`. Times in seconds after the coil was switched on.

namespace powbench {

/// A value with its standard uncertainty (k = 1). NaN = not observed.
struct Measured {
  double value = std::numeric_limits<double>::quiet_NaN();
  double u = std::numeric_limits<double>::quiet_NaN();

  bool known() const { return std::isfinite(value); }
};

/// Why a value deserves less trust. A bit set.
enum Flag : std::uint32_t {
  flag_none = 0,
  flag_clipped = 1U << 0,         ///< the channel saturated inside the event
  flag_gap = 1U << 1,             ///< lost samples inside the event
  flag_edge = 1U << 2,            ///< inside the filter's invalid edge
  flag_poor_fit = 1U << 3,        ///< residual chi-square outside its 99 % band: the model is biased here
  flag_no_hum_fit = 1U << 4,      ///< pre-trigger shorter than two mains periods: hum not removed
  flag_polarity = 1U << 5,        ///< the film's sign was found inverted
  flag_contradiction = 1U << 6,   ///< force and contact-voltage disagree on open or closed
  flag_ring_overlap = 1U << 7,    ///< core vibration overlaps the contact band and could not be separated
  flag_no_calibration = 1U << 8,  ///< the calibration is missing or expired
  flag_angle_off =
      1U << 9,  ///< closing angle reached differs from the commanded one by more than the tolerance
  flag_gain =
      1U << 10,  ///< a settled force no contact has, or one film's far from the other's: a gain may be wrong
  flag_grazing = 1U << 11,     ///< the force only just reaches zero: whether it opened there is not known
  flag_resolution = 1U << 12,  ///< a later landing of the core, or a blow of the contacts: not told apart
  flag_chatter =
      1U
      << 14,  ///< the end came too early to tell whether it opens again, or the core still moved: settled is unknown
  flag_switch_on =
      1U << 13,  ///< the coil's voltage or current begins at another time than 0, from which all counts
  flag_beyond_fields =
      1U << 15,  ///< simulated, in part outside of the gaps and fluxes its fields were made from
};

/// One closed interval of one contact.
struct Contact {
  Measured touch;    ///< s: force leaves zero
  Measured release;  ///< s: force is back at zero; not known while the contact stays closed
  Measured peak;     ///< N; NaN on the contact-voltage channel
  Measured impulse;  ///< N s over the interval; NaN for the last, open-ended contact
  std::uint32_t flags = flag_none;
  /// That it is a contact of its own: the opening before it is one, and what shows is no vibration. 1 where nothing
  /// speaks against it.
  double probability = 1.0;
};

/// Part of a train: the bounces after the first touch, or those that the core's impact causes.
struct BounceTrain {
  int openings = 0;  ///< re-openings
  Measured from;     ///< s: first touch; in the second train the first release at or after the core's seat
  Measured to;       ///< s: last touch of the part; unknown when it does not end closed
};

/// What a channel shows over a closing.
enum class Shows : std::uint8_t {
  contact,     ///< a force that presses
  nothing,     ///< no contact
  vibration,   ///< as much below zero as above: no contact force; contacts are not listed
  not_usable,  ///< missing, dead, or mostly lost
};
inline constexpr std::array<std::string_view, 4> shows_names{"contact", "nothing", "vibration", "not usable"};
inline std::string_view name(Shows s) {
  return shows_names[static_cast<std::size_t>(s)];
}

/// The train of touches seen by one channel (a force channel or the contact-voltage channel).
struct ContactTrain {
  bool present = false;  ///< the channel exists and passed its quality gate
  Shows shows = Shows::contact;
  std::string reason;             ///< why it shows no contact; empty where it does
  std::vector<Contact> contacts;  ///< in order of touch
  Measured settled;          ///< s: last touch, after which the contact stays closed (AC pulsation allowed)
  Measured settled_force;    ///< N: mean force at the end of the record
  Measured bounce_time;      ///< s: settled - first touch (first to last closing; relay standards)
  int bounce_count = 0;      ///< re-openings within the bounce time
  BounceTrain first_train;   ///< before the core's seat; the whole train when no seat is known
  BounceTrain second_train;  ///< from the core's seat on
  double resolution = 0.0;   ///< s: shortest opening this channel can resolve
  double noise = 0.0;        ///< rms of the pre-trigger after offset and hum were removed, channel unit
  std::uint32_t flags = flag_none;
};

/// The moving core, seen by the laser.
struct CoreEvents {
  bool present = false;
  Measured seat;             ///< s: first arrival at the closed position
  Measured settled;          ///< s: last arrival (= seat when the core does not bounce)
  Measured bounce_time;      ///< s: settled - seat
  Measured impact_velocity;  ///< m/s at seat
  Measured travel;           ///< m: closed position minus open position
  std::uint32_t flags = flag_none;
};

/// The coil and its supply.
struct CoilEvents {
  Measured closing_angle;  ///< rad, [0, 2 pi): phase of the mains fundamental at the voltage step
  std::string no_angle;    ///< why the closing angle is not known; empty where it is
  Measured switch_on;      ///< s: the coil-voltage step against the rig's own fire sample
  Measured mains_hertz;    ///< Hz
  Measured supply_volts;   ///< V rms of the fundamental before switch-on
  Measured peak_current;   ///< A: largest |i|
  std::uint32_t flags = flag_none;
};

/// The measured pole, closed only while both of its breaks are: what force says beside what the contact-voltage says.
struct PoleEvents {
  ContactTrain by_force;          ///< from both films: openings of either break; not present without both
  Measured disagreement;          ///< s: time within the closing in which force and contact-voltage differ
  Measured longest_disagreement;  ///< s: the longest stretch of it
};

/// All events of one record. Filled by `dsp/extract_events`.
struct Events {
  ContactTrain pvdf_a;
  ContactTrain pvdf_b;
  ContactTrain contact_voltage;  ///< the measured pole: closed only when both of its breaks are closed
  PoleEvents pole;               ///< the same pole by force, and how far the two agree
  CoreEvents core;
  CoilEvents coil;
  std::string method;           ///< name of the extraction chain
  std::string parameters_hash;  ///< of the extraction parameters
  std::uint32_t flags = flag_none;
};

}  // namespace powbench
