#include "host/serve/documents.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/quantities.h"
#include "host/export/csv.h"
#include "host/gather/gather.h"
#include "host/report/closing_json.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

Json number(double x) {
  return std::isfinite(x) ? Json(x) : Json(nullptr);
}
Json measured_json(const Measured& m) {
  return {{"value", number(m.value)}, {"u", number(m.u)}};
}
std::string text(const Json& j) {
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json quantities_json(const std::optional<Events>& events) {
  Json out = Json::object();
  for (const Quantity& q : quantity_table)
    out[std::string(q.symbol)] = measured_json(events ? q.of(*events) : Measured{});
  return out;
}

/// The simulation beside a measured shot.
std::optional<StoredShot> beside(const Store& store, const StoredShot& shot) {
  if (shot.kind == ShotKind::measured)
    for (const StoredShot& s : store.shots(shot.campaign, ShotKind::simulated))
      if (same_angle(radians(s.angle_deg), radians(shot.angle_deg))) return s;
  return std::nullopt;
}

}  // namespace

std::string campaigns_document(const Store& store) {
  Json list = Json::array();
  for (const CampaignInfo& c : store.campaigns()) {
    std::size_t measured_shots = 0, outside = 0;
    for (const auto& [outcome, count] : store.outcomes(c.id, ShotKind::measured)) {
      measured_shots += count;
      if (outcome == Outcome::fail) outside = count;
    }
    list.insert(list.begin(), Json{{"id", c.id},
                                   {"name", c.name},
                                   {"created", c.created},
                                   {"origin", name(c.origin)},
                                   {"rig", c.rig_identity},
                                   {"specimen", stored_specimen(c).name},
                                   {"shots", measured_shots},
                                   {"outside_limits", outside},
                                   {"finished", c.finished}});
  }
  return text(list);
}

std::string shots_document(const Store& store, const CampaignInfo& campaign) {
  Json list = Json::array();
  for (const StoredShot& s : store.shots(campaign.id)) {
    const auto events = store.load_events(s.id);
    list.push_back({{"id", s.id},
                    {"kind", name(s.kind)},
                    {"angle_deg", number(s.angle_deg)},
                    {"reached_rad", measured_json(events ? events->coil.closing_angle : Measured{})},
                    {"outcome", name(s.outcome)},
                    {"reason", s.reason},
                    {"started", s.started},
                    {"quantities", quantities_json(events)}});
  }
  return text({{"campaign", campaign.id},
               {"name", campaign.name},
               {"origin", name(campaign.origin)},
               {"shots", list}});
}

std::string shot_document(const Store& store, const StoredShot& shot) {
  const CampaignInfo campaign = store.campaign(shot.campaign);
  const auto events = store.load_events(shot.id);
  const auto simulated = beside(store, shot);
  const auto predicted = simulated ? store.load_events(simulated->id) : std::nullopt;
  Json rows = Json::array();
  for (const Quantity& q : quantity_table) {
    const Measured m = events ? q.of(*events) : Measured{}, p = predicted ? q.of(*predicted) : Measured{};
    rows.push_back({{"symbol", q.symbol},
                    {"unit", q.unit},
                    {"meaning", q.meaning},
                    {"value", number(m.value)},
                    {"u", number(m.u)},
                    {"simulated", number(p.value)}});
  }
  return text({{"id", shot.id},
               {"campaign", shot.campaign},
               {"kind", name(shot.kind)},
               {"origin", name(shot.kind == ShotKind::simulated ? Origin::simulation : campaign.origin)},
               {"angle_deg", number(shot.angle_deg)},
               {"reached_rad", measured_json(events ? events->coil.closing_angle : Measured{})},
               {"supply_volts", number(shot.conditions.supply_volts)},
               {"mains_hertz", number(shot.conditions.mains_hertz)},
               {"hold_time_s", number(shot.conditions.hold_time)},
               {"started", shot.started},
               {"outcome", name(shot.outcome)},
               {"reason", shot.reason},
               {"has_record", !shot.record_hash.empty()},
               {"quantities", rows}});
}

std::string closing_document(const Store& store, const StoredShot& shot) {
  const std::string all = closings_json(gather_shot(store, shot.id));
  return all.empty() ? "[]" : all;
}

std::string waveforms_document(const Store& store, const StoredShot& shot) {
  return to_csv(store.load_record(shot.id));
}

std::string report_document(const Store& store, const CampaignInfo& campaign) {
  return render_html(gather_report(store, campaign, "the live bench"));
}

}  // namespace powbench::host
