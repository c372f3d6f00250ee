#include "host/gather/unlike.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "core/counted.h"
#include "core/phase.h"
#include "dsp/events/extract.h"
#include "host/gather/gather.h"
#include "host/gather/scene.h"

namespace powbench::host {
namespace {

/// Every value asked for, once each.
std::string asked(const std::vector<StoredShot>& shots, double (*value)(const Conditions&),
                  const char* unit) {
  constexpr std::size_t most_named = 4;
  std::set<double> seen;
  bool untold = false;
  for (const StoredShot& s : shots) {
    const double v = std::stod(fmt::format("{:.6g}", value(s.conditions)));
    if (std::isfinite(v))
      seen.insert(v);
    else
      untold = true;
  }
  if (seen.empty()) return "not known";
  const std::string values =
      seen.size() > most_named
          ? fmt::format("{} values from {:g} to {:g}", seen.size(), *seen.begin(), *seen.rbegin())
          : fmt::format("{:g}", fmt::join(seen, ", "));
  return fmt::format("{} {}{}", values, unit, untold ? ", of some not known" : "");
}

}  // namespace

std::vector<std::string> unlike(const Store& store, const CampaignInfo& first, const CampaignInfo& second) {
  std::vector<std::string> lines;
  const auto add = [&](const char* what, const std::string& a, const std::string& b) {
    if (a != b) lines.push_back(fmt::format("{}: {}, then {}", what, a, b));
  };
  const auto specimen = [](const CampaignInfo& c) {
    return fmt::format("{} ({:.8})", stored_specimen(c).name, c.specimen_hash);
  };
  const auto extraction = [](const CampaignInfo& c) {
    return fmt::format("{:.8}", dsp::parameters_hash(run_options(stored_plan(c)).extract));
  };
  const auto a = store.shots(first.id, ShotKind::measured), b = store.shots(second.id, ShotKind::measured);
  const auto condition = [&](const char* what, double (*value)(const Conditions&), const char* unit) {
    add(what, asked(a, value, unit), asked(b, value, unit));
  };
  add("origin", std::string(name(first.origin)), std::string(name(second.origin)));
  add("specimen", specimen(first), specimen(second));
  add("rig", first.rig_identity, second.rig_identity);
  condition(
      "supply voltage", [](const Conditions& c) { return c.supply_volts; }, "V");
  condition(
      "mains frequency", [](const Conditions& c) { return c.mains_hertz; }, "Hz");
  condition(
      "ambient", [](const Conditions& c) { return c.ambient - zero_celsius; }, "degC");
  condition(
      "hold time", [](const Conditions& c) { return c.hold_time * 1e3; }, "ms");
  add("extraction", extraction(first), extraction(second));
  return lines;
}

std::size_t same_records(const Store& store, const CampaignInfo& first, const CampaignInfo& second) {
  std::set<std::string> there;
  for (const StoredShot& s : store.shots(first.id, ShotKind::measured)) there.insert(s.record_hash);
  there.erase("");
  std::size_t count = 0;
  for (const StoredShot& s : store.shots(second.id, ShotKind::measured))
    count += there.contains(s.record_hash) ? 1U : 0U;
  return count;
}

std::string same_records_sentence(const Store& store, const CampaignInfo& first, const CampaignInfo& second) {
  const std::size_t same = same_records(store, first, second);
  if (same == 0) return {};
  const auto simulated = [](const CampaignInfo& c) {
    return c.origin == Origin::simulated_rig || c.origin == Origin::emulated_board;
  };
  return fmt::format("{} of the second campaign {}, bit for bit: {}, so their agreement says nothing",
                     counted(same, "shot"),
                     same == 1 ? "holds a record of the first" : "hold the records of the first",
                     simulated(first) && simulated(second) ? "simulated with one seed" : "the same record");
}

}  // namespace powbench::host
