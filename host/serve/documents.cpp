#include "host/serve/documents.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/phase.h"
#include "core/quantities.h"
#include "host/compare/compare.h"
#include "host/compare/pair.h"
#include "host/export/csv.h"
#include "host/export/events_json.h"
#include "host/gather/gather.h"
#include "host/gather/pair_json.h"
#include "host/gather/pdf.h"
#include "host/gather/shown.h"
#include "host/gather/unlike.h"
#include "host/plan/expand.h"
#include "host/report/closing_json.h"
#include "host/serve/frame.h"
#include "host/store/json.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

std::string text(const Json& j) {
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// One closing against the simulation of its angle, by the rule of the report; simulated values at the angle, voltage
/// and frequency that this closing reached, where it was simulated under these.
struct Difference : ComparisonRow {
  bool own = false;  ///< simulated at the conditions of this closing, not at those of its angle
};
std::map<std::string, Difference> differences(const Store& store, const StoredShot& shot,
                                              const Events& measured, const Events& simulated,
                                              const StoredShot& simulation) {
  const InputSpread spread = store.prediction(simulation.id);
  AngleGroup group{radians(shot.angle_deg), {measured}, {simulated}, spread.u};
  std::map<std::string, Difference> rows;
  for (ComparisonRow& row : compare({group}, {}, {}).rows) {
    Difference r{std::move(row)};
    if (const auto moved = spread.moved.find(shot.number); moved != spread.moved.end())
      if (const auto by = moved->second.find(r.quantity);
          by != moved->second.end() && std::isfinite(by->second))
        r.simulated += by->second, r.own = true;
    rows[r.quantity] = std::move(r);
  }
  return rows;
}

/// The simulation beside a measured shot.
std::optional<StoredShot> beside(const Store& store, const StoredShot& shot) {
  if (shot.kind == ShotKind::measured)
    for (const StoredShot& s : store.shots(shot.campaign, ShotKind::simulated))
      if (same_angle(radians(s.angle_deg), radians(shot.angle_deg))) return s;
  return std::nullopt;
}

}  // namespace

CampaignFacts::Facts CampaignFacts::of(const CampaignInfo& c) {
  const std::string key = c.plan_hash + c.specimen_hash;
  const std::scoped_lock lock(mutex_);
  const auto known = known_.find(key);
  if (known != known_.end() && !key.empty()) return known->second;
  const Plan plan = stored_plan(c);
  const bool planned = plan.order != Order::by_hand;
  Facts facts{stored_specimen(c).name, plan.angles, planned, plan.test, {}};
  if (planned)
    for (const PlannedShot& shot : expand(plan))
      facts.shots.push_back(stored_degrees(effective_angle(shot.conditions)));
  return known_[key] = facts;
}

/// What a person may remember of a campaign: the words of its test record, annotations included.
std::string test_words(const Store& store, const CampaignInfo& c, const TestRecord& planned) {
  std::string words;
  for (const RecordField& f : record_fields) words += planned.*f.place + " ";
  for (const std::string& instrument : planned.instruments) words += instrument + " ";
  for (const Annotation& a : store.annotations(c.id)) words += a.text + " ";
  return words;
}

/// Closing angles of a plan's shots that have no record yet, and how many of each.
Json missing_json(const Store& store, const CampaignInfo& c, const CampaignFacts::Facts& facts) {
  std::map<double, int> missing;
  for (const double angle : facts.shots) ++missing[angle];
  for (const StoredShot& s : recorded_shots(store, c.id))
    if (s.number >= 0 && static_cast<std::size_t>(s.number) < facts.shots.size())
      --missing[facts.shots[static_cast<std::size_t>(s.number)]];
  Json list = Json::array();
  for (const auto& [angle, n] : missing)
    if (n > 0) list.push_back({{"angle_deg", angle}, {"shots", n}});
  return list;
}

