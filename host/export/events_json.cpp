#include "host/export/events_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/units.h"
#include "dsp/events/coil.h"
#include "dsp/events/core_seat.h"
#include "host/store/json.h"

namespace powbench::host {

namespace {

using Json = nlohmann::ordered_json;

Json flags_json(std::uint32_t flags) {
  Json list = Json::array();
  const std::string names = flag_names(flags);
  for (std::size_t at = 0; at < names.size();) {
    const std::size_t end = std::min(names.find(", ", at), names.size());
    list.push_back(names.substr(at, end - at));
    at = end + 2;
  }
  return list;
}

Json train_json(const ContactTrain& t, std::uint32_t all) {
  Json contacts = Json::array();
  for (const Contact& c : t.contacts)
    contacts.push_back({{"touch_s", json_of<Json>(c.touch.value)},
                        {"u_touch_s", json_of<Json>(c.touch.u)},
                        {"release_s", json_of<Json>(c.release.value)},
                        {"u_release_s", json_of<Json>(c.release.u)},
                        {"peak", json_of<Json>(c.peak.value)},
                        {"impulse", json_of<Json>(c.impulse.value)},
                        {"flags", flags_json(c.flags | t.flags | all)},
                        {"probability", json_of<Json>(c.probability)}});
  return {{"shows", name(t.shows)},
          {"reason", t.reason.empty() ? Json(nullptr) : Json(t.reason)},
          {"contacts", contacts},
          {"settled_s", json_of<Json>(t.settled.value)},
          {"u_settled_s", json_of<Json>(t.settled.u)},
          {"bounce_time_s", json_of<Json>(t.bounce_time.value)},
          {"resolution_s", t.present ? json_of<Json>(t.resolution) : Json(nullptr)}};
}

}  // namespace

std::string to_events_json(const Events& e, const Record& record, int indent, const dsp::ExtractOptions& o) {
  const std::uint32_t all = e.flags & flag_no_calibration;
  Json channels = Json::object();
  for (const auto& [channel, train] : {std::pair{Channel::pvdf_a, &e.pvdf_a},
                                       {Channel::pvdf_b, &e.pvdf_b},
                                       {Channel::contact_a, &e.contact_voltage}})
    if (record.find(channel)) channels[std::string(info(channel).name)] = train_json(*train, all);
  const CoreEvents& c = e.core;
  const Json core = {
      {"seat_s", json_of<Json>(c.seat.value)},
      {"u_seat_s", json_of<Json>(c.seat.u)},
      {"settled_s", json_of<Json>(c.settled.value)},
      {"u_settled_s", json_of<Json>(c.settled.u)},
      {"bounce_time_s", json_of<Json>(c.bounce_time.value)},
      {"impact_velocity_m_per_s", json_of<Json>(c.impact_velocity.value)},
      {"u_impact_velocity_m_per_s", json_of<Json>(c.impact_velocity.u)},
      {"travel_m", json_of<Json>(c.travel.value)},
      {"u_travel_m", json_of<Json>(c.travel.u)},
      {"resolution_s", c.seat.known() ? json_of<Json>(dsp::core_resolution(o)) : Json(nullptr)},
      {"flags", flags_json(c.flags | all)}};
  Json j = {{"channels", channels},
            {"core", core},
            {"closing_angle_deg", json_of<Json>(degrees(e.coil.closing_angle.value))},
            {"u_closing_angle_deg", json_of<Json>(degrees(e.coil.closing_angle.u))},
            {"no_closing_angle", e.coil.no_angle.empty() ? Json(nullptr) : Json(e.coil.no_angle)}};
  if (dsp::angle_by_coil(e.coil)) j["closing_angle_from"] = info(Channel::coil_voltage).name;
  return j.dump(indent);
}

}  // namespace powbench::host
