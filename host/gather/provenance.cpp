#include "host/gather/provenance.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <tuple>

#include "core/phase.h"
#include "rigs/sealed_shot.h"

namespace powbench::host {

namespace {

/// The calibration that was in force; from the seal, so that not every sample is read for one word.
std::string calibration_under(const Store& store, const StoredShot& shot) {
  if (const std::string text = store.sealed_text(shot.id); !text.empty()) {
    try {
      return rigs::parse_sealed_shot(text).calibration;
    } catch (const rigs::SealError&) {  // of an earlier firmware
    }
  }
  return store.load_record(shot.id).calibration;
}

/// Shots that were fired one after the other under one calibration.
struct Run {
  std::string calibration;
  std::int64_t first = 0, last = 0;  ///< shots
  std::string day;                   ///< of the last
};

std::vector<Run> runs_of(const Store& store, const std::vector<StoredShot>& fired) {
  std::vector<Run> runs;
  for (const StoredShot& s : fired) {
    if (s.kind != ShotKind::measured || s.record_hash.empty()) continue;
    const std::string id = calibration_under(store, s);
    if (runs.empty() || runs.back().calibration != id) runs.push_back({id, s.id, s.id, ""});
    runs.back().last = s.id;
    runs.back().day = s.started.substr(0, 10);
  }
  return runs;
}

}  // namespace

Provenance rig_provenance(const Store& store, const std::vector<StoredShot>& fired) {
  Provenance p;
  for (const StoredShot& s : fired) {
    if (s.kind != ShotKind::measured) continue;
    p.finished = std::max(p.finished, s.started);
    if (s.record_hash.empty() || !p.firmware.empty()) continue;
    p.firmware = store.load_record(s.id).firmware;
  }
  for (const Run& run : runs_of(store, fired)) {
    auto of = std::find_if(p.calibrations.begin(), p.calibrations.end(),
                           [&](const CalibrationUse& c) { return c.id == run.calibration; });
    if (of == p.calibrations.end()) of = p.calibrations.insert(of, {run.calibration, "", ""});
    of->shots += fmt::format("{}{}", of->shots.empty() ? "" : ", ", run.first);
    if (run.last != run.first) of->shots += fmt::format(" to {}", run.last);
    of->last_day = std::max(of->last_day, run.day);
  }
  return p;
}

std::vector<StoredShot> by_firing(std::vector<StoredShot> shots) {
  std::sort(shots.begin(), shots.end(), [](const StoredShot& a, const StoredShot& b) {
    return std::tie(a.kind, a.started, a.id) < std::tie(b.kind, b.started, b.id);
  });
  return shots;
}

std::map<int, std::vector<Outcome>> earlier_outcomes(const Store& store, std::int64_t campaign) {
  std::map<int, std::vector<Outcome>> earlier;
  for (const StoredShot& s : store.earlier_attempts(campaign))
    if (s.kind == ShotKind::measured) earlier[s.number].push_back(s.outcome);
  return earlier;
}

double phase_deviation(const Store& store, const StoredShot& shot) {
  constexpr double untold = std::numeric_limits<double>::quiet_NaN();
  const std::string text = shot.record_hash.empty() ? std::string() : store.sealed_text(shot.id);
  if (text.empty()) return untold;
  try {
    const rigs::SealedShot sealed = rigs::parse_sealed_shot(text);
    return sealed.complete() ? radians(static_cast<double>(sealed.angle_u_mdeg) * 1e-3) : untold;
  } catch (const rigs::SealError&) {
    return untold;  // of an earlier firmware
  }
}

}  // namespace powbench::host