std::string campaigns_document(const Store& store, CampaignFacts& facts) {
  Json list = Json::array();
  for (const CampaignInfo& c : store.campaigns()) {
    std::size_t measured_shots = 0, outside = 0;
    Json outcomes = Json::object(), angles = Json::array();
    const CampaignFacts::Facts known = facts.of(c);
    std::set<double> own;  // single closings have no planned ones
    if (known.planned)
      for (const double a : known.angles) own.insert(stored_degrees(a));
    else
      for (const StoredShot& s : store.shots(c.id, ShotKind::measured))
        if (std::isfinite(s.angle_deg)) own.insert(s.angle_deg);
    for (const double a : own) angles.push_back(json_of<Json>(a));
    for (const auto& [outcome, count] : store.outcomes(c.id, ShotKind::measured)) {
      measured_shots += count;
      outcomes[std::string(name(outcome))] = count;
      if (outcome == Outcome::fail) outside = count;
    }
    const bool resumable = known.planned && !c.finished;
    list.insert(list.begin(), Json{{"id", c.id},
                                   {"name", c.name},
                                   {"created", c.created},
                                   {"origin", name(c.origin)},
                                   {"rig", c.rig_identity},
                                   {"specimen", known.specimen},
                                   {"test", test_words(store, c, known.test)},
                                   {"angles_deg", angles},
                                   {"shots", measured_shots},
                                   {"planned_shots", known.shots.size()},
                                   {"outcomes", outcomes},
                                   {"outside_limits", outside},
                                   {"finished", c.finished},
                                   {"resumable", resumable},
                                   {"missing", resumable ? missing_json(store, c, known) : Json::array()}});
  }
  return text(list);
}

std::string shots_document(const Store& store, const CampaignInfo& campaign, std::int64_t after) {
  Json list = Json::array();
  for (const StoredShot& s : after > 0 ? store.shots_after(campaign.id, after) : store.shots(campaign.id)) {
    const Shown shown(store, s);
    list.push_back(
        {{"id", s.id},
         {"kind", name(s.kind)},
         {"angle_deg", json_of<Json>(s.angle_deg)},
         {"reached_rad", json_of<Json>(shown.events ? shown.events->coil.closing_angle : Measured{})},
         {"outcome", name(s.outcome)},
         {"reason", s.reason},
         {"started", s.started},
         {"quantities", shown.json<Json>()}});
  }
  return text({{"campaign", campaign.id},
               {"name", campaign.name},
               {"origin", name(campaign.origin)},
               {"shots", list}});
}

std::string shots_table(const Store& store, const CampaignInfo& campaign) {
  std::string out = fmt::format(
      "# {}, campaign {}; SI units, times in s after switch-on; u_: standard uncertainty (k = 1), in the "
      "unit of its quantity\n",
      name(campaign.origin), campaign.id);
  for (const Quantity& q : quantity_table) out += fmt::format("# {}: {}\n", q.symbol, q.meaning);
  out += "shot,kind,angle_deg,started,outcome";
  for (const Quantity& q : quantity_table) out += fmt::format(",{}_{},u_{}", q.symbol, q.unit, q.symbol);
  out += "\n";
  const auto cell = [](double x) { return std::isfinite(x) ? fmt::format("{:.9g}", x) : std::string(); };
  for (const StoredShot& s : store.shots(campaign.id)) {
    const Shown shown(store, s);
    out += fmt::format("{},{},{},{},{}", s.id, name(s.kind), cell(s.angle_deg), s.started, name(s.outcome));
    for (const Quantity& q : quantity_table) {
      const Measured m = shown.of(q);
      out += "," + cell(m.value) + "," + cell(m.u);
    }
    out += "\n";
  }
  return out;
}

