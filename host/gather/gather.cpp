#include "host/gather/gather.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>
#include <map>
#include <set>
#include <span>

#include "core/version.h"
#include "dsp/contacts/contact_voltage.h"
#include "dsp/events/prepare.h"
#include "dsp/signal/signal.h"
#include "host/gather/provenance.h"
#include "host/gather/scene.h"
#include "host/gather/verdict.h"
#include "host/gather/vibration.h"
#include "host/report/view.h"
#include "host/run/simulate.h"
#include "host/store/json.h"

namespace powbench::host {

namespace {

Waveform waveform(const dsp::Signal& s, Channel channel) {
  Waveform w{.channel = std::string(info(channel).name),
             .unit = std::string(info(channel).unit),
             .t0 = s.t0,
             .dt = s.dt,
             .values = {}};
  w.values.assign(s.value.begin(), s.value.end());
  for (std::size_t i = 0; i < s.masked.size(); ++i)
    if (s.masked[i] != 0) w.values[i] = std::nanf("");
  return w;
}

/// Counted from the step of the coil voltage, as the times beside them.
std::vector<Waveform> after_switch_on(std::vector<Waveform> waves, const std::optional<Events>& events) {
  for (Waveform& w : waves) w.t0 -= events ? switch_delay(*events).value : 0;
  return waves;
}

std::vector<Waveform> waveforms(const Record& record, const dsp::ExtractOptions& options) {
  const dsp::Prepared p = dsp::prepare(record, options);
  std::vector<Waveform> list;
  const std::pair<const dsp::Signal*, Channel> shown[] = {{&p.pvdf_a, Channel::pvdf_a},
                                                          {&p.pvdf_b, Channel::pvdf_b},
                                                          {&p.laser, Channel::laser},
                                                          {&p.coil_current, Channel::coil_current},
                                                          {&p.coil_voltage, Channel::coil_voltage},
                                                          {&p.mains_voltage, Channel::mains_voltage},
                                                          {&p.contact_voltage, Channel::contact_a}};
  for (const auto& [signal, channel] : shown)
    if (!signal->empty()) list.push_back(waveform(*signal, channel));
  return list;
}

Provenance provenance(const Store& store, const CampaignInfo& c, const Plan& plan,
                      const std::vector<StoredShot>& fired, const std::string& database) {
  Provenance p = rig_provenance(store, fired);
  p.program = fmt::format("powbench {}", program_version);
  if (c.program_version != program_version)
    p.program += fmt::format(" (acquired with {})", c.program_version);
  p.rig = c.rig_identity + (c.rig_uri.empty() ? "" : " (" + c.rig_uri + ")");
  p.plan_hash = c.plan_hash;
  p.specimen_hash = c.specimen_hash;
  p.extraction_hash = dsp::parameters_hash(run_options(plan).extract);
  if (c.origin != Origin::import) p.seed = std::to_string(plan.seed);
  p.order = c.origin == Origin::import     ? "imported; nothing was planned"
            : plan.order == Order::by_hand ? "single closings, fired by hand"
            : plan.order == Order::random  ? fmt::format("random within each repeat, seed {}", plan.seed)
                                           : "as listed";
  p.started = c.created;
  p.database = std::filesystem::path(database).filename().string();
  return p;
}

}  // namespace

namespace {

std::vector<Waveform> spread_of(const InputSpread& prediction) {
  std::vector<Waveform> out;
  for (const CurveSpread& c : prediction.curves) out.push_back({c.channel, "", c.t0, c.dt, c.u});
  return out;
}

/// What the simulations say of each closing at its own conditions, by the number of the shot.
std::map<int, std::map<std::string, double>> moved_by_own(const Store& store, std::int64_t campaign) {
  std::map<int, std::map<std::string, double>> all;
  for (const StoredShot& s : store.shots(campaign, ShotKind::simulated))
    all.merge(store.prediction(s.id).moved);
  return all;
}

/// Stored text that cannot be read is damage, not bad input.
template <class F>
auto stored_text(const CampaignInfo& c, F&& read) {
  try {
    return read();
  } catch (const std::exception& e) {
    throw StoreError("campaign " + std::to_string(c.id) + " of the store cannot be read: " + e.what());
  }
}

}  // namespace

Plan stored_plan(const CampaignInfo& c) {
  return stored_text(c, [&] { return parse_plan(c.plan, "stored plan"); });
}

sim::Specimen stored_specimen(const CampaignInfo& c) {
  return stored_text(c, [&] { return parse_specimen(c.specimen, "stored specimen"); });
}

bool unplanned(const CampaignInfo& c, const Plan& plan) {
  return plan.order == Order::by_hand || c.origin == Origin::import;
}

RunOptions stored_options(const CampaignInfo& c, const Plan& plan) {
  RunOptions options = run_options(plan);
  if (c.origin == Origin::import) options.angle_tolerance = 0;
  return options;
}

std::vector<AngleGroup> gather_angles(const Store& store, std::int64_t campaign) {
  std::vector<AngleGroup> groups;
  auto moved = moved_by_own(store, campaign);
  for (const StoredShot& s : store.shots(campaign)) {
    AngleGroup& group = group_at(groups, radians(s.angle_deg));
    const auto events = store.load_events(s.id);
    if (!events && measured(s.outcome))  // a mean without it would be of other shots than it says
      throw StoreError(fmt::format(
          "the file is damaged: the events of shot {} are missing; restore it from a copy", s.id));
    if (!events) continue;
    (s.kind == ShotKind::measured ? group.measured : group.simulated).push_back(*events);
    if (s.kind == ShotKind::simulated) group.u_simulated = store.prediction(s.id).u;
    if (s.kind == ShotKind::measured) group.moved.push_back(moved[s.number]);
  }
  return groups;
}

/// The published tables are of one device; they say nothing about another.
bool names_published(const sim::Specimen& s) {
  return s.name == "published" || s.name.starts_with("published-");
}

std::span<const PublishedRow> published_of(const CampaignInfo& c) {
  return names_published(stored_specimen(c)) ? std::span<const PublishedRow>(published_rows())
                                             : std::span<const PublishedRow>();
}

Comparison compare_stored(const Store& store, const CampaignInfo& c) {
  const Plan plan = stored_plan(c);
  return compare(gather_angles(store, c.id), published_of(c), plan_limits(plan), plan.decision,
                 plan.limits_vs_simulation);
}

std::vector<CurveRow> gather_curves(const Store& store, const CampaignInfo& c) {
  ReportInput input;
  for (const StoredShot& s : store.shots(c.id)) {
    const auto events = store.load_events(s.id);
    if (!events || s.record_hash.empty()) continue;
    const Record record = store.load_record(s.id);
    std::vector<Waveform> waves;
    for (const Channel channel : {Channel::coil_current, Channel::laser})
      if (const dsp::Signal signal = dsp::to_signal(record, channel); !signal.empty())
        waves.push_back(waveform(signal, channel));
    if (s.kind == ShotKind::measured) {
      ReportShot shot;
      shot.conditions = s.conditions;
      shot.events = events;
      shot.waveforms = after_switch_on(std::move(waves), events);
      input.shots.push_back(std::move(shot));
    } else {
      input.simulated.push_back(
          {radians(s.angle_deg), *events, after_switch_on(std::move(waves), events), {}});
    }
  }
  std::vector<CurveRow> rows;
  for (const AngleView& view : angles_of(input))
    for (CurveRow& row : curve_rows(view)) rows.push_back(std::move(row));
  return rows;
}

/// Shots whose waveforms the report draws: the first of each angle, fewer where there are many angles, so that the
/// page of a long campaign stays small. Only these are read from the store.
std::set<std::int64_t> shots_to_draw(const std::vector<StoredShot>& shots) {
  constexpr std::size_t most_angles = 36, most_traces = 60, most_repeats = 5;
  std::map<double, std::pair<std::size_t, std::size_t>> seen;  // by angle: measured, simulated; NaN as -1
  const auto key = [](const StoredShot& s) { return std::isfinite(s.angle_deg) ? s.angle_deg : -1.0; };
  for (const StoredShot& s : shots) seen[key(s)];
  const std::size_t step = (seen.size() + most_angles - 1) / most_angles;
  const std::size_t repeats =
      std::clamp<std::size_t>(most_traces / std::max<std::size_t>(seen.size(), 1), 1, most_repeats);
  std::map<double, bool> wanted;
  std::size_t place = 0;
  for (const auto& [angle, unused] : seen) wanted[angle] = place++ % std::max<std::size_t>(step, 1) == 0;
  std::set<std::int64_t> drawn;
  for (const StoredShot& s : shots) {
    if (s.record_hash.empty() || !wanted[key(s)]) continue;
    auto& [measured_so_far, simulated_so_far] = seen[key(s)];
    std::size_t& n = s.kind == ShotKind::measured ? measured_so_far : simulated_so_far;
    if (n < (s.kind == ShotKind::measured ? repeats : 1)) drawn.insert(s.id), ++n;
  }
  return drawn;
}

TestRecord gather_test_record(const Store& store, const CampaignInfo& c) {
  TestRecord record = stored_plan(c).test;
  for (const Annotation& a : store.annotations(c.id))
    if (a.key != course_key) stored_text(c, [&] { return complete(record, a.key, a.text), 0; });
  return record;
}

/// The films of a record as they were recorded, in SI.
std::vector<Waveform> raw_films(const Record& record) {
  std::vector<Waveform> list;
  for (const Channel channel : {Channel::pvdf_a, Channel::pvdf_b})
    if (const dsp::Signal signal = dsp::to_signal(record, channel); !signal.empty())
      list.push_back(waveform(signal, channel));
  return list;
}

ReportInput gather_shot(const Store& store, std::int64_t id) {
  const StoredShot wanted = store.shot(id);
  if (wanted.record_hash.empty())
    throw StoreError("shot " + std::to_string(id) + " has no record: nothing to draw");
  const CampaignInfo c = store.campaign(wanted.campaign);
  const RunOptions options = run_options(stored_plan(c));
  ReportInput input;
  input.campaign = c.name;
  input.specimen = stored_specimen(c).name;
  input.origin = wanted.kind == ShotKind::simulated ? Origin::simulation : c.origin;
  const auto record_of = [&](const StoredShot& s) {
    Record record = store.load_record(s.id);
    record.conditions = s.conditions;
    return record;
  };
  std::vector<AngleGroup> groups;
  std::future<std::vector<Waveform>> beside;  // filtered while the measured one is
  if (wanted.kind == ShotKind::measured)
    for (const StoredShot& s : store.shots(c.id, ShotKind::simulated)) {
      if (s.record_hash.empty() || !same_angle(radians(s.angle_deg), radians(wanted.angle_deg))) continue;
      const auto events = store.load_events(s.id);
      if (!events) continue;
      group_at(groups, radians(s.angle_deg)).simulated.push_back(*events);
      input.simulated.push_back(
          {radians(s.angle_deg), *events, {}, after_switch_on(spread_of(store.prediction(s.id)), events)});
      beside = std::async([record = record_of(s), &options] { return waveforms(record, options.extract); });
      break;
    }
  const Record record = record_of(wanted);
  const auto events = store.load_events(id);
  AngleGroup& group = group_at(groups, radians(wanted.angle_deg));
  if (events) (wanted.kind == ShotKind::measured ? group.measured : group.simulated).push_back(*events);
  input.shots.push_back({.index = static_cast<int>(id),
                         .conditions = wanted.conditions,
                         .outcome = wanted.outcome,
                         .reason = wanted.reason,
                         .events = events,
                         .phase_u = phase_deviation(store, wanted),
                         .waveforms = after_switch_on(waveforms(record, options.extract), events),
                         .raw = after_switch_on(raw_films(record), events),
                         .record_hash = wanted.record_hash,
                         .contact_level = dsp::contact_level(record, options.extract)});
  if (beside.valid())
    input.simulated.front().waveforms = after_switch_on(beside.get(), input.simulated.front().events);
  input.comparison = compare(std::move(groups), {}, {}, Decision::simple);
  return input;
}

namespace {

std::optional<DeviceShape> shape_of(const sim::Specimen& s) {
  if (!s.shaped) return std::nullopt;
  return DeviceShape{s.shape.centre_width,  s.shape.outer_width, s.shape.window_width,  s.shape.fixed_window,
                     s.shape.moving_window, s.shape.yoke,        s.shape.stack,         s.shape.coil_width,
                     s.core.travel,         s.bridges.gap,       s.bridges.half_length, s.bridges.poles};
}

}  // namespace

std::string simulation_basis(const StoredShot& simulated) {
  return simulated.reason.empty() ? "at the conditions asked for"
                                  : simulated.reason.substr(0, simulated.reason.find(';'));
}

/// The closings of the angle, as they stand now, had other conditions than the simulation was made under.
static bool outdated(const StoredShot& simulated, const std::vector<PlannedShot>& planned,
                     const std::vector<Events>& measured, const RunOptions& options) {
  const double angle = radians(simulated.angle_deg);
  const auto asked = std::find_if(planned.begin(), planned.end(), [&](const PlannedShot& p) {
    return same_angle(effective_angle(p.conditions), angle);
  });
  return asked != planned.end() &&
         to_json(inputs_of(asked->conditions, measured, options).conditions) != to_json(simulated.conditions);
}

ReportInput gather_report(const Store& store, const CampaignInfo& c, const std::string& database) {
  const Plan plan = stored_plan(c);
  const sim::Specimen specimen = stored_specimen(c);
  const RunOptions options = stored_options(c, plan);
  const std::vector<StoredShot> shots = store.shots(c.id);
  ReportInput input;
  input.campaign = c.name;
  input.specimen = specimen.name;
  input.device = shape_of(specimen);
  input.unplanned = unplanned(c, plan);
  const std::vector<PlannedShot> planned =
      input.unplanned ? std::vector<PlannedShot>() : expand(plan, specimen.name);
  input.planned = planned.size();
  input.origin = c.origin;
  input.decision = plan.decision;
  input.most_from_simulation = plan.limits_vs_simulation;
  input.angle_tolerance = options.angle_tolerance;
  input.test = gather_test_record(store, c);
  for (const Annotation& a : store.annotations(c.id)) {
    if (a.key == course_key) {
      input.course.push_back({a.created, a.text});
      continue;
    }
    ++input.annotations;
    input.annotated = a.created;
  }
  const std::vector<StoredShot> fired = by_firing(shots);
  input.provenance = provenance(store, c, plan, fired, database);
  input.limits = options.limits;
  if (names_published(specimen)) input.published = published_rows();
  input.extraction_parameters = dsp::to_text(options.extract);
  VibrationFinder vibration(options.extract);
  std::vector<AngleGroup> groups;
  auto moved = moved_by_own(store, c.id);
  auto earlier = earlier_outcomes(store, c.id);
  const std::set<std::int64_t> drawn = shots_to_draw(fired);
  constexpr std::size_t most_to_zoom = 10;
  std::set<double> zoomed;  // one closing of an angle
  for (const StoredShot& s : shots) {
    const auto events = store.load_events(s.id);
    AngleGroup& group = group_at(groups, radians(s.angle_deg));
    if (events) (s.kind == ShotKind::measured ? group.measured : group.simulated).push_back(*events);
    if (events && s.kind == ShotKind::measured) group.moved.push_back(moved[s.number]);
    std::vector<Waveform> waves, raw;
    double contact_level = unknown;
    if (!s.record_hash.empty() && drawn.contains(s.id)) {
      Record record = store.load_record(s.id);
      record.conditions = s.conditions;
      waves = waveforms(record, options.extract);
      if (events && s.kind == ShotKind::measured && zoomed.size() < most_to_zoom &&
          zoomed.insert(s.angle_deg).second)
        raw = raw_films(record), contact_level = dsp::contact_level(record, options.extract);
      if (events && s.kind == ShotKind::measured) vibration.add(static_cast<int>(s.id), record, *events);
    }
    if (s.kind == ShotKind::simulated) {
      const InputSpread prediction = store.prediction(s.id);
      group.u_simulated = prediction.u;
      if (!events) continue;
      const bool nominal = prediction.empty();
      input.simulated.push_back({radians(s.angle_deg), *events, after_switch_on(std::move(waves), events),
                                 after_switch_on(spread_of(prediction), events), nominal,
                                 !nominal && outdated(s, planned, group.measured, options),
                                 simulation_basis(s)});
      continue;
    }
    const Judgement judged = judged_anew(s, events, options);
    input.shots.push_back({.index = static_cast<int>(s.id),
                           .conditions = s.conditions,
                           .outcome = judged.outcome,
                           .reason = judged.reason,
                           .events = events,
                           .moved = moved[s.number],
                           .phase_u = phase_deviation(store, s),
                           .waveforms = after_switch_on(std::move(waves), events),
                           .raw = after_switch_on(std::move(raw), events),
                           .record_hash = s.record_hash,
                           .contact_level = contact_level,
                           .earlier = earlier[s.number]});
  }
  std::map<int, std::size_t> place;
  for (const StoredShot& s : fired) place.emplace(static_cast<int>(s.id), place.size());
  std::sort(input.shots.begin(), input.shots.end(),
            [&](const auto& a, const auto& b) { return place.at(a.index) < place.at(b.index); });
  input.vibration = vibration.finish();
  input.comparison =
      compare(std::move(groups), input.published, options.limits, plan.decision, plan.limits_vs_simulation);
  return input;
}

}  // namespace powbench::host
