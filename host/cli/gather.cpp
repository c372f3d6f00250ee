#include "host/cli/gather.h"

#include <fmt/format.h>

#include <filesystem>

#include "core/version.h"
#include "dsp/prepare.h"
#include "dsp/signal.h"
#include "host/cli/scene.h"
#include "host/cli/vibration.h"
#include "host/report/view.h"

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
                      const std::vector<StoredShot>& shots, const std::string& database) {
  Provenance p;
  p.program = fmt::format("powbench {}", program_version);
  if (c.program_version != program_version)
    p.program += fmt::format(" (acquired with {})", c.program_version);
  p.rig = c.rig_identity + (c.rig_uri.empty() ? "" : " (" + c.rig_uri + ")");
  p.plan_hash = c.plan_hash;
  p.specimen_hash = c.specimen_hash;
  p.extraction_hash = dsp::parameters_hash(run_options(plan).extract);
  p.seed = std::to_string(plan.seed);
  p.order = plan.order == Order::random ? fmt::format("random within each repeat, seed {}", plan.seed)
                                        : "as listed";
  p.started = c.created;
  p.database = std::filesystem::path(database).filename().string();
  for (const StoredShot& s : shots) {
    if (s.kind != ShotKind::measured) continue;
    p.finished = std::max(p.finished, s.started);
    if (s.record_hash.empty() || !p.firmware.empty()) continue;
    const Record r = store.load_record(s.id);
    p.firmware = r.firmware;
    p.calibration = r.calibration;
  }
  return p;
}

}  // namespace

namespace {

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

std::vector<AngleGroup> gather_angles(const Store& store, std::int64_t campaign) {
  std::vector<AngleGroup> groups;
  for (const StoredShot& s : store.shots(campaign)) {
    AngleGroup& group = group_at(groups, radians(s.angle_deg));
    const auto events = store.load_events(s.id);
    if (!events) continue;
    (s.kind == ShotKind::measured ? group.measured : group.simulated).push_back(*events);
  }
  return groups;
}

Comparison compare_stored(const Store& store, const CampaignInfo& c) {
  const Plan plan = stored_plan(c);
  return compare(gather_angles(store, c.id), published_rows(), plan_limits(plan), plan.decision,
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
      shot.waveforms = std::move(waves);
      input.shots.push_back(std::move(shot));
    } else {
      input.simulated.push_back({radians(s.angle_deg), *events, std::move(waves)});
    }
  }
  std::vector<CurveRow> rows;
  for (const AngleView& view : angles_of(input))
    for (CurveRow& row : curve_rows(view)) rows.push_back(std::move(row));
  return rows;
}

ReportInput gather_report(const Store& store, const CampaignInfo& c, const std::string& database) {
  const Plan plan = stored_plan(c);
  const sim::Specimen specimen = stored_specimen(c);
  const RunOptions options = run_options(plan);
  const std::vector<StoredShot> shots = store.shots(c.id);
  ReportInput input;
  input.campaign = c.name;
  input.specimen = specimen.name;
  input.planned = expand(plan, specimen.name).size();
  input.origin = c.origin;
  input.decision = plan.decision;
  input.most_from_simulation = plan.limits_vs_simulation;
  input.angle_tolerance = plan.angle_tolerance;
  input.provenance = provenance(store, c, plan, shots, database);
  input.limits = options.limits;
  input.published = published_rows();
  input.extraction_parameters = dsp::to_text(options.extract);
  VibrationFinder vibration(options.extract);
  for (const StoredShot& s : shots) {
    const auto events = store.load_events(s.id);
    std::vector<Waveform> waves;
    if (!s.record_hash.empty()) {
      Record record = store.load_record(s.id);
      record.conditions = s.conditions;
      waves = waveforms(record, options.extract);
      if (events && s.kind == ShotKind::measured) vibration.add(s.number + 1, record, *events);
    }
    // judged anew by the plan that is stored, so that a store of an earlier program says what is known today
    Judgement judged{s.outcome, s.reason};
    if (events && measured(s.outcome)) {
      judged = judge_shot(*events, s.conditions, options);
      if (judged.reason.empty() && judged.outcome == Outcome::not_judged) judged.reason = s.reason;
    }
    if (s.kind == ShotKind::measured)
      input.shots.push_back({.index = s.number + 1,
                             .conditions = s.conditions,
                             .outcome = judged.outcome,
                             .reason = judged.reason,
                             .events = events,
                             .waveforms = std::move(waves),
                             .record_hash = s.record_hash});
    else if (events)
      input.simulated.push_back(
          {.closing_angle = radians(s.angle_deg), .events = *events, .waveforms = std::move(waves)});
  }
  input.vibration = vibration.finish();
  input.comparison = compare_stored(store, c);
  return input;
}

}  // namespace powbench::host