namespace {

/// Where the mains stood when the contacts touched: the angle of the voltage step, and 2 pi f later by the time from
/// there; t counts from the gate edge. At the frequency found, else at the one asked for. u from those of both.
Measured touch_angle(const Events& e, double asked_hertz) {
  const Measured a = e.coil.closing_angle, t = find_quantity("t_ct1")->of(e);
  const double omega = 2 * pi * (e.coil.mains_hertz.known() ? e.coil.mains_hertz.value : asked_hertz);
  const double angle = a.value + omega * (t.value - e.coil.switch_on.value);
  if (!std::isfinite(angle)) return {};
  return {wrap_turn(angle), std::hypot(a.u, omega * t.u)};
}

/// The openings that the bounce time holds. `hangs_on`: it ends with openings so short that the channel only just
/// resolves them (up to twice `resolution_s`), and what it would be without these.
Json bounce_json(const Events& e) {
  const ContactTrain& t = timing_train(e);
  Json openings = Json::array(), hangs_on;
  const auto length = [&](std::size_t i) {
    return t.contacts[i + 1].touch.value - t.contacts[i].release.value;
  };
  for (std::size_t i = 0; i + 1 < t.contacts.size(); ++i)
    openings.push_back(
        {{"begin_s", json_of<Json>(t.contacts[i].release.value)}, {"length_s", json_of<Json>(length(i))}});
  std::size_t last = t.contacts.size();
  double longest = 0;
  for (; last > 1 && length(last - 2) < 2.01 * t.resolution; --last)
    longest = std::max(longest, length(last - 2));
  if (last < t.contacts.size())
    hangs_on = {
        {"openings", t.contacts.size() - last},
        {"longest_s", longest},
        {"without_s", json_of<Json>(t.contacts[last - 1].touch.value - t.contacts.front().touch.value)}};
  return {{"resolution_s", json_of<Json>(t.resolution)}, {"openings", openings}, {"hangs_on", hangs_on}};
}

}  // namespace

