#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/config/test_record.h"
#include "host/serve/calls.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

Store reader(const Call& c) {
  return Store(c.bench.database(), Store::Mode::read_only);
}
CampaignInfo campaign_of(const Store& store, std::int64_t id) {
  for (CampaignInfo& info : store.campaigns())
    if (info.id == id) return info;
  throw Problem{404, fmt::format("there is no campaign {}", id)};
}
StoredShot shot_of(const Store& store, std::int64_t id) {
  try {
    return store.shot(id);
  } catch (const StoreError&) {
    throw Problem{404, fmt::format("there is no shot {}", id)};
  }
}
StoredShot recorded_shot(const Store& store, std::int64_t id) {
  StoredShot s = shot_of(store, id);
  if (s.record_hash.empty()) throw Problem{404, fmt::format("shot {} has no record", id)};
  return s;
}
Reply to_take_along(const char* type, std::string name, std::string body) {
  Reply r;
  r.type = type;
  r.file = std::move(name);
  r.body = std::move(body);
  return r;
}

Reply get_campaigns(const Call& c) {
  return json_reply(campaigns_document(reader(c), c.facts));
}
Reply get_shots(const Call& c) {
  const Store store = reader(c);
  return json_reply(shots_document(store, campaign_of(store, c.id), number_of_query(c, "after")));
}
Reply get_shots_table(const Call& c) {
  const Store store = reader(c);
  return to_take_along("text/csv; charset=utf-8", fmt::format("campaign-{}.csv", c.id),
                       shots_table(store, campaign_of(store, c.id)));
}
Reply get_report(const Call& c) {
  const Store store = reader(c);
  Reply r;
  r.type = "text/html; charset=utf-8";
  r.policy = report_policy;
  r.body = report_document(store, campaign_of(store, c.id));
  return r;
}
Reply get_report_pdf(const Call& c) try {
  const Store store = reader(c);
  return to_take_along("application/pdf", fmt::format("report-{}.pdf", c.id),
                       report_pdf(store, campaign_of(store, c.id)));
} catch (const BadInput& e) {
  throw Problem{501, e.what()};
}
Reply get_junit(const Call& c) {
  const Store store = reader(c);
  return to_take_along("application/xml", fmt::format("junit-{}.xml", c.id),
                       junit_document(store, campaign_of(store, c.id)));
}
Reply get_comparison(const Call& c) {
  for (const char* which : {"first", "second"})
    if (number_of_query(c, which) == 0)
      throw Problem{
          400,
          fmt::format("'{}' is missing: a campaign's number, as in /api/compare?first=1&second=2", which)};
  if (number_of_query(c, "first") == number_of_query(c, "second"))
    throw Problem{400, "'first' and 'second' are the same campaign: there is nothing to compare"};
  const Store store = reader(c);
  return json_reply(pair_document(store, campaign_of(store, number_of_query(c, "first")),
                                  campaign_of(store, number_of_query(c, "second"))));
}
Reply get_annotations(const Call& c) {
  const Store store = reader(c);
  Json list = Json::array();
  for (const Annotation& a : store.annotations(campaign_of(store, c.id).id))
    list.push_back({{"created", a.created}, {"key", a.key}, {"text", a.text}});
  return json_reply(list.dump(-1, ' ', false, Json::error_handler_t::replace));
}
Reply post_annotation(const Call& c) {
  const std::string key = text_of(c.body, "key", 40), what = text_of(c.body, "text", 2000);
  Store store(c.bench.database());
  const CampaignInfo campaign = campaign_of(store, c.id);
  refuse_line(key, what, campaign.origin == Origin::import);
  store.annotate(campaign.id, key, what);
  return json_reply(Json{{"key", key}, {"text", what}}.dump(-1, ' ', false, Json::error_handler_t::replace),
                    201);
}

Reply post_resume(const Call& c) {
  c.bench.resume(campaign_of(reader(c), c.id), c.request.received);
  return json_reply(R"({"started":true})", 202);
}

Reply get_shot(const Call& c) {
  const Store store = reader(c);
  return json_reply(shot_document(store, shot_of(store, c.id)));
}
Reply get_closing(const Call& c) {
  const Store store = reader(c);
  const StoredShot shot = shot_of(store, c.id);
  return json_reply(shot.record_hash.empty() ? "[]" : closing_document(store, shot));
}
Reply get_waveforms(const Call& c) {
  const Store store = reader(c);
  return to_take_along("text/csv; charset=utf-8", fmt::format("shot-{}.csv", c.id),
                       waveforms_document(store, recorded_shot(store, c.id)));
}
Reply get_events(const Call& c) {
  const Store store = reader(c);
  return to_take_along("application/json", fmt::format("shot-{}.json", c.id),
                       events_document(store, recorded_shot(store, c.id)));
}
Reply get_record(const Call& c) {
  const Store store = reader(c);
  Reply r;
  r.type = "application/octet-stream";
  r.body = frame_document(store, recorded_shot(store, c.id));
  return r;
}

