#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/comparison.h"
#include "core/conditions.h"
#include "core/events.h"
#include "core/origin.h"
#include "core/outcome.h"
#include "host/compare/limits.h"
#include "host/config/test_record.h"
#include "host/paper/published.h"
#include "host/report/vibration.h"

/// What a campaign's report is made of, and the two texts made from it. Nothing is read or written here.

namespace powbench::host {

/// One prepared signal for display. value i was taken t0 + i dt after switch-on. SI.
struct Waveform {
  std::string
      channel;  ///< name of the channel table: pvdf_a, pvdf_b, laser, coil_current, contact_a, mains_voltage
  std::string unit;           ///< SI
  double t0 = 0;              ///< s
  double dt = 0;              ///< s, > 0
  std::vector<float> values;  ///< not finite = not measured
};

struct ReportShot {
  int index = 0;          ///< the number of the shot in the store, the same everywhere
  Conditions conditions;  ///< as asked
  Outcome outcome = Outcome::error;
  std::string reason;            ///< one line for anything but pass
  std::optional<Events> events;  ///< absent without a valid record
  /// what the conditions it reached add to the simulation of its angle, SI, by symbol; empty: not known
  std::map<std::string, double> moved = {};
  double phase_u = std::numeric_limits<
      double>::quiet_NaN();  ///< rad: of the mains at the edge, by the rig; NaN = not told
  std::vector<Waveform> waveforms;
  std::vector<Waveform> raw;  ///< films before anything was taken off; of the closings to zoom into
  std::string record_hash;    ///< empty without a record
  double contact_level =
      std::numeric_limits<double>::quiet_NaN();  ///< V: the pole counts as open above it; NaN = not known
  std::vector<Outcome> earlier = {};             ///< of the attempts before this one, which left no record
};

/// The simulated closing laid beside the measured ones of its angle.
struct SimulatedClosing {
  double closing_angle = 0;  ///< rad, polarity included
  Events events;
  std::vector<Waveform> waveforms;
  std::vector<Waveform> spread = {};  ///< standard uncertainty of a curve by its inputs; absent: not known
  bool nominal = false;   ///< as the plan asks, not under the conditions of the closings; its u is not known
  bool outdated = false;  ///< closings were measured since, and have moved the mean of their conditions
  std::string basis =
      {};  ///< the conditions in words: "under the mean conditions of 2 measured closings"; "" = as asked
};

/// A calibration that was in force for some of the shots.
struct CalibrationUse {
  std::string id;
  std::string shots;     ///< "1 to 9, 12", in the order in which they were fired
  std::string last_day;  ///< on which one was fired, 2030-12-31
};

/// Where everything comes from. Empty = unknown, printed as a dash.
struct Provenance {
  std::string program;                       ///< name and version
  std::string rig;                           ///< model, serial, URI
  std::string firmware;                      ///< version
  std::vector<CalibrationUse> calibrations;  ///< in the order in which they came into force
  std::string plan_hash;
  std::string specimen_hash;
  std::string extraction_hash;    ///< of the extraction parameters
  std::string seed;               ///< of the plan
  std::string order;              ///< how the shots were ordered, e.g. "random, seed 1"
  std::string started, finished;  ///< date and time, ISO 8601
  std::string database;           ///< file name of the store
  std::vector<std::pair<std::string, std::string>> more;  ///< anything else: name, value
};

/// What a picture of the device needs, m.
struct DeviceShape {
  double centre = 0, outer = 0, window = 0;  ///< widths: centre leg, each outer leg, between them
  double fixed_window = 0,
         moving_window = 0;              ///< heights of the window in each half; moving 0: flat armature
  double yoke = 0, stack = 0, coil = 0;  ///< height of the yokes, depth, width of the winding in one window
  double travel = 0, gap = 0, half_length = 0;  ///< of the core, to first touch, bridge centre to break
  int poles = 0;
};

/// What happened to the campaign beside its shots: that it stopped early, that it was gone on with.
struct CourseEntry {
  std::string when;  ///< ISO 8601
  std::string what;
};

struct ReportInput {
  std::string campaign;     ///< name
  std::string specimen;     ///< name
  std::size_t planned = 0;  ///< shots the plan asks for
  bool unplanned = false;   ///< single closings by hand, or imports: none is missing
  Origin origin = Origin::unknown;
  Decision decision = Decision::simple;  ///< of the limits
  double most_from_simulation =
      std::numeric_limits<double>::quiet_NaN();  ///< share of the measured mean; NaN = no limit
  double angle_tolerance = 0;  ///< rad: allowed deviation of the angle reached; 0 = none given
  TestRecord test;
  std::vector<CourseEntry> course;  ///< in time
  Provenance provenance;
  std::vector<ReportShot> shots;  ///< in executed order
  std::vector<SimulatedClosing> simulated;
  Comparison comparison;                ///< from `compare`
  std::vector<PublishedRow> published;  ///< rows shown beside the measurement; empty = none
  std::vector<Limit> limits;
  std::size_t annotations = 0;             ///< that complete the test record
  std::string annotated;                   ///< when the last was made, ISO 8601
  std::optional<VibrationView> vibration;  ///< of the core on the films; absent without a film
  std::string extraction_parameters;       ///< one `name=value` a line
  std::optional<DeviceShape> device;       ///< where the specimen file has a shape
};

/// Shots by outcome.
struct Counts {
  std::size_t planned = 0;
  std::size_t done = 0;  ///< valid measurement: passed + failed + not_judged + not_observed
  std::size_t passed = 0;
  std::size_t failed = 0;  ///< outside limits
  std::size_t not_judged = 0, not_observed = 0;
  std::size_t errors = 0;   ///< ERROR, TIMEOUT, ABORTED
  std::size_t missing = 0;  ///< planned and never attempted
};
/// Nothing was to be fired: closings that were only simulated.
bool only_computed(const ReportInput&);
Counts count(const ReportInput&);

/// The campaign in one word: the worst of its shots and limits, ABORTED when planned shots are missing or there is
/// none. PASS only where at least one limit was judged. NOT JUDGED where closings were only computed.
Outcome verdict(const ReportInput&);

/// The first reason for a verdict that is none of PASS and NOT JUDGED, with how many more there are; or empty.
std::string verdict_reason(const ReportInput&);

/// What the course of the campaign says last, with its time; empty where it says nothing.
std::string last_of_course(const ReportInput&);

/// Every calibration, "LAB-1"; where there are several, each with its shots: "LAB-1 (shot 1), LAB-2 (shots 2 to 9)".
std::string calibrations_text(const Provenance&);

/// Instruments whose calibration had ended when the last shot was fired, the rig's own when the last shot under it was
/// fired; of an import on the day on which it was recorded, none where that is not known.
std::vector<Instrument> expired_then(const ReportInput&);

/// One self-contained HTML page: no network, inline SVG, made to be printed on A4. Scripts, for the closer look
/// alone, are part of it. Also well-formed XML.
std::string render_html(const ReportInput&);

/// The first shot of the input and the simulation of its angle: all channels over one time axis, as SVG or as a page
/// of its own.
std::string render_shot_svg(const ReportInput&);
std::string render_shot_html(const ReportInput&);

/// JUnit XML: one suite; a case per shot, per limit, for the number of shots done and for the calibrations of the
/// instruments that the test record names (skipped where one had expired or its validity is not stated). FAIL and NOT
/// OBSERVED are failures; ERROR, TIMEOUT, ABORTED are errors; NOT JUDGED is skipped.
std::string render_junit(const ReportInput&);

}  // namespace powbench::host