std::string shot_document(const Store& store, const StoredShot& shot) {
  const CampaignInfo campaign = store.campaign(shot.campaign);
  const auto events = store.load_events(shot.id);
  const auto simulated = beside(store, shot);
  const auto predicted = simulated ? store.load_events(simulated->id) : std::nullopt;
  std::map<std::string, Difference> compared;
  if (events && predicted) compared = differences(store, shot, *events, *predicted, *simulated);
  const Shown shown(store, shot);
  Json rows = Json::array();
  for (const Quantity& q : quantity_table) {
    const Measured m = shown.of(q);
    const Difference row =
        compared.contains(std::string(q.symbol)) ? compared.at(std::string(q.symbol)) : Difference{};
    // what is not known of the simulation is no zero: against a value without its U nothing is judged
    const bool judged = std::isfinite(row.u_simulated);
    const double over_U = judged ? row.difference_over_U() : unknown;
    const double expected = !compared.empty() ? row.simulated : predicted ? q.of(*predicted).value : unknown;
    rows.push_back({{"symbol", q.symbol},
                    {"unit", q.unit},
                    {"meaning", q.meaning},
                    {"value", json_of<Json>(m.value)},
                    {"u", json_of<Json>(m.u)},
                    {"simulated", json_of<Json>(expected)},
                    {"simulated_u", json_of<Json>(row.u_simulated)},
                    {"simulated_own", row.own},
                    {"simulated_of_angle", json_of<Json>(predicted ? q.of(*predicted).value : unknown)},
                    {"over_U", json_of<Json>(over_U)},
                    {"agreement", !events && shot.kind == ShotKind::measured ? "not measured"
                                  : judged || !std::isfinite(expected)       ? agreement(over_U)
                                  : row.u_simulated_unknown                  ? "simulated U not known"
                                                                             : "no simulated U yet"}});
  }
  return text(
      {{"id", shot.id},
       {"campaign", shot.campaign},
       {"kind", name(shot.kind)},
       {"origin", name(shot.kind == ShotKind::simulated ? Origin::simulation : campaign.origin)},
       {"angle_deg", json_of<Json>(shot.angle_deg)},
       {"reached_rad", json_of<Json>(events ? events->coil.closing_angle : Measured{})},
       {"touch_rad", json_of<Json>(events ? touch_angle(*events, shot.conditions.mains_hertz) : Measured{})},
       {"supply_volts", json_of<Json>(shot.conditions.supply_volts)},
       {"mains_hertz", json_of<Json>(shot.conditions.mains_hertz)},
       {"hold_time_s", json_of<Json>(shot.conditions.hold_time)},
       {"reached_volts", json_of<Json>(events ? events->coil.supply_volts : Measured{})},
       {"reached_hertz", json_of<Json>(events ? events->coil.mains_hertz : Measured{})},
       {"simulated_basis", simulated ? Json(simulation_basis(*simulated)) : Json(nullptr)},
       {"bounce", events ? bounce_json(*events) : Json(nullptr)},
       {"bounce_simulated", predicted ? bounce_json(*predicted) : Json(nullptr)},
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

namespace {

std::string origin_of(const Store& store, const StoredShot& shot) {
  return std::string(
      name(shot.kind == ShotKind::simulated ? Origin::simulation : store.campaign(shot.campaign).origin));
}

}  // namespace

std::string waveforms_document(const Store& store, const StoredShot& shot) {
  Record record = store.load_record(shot.id);
  record.conditions = shot.conditions;
  std::string head = fmt::format("# {}, campaign {}, {} shot {}\n", origin_of(store, shot), shot.campaign,
                                 name(shot.kind), shot.id);
  for (const ChannelRecord& c : record.channels)
    head += fmt::format("# {}: {}\n", info(c.channel).name, info(c.channel).meaning);
  return head + to_csv(record);
}

std::string events_document(const Store& store, const StoredShot& shot) {
  const auto events = store.load_events(shot.id);
  if (!events) return "null";
  Json out = {{"origin", origin_of(store, shot)},
              {"campaign", shot.campaign},
              {"shot", shot.id},
              {"kind", name(shot.kind)},
              {"u_of_events", u_of_events(shot.kind)}};
  out["events"] = Json::parse(to_events_json(*events, store.load_record(shot.id)));
  return text(out);
}

std::string frame_document(const Store& store, const StoredShot& shot) {
  return record_frame(store.load_record(shot.id), shot.id, origin_of(store, shot));
}

std::string pair_document(const Store& store, const CampaignInfo& first, const CampaignInfo& second) {
  const Json rows =
      Json::parse(pair_json(compare_pair(compare_stored(store, first), compare_stored(store, second))));
  const auto who = [](const CampaignInfo& c) {
    return Json{{"id", c.id}, {"name", c.name}, {"origin", name(c.origin)}, {"created", c.created}};
  };
  return text({{"first", who(first)},
               {"second", who(second)},
               {"rows", rows},
               {"unlike", unlike(store, first, second)},
               {"same_records", same_records(store, first, second)},
               {"same_records_sentence", same_records_sentence(store, first, second)}});
}

std::string junit_document(const Store& store, const CampaignInfo& campaign) {
  return render_junit(gather_report(store, campaign, "the live bench"));
}

std::string report_pdf(const Store& store, const CampaignInfo& campaign) {
  static std::mutex printer;
  const std::scoped_lock one(printer);
  namespace fs = std::filesystem;
  std::string folder = (fs::temp_directory_path() / "powbench-pdf-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) throw StoreError(folder + ": cannot be made");
  struct Away {
    ~Away() {
      std::error_code ignored;
      fs::remove_all(folder, ignored);
    }
    fs::path folder;
  } const away{folder};
  std::ofstream(away.folder / "report.html", std::ios::binary) << report_document(store, campaign);
  print_pdf(away.folder / "report.html", away.folder / "report.pdf");
  std::ifstream in(away.folder / "report.pdf", std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string report_document(const Store& store, const CampaignInfo& campaign) {
  return render_html(gather_report(store, campaign, "the live bench"));
}

}  // namespace powbench::host