constexpr Route of_documents[] = {
    {"GET", "/api/campaigns", Right::read, "All campaigns of the store, the newest first.", "",
     R"([{"id": 1, "name": "", "created": "", "origin": "", "rig": "", "specimen": "", "test": "",
           "angles_deg": [0], "shots": 1,
          "planned_shots": 0, "outcomes": {}, "outside_limits": 0, "finished": true, "resumable": true,
          "missing": [{"angle_deg": 0, "shots": 1}]}])",
     get_campaigns},
    {"GET",
     "/api/campaigns/{id}/shots",
     Right::read,
     "Shots of a campaign with their quantities and u; with `after` those whose number in the store is "
     "larger.",
     "",
     R"({"campaign": 1, "name": "", "origin": "", "shots": [{"id": 1, "kind": "", "angle_deg": 0,
           "reached_rad": {"value": 0, "u": 0},
          "outcome": "", "reason": "", "started": "", "quantities": {}}]})",
     get_shots,
     {"after"}},
    {"GET", "/api/campaigns/{id}/shots.csv", Right::read, "The same as a table.", "", "text/csv",
     get_shots_table},
    {"GET", "/api/campaigns/{id}/report.html", Right::read, "The report.", "", "text/html", get_report},
    {"GET", "/api/campaigns/{id}/report.pdf", Right::read,
     "The report on paper; 501 where no browser is installed to print it.", "", "application/pdf",
     get_report_pdf},
    {"GET", "/api/campaigns/{id}/junit.xml", Right::read, "Its verdicts for machines.", "", "application/xml",
     get_junit},
    {"GET", "/api/campaigns/{id}/annotations", Right::read, "What was learned later.", "",
     R"([{"created": "", "key": "", "text": ""}])", get_annotations},
    {"POST", "/api/campaigns/{id}/resume", Right::fire,
     "Fires what is missing of a campaign whose plan was not fired to its end.", "{}", R"({"started": true})",
     post_resume},
    {"POST", "/api/campaigns/{id}/annotations", Right::fire, "Adds to the test record.",
     R"({"key": "remarks", "text": "coil was warm"})", R"({"key": "", "text": ""})", post_annotation},
    {"GET",
     "/api/compare",
     Right::read,
     "Campaign `second` against campaign `first`, each difference over its U.",
     "",
     R"({"first": {}, "second": {}, "rows": [{"quantity": "", "unit": "", "closing_angle_deg": 0, "n": [1],
          "first": {"value": 0, "u": 0, "U": 0}, "second": {"value": 0, "u": 0, "U": 0}, "difference": 0,
          "U": 0, "over_U": 0, "agreement": ""}], "unlike": [""], "same_records": 0,
          "same_records_sentence": ""})",
     get_comparison,
     {"first", "second"}},
    {"GET", "/api/shots/{id}", Right::read,
     "One shot: conditions, outcome, quantities with u, simulated ones.", "",
     R"({"id": 1, "campaign": 1, "kind": "", "origin": "", "angle_deg": 0, "reached_rad": {"value": 0, "u": 0},
          "touch_rad": {"value": 0, "u": 0}, "supply_volts": 0, "mains_hertz": 0, "hold_time_s": 0,
          "reached_volts": {"value": 0, "u": 0}, "reached_hertz": {"value": 0, "u": 0}, "simulated_basis": "",
          "bounce": {}, "bounce_simulated": {}, "started": "", "outcome": "",
          "reason": "", "has_record": true, "quantities": [{"symbol": "", "unit": "", "meaning": "", "value": 0, "u": 0,
          "simulated": 0}]})",
     get_shot},
    {"GET", "/api/shots/{id}/closing", Right::read,
     "Its curves, measured and simulated, and marks; none without a record.", "", "[{}]", get_closing},
    {"GET", "/api/shots/{id}/waveforms.csv", Right::read, "Its channels, every sample.", "", "text/csv",
     get_waveforms},
    {"GET", "/api/shots/{id}/events.json", Right::read, "Its events, every one with its u.", "", "{}",
     get_events},
    {"GET", "/api/shots/{id}/record", Right::read,
     "Its counts: 4 bytes, length of the head, little endian; the head as JSON; 16-bit counts, channel "
     "behind channel. The WebSocket "
     "/api/scope sends the newest one in the same form.",
     "", "application/octet-stream", get_record},
};

}  // namespace

std::span<const Route> document_calls() {
  return of_documents;
}

}  // namespace powbench::host
