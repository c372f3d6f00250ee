#include "host/store/rows.h"

#include <chrono>
#include <ctime>

#include "core/quantities.h"
#include "host/store/json.h"
#include "host/store/seal.h"

namespace powbench::host {

using sqlite::Database;
using sqlite::Statement;

namespace {

std::string seal_of(const CampaignInfo& c) {
  Seal seal;
  for (const std::string* text : {&c.created, &c.name, &c.plan, &c.plan_hash, &c.specimen, &c.specimen_hash,
                                  &c.rig_file, &c.rig_uri, &c.rig_identity, &c.program_version})
    seal.add(*text);
  if (c.origin != Origin::unknown) seal.add(name(c.origin));  // rows from before it was kept have none
  return seal.hex();
}

/// Of a campaign from before its origin was kept: what its rig's name can only mean.
Origin origin_of(const CampaignInfo& c) {
  if (c.origin != Origin::unknown) return c.origin;
  if (c.rig_uri.starts_with("sim:")) return Origin::simulated_rig;
  if (c.rig_uri.starts_with("qemu:")) return Origin::emulated_board;
  if (c.rig_uri.starts_with("file:")) return Origin::import;
  return c.rig_uri.empty() ? Origin::simulation : Origin::unknown;
}

/// `conditions`: the JSON as it stands in the row.
std::string seal_of(const StoredShot& s, const std::string& conditions) {
  Seal seal;
  if (s.attempt > 1) seal.add(s.attempt);  // rows from before there were attempts have none
  return seal.add(s.campaign)
      .add(name(s.kind))
      .add(s.number)
      .add(s.repeat)
      .add(s.angle_deg)
      .add(conditions)
      .add(name(s.outcome))
      .add(s.reason)
      .add(s.started)
      .hex();
}

std::string seal_of(const EventsRow& e) {
  return Seal()
      .add(e.record)
      .add(e.method)
      .add(e.parameters_hash)
      .add(e.parameters)
      .add(e.program_version)
      .add(e.events)
      .hex();
}

std::string seal_of(std::int64_t campaign, const Annotation& a) {
  return Seal().add(campaign).add(a.created).add(a.key).add(a.text).hex();
}

struct Digest {
  std::array<Measured, 4> value;  ///< reached, touch, bounce, settled
};

std::string seal_of(std::int64_t shot, std::int64_t events_id, const Digest& d) {
  Seal seal;
  seal.add(shot).add(events_id);
  for (const Measured& m : d.value) seal.add(m.value).add(m.u);
  return seal.hex();
}

Measured quantity(const Events& events, std::string_view symbol) {
  const Quantity* q = find_quantity(symbol);
  return q != nullptr ? q->of(events) : Measured{};
}

/// Everything of a shot but its conditions and its record, from the first eleven columns of `line_columns`.
StoredShot plain_shot(const Statement& s) {
  StoredShot shot;
  shot.id = s.integer(0);
  shot.campaign = s.integer(1);
  shot.kind = s.text(2) == "measured" ? ShotKind::measured : ShotKind::simulated;
  shot.number = static_cast<int>(s.integer(3));
  shot.repeat = static_cast<int>(s.integer(4));
  shot.angle_deg = s.real(5);
  shot.outcome = outcome_from(s.text(7));
  shot.reason = s.text(8);
  shot.started = s.text(9);
  shot.attempt = static_cast<int>(s.integer(11));
  check_seal(seal_of(shot, s.text(6)), s.text(10), "shot " + std::to_string(shot.id));
  return shot;
}
#define POWBENCH_SHOT_COLUMNS                                                                     \
  "shot.id, campaign_id, kind, number, repeat, angle_deg, conditions, outcome, reason, started, " \
  "shot.seal, shot.attempt"

}  // namespace

std::string utc_text(std::chrono::system_clock::time_point when) {
  const std::time_t now = std::chrono::system_clock::to_time_t(when);
  std::tm tm{};
  gmtime_r(&now, &tm);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &tm);
  return text;
}

std::string utc_now() {
  return utc_text(std::chrono::system_clock::now());
}

Origin origin_from(const std::string& word) {
  for (std::size_t i = 0; i < origin_names.size(); ++i)
    if (origin_names[i] == word) return static_cast<Origin>(i);
  return Origin::unknown;
}

Outcome outcome_from(const std::string& word) {
  for (std::size_t i = 0; i < outcome_names.size(); ++i)
    if (outcome_names[i] == word) return static_cast<Outcome>(i);
  throw StoreError("unknown outcome '" + word + "' in the store: the file is damaged");
}

void check_seal(const std::string& expected, const std::string& found, const std::string& what) {
  if (expected != found)
    throw StoreError("the file is damaged: " + what + " does not match its checksum; restore it from a copy");
}

CampaignInfo stored_campaign_row(const Statement& s) {
  CampaignInfo c{.id = s.integer(0),
                 .created = s.text(1),
                 .name = s.text(2),
                 .plan = s.text(3),
                 .plan_hash = s.text(4),
                 .specimen = s.text(5),
                 .specimen_hash = s.text(6),
                 .rig_file = s.text(7),
                 .rig_uri = s.text(8),
                 .rig_identity = s.text(9),
                 .program_version = s.text(10),
                 .finished = s.integer(11) != 0,
                 .origin = origin_from(s.text(13))};
  check_seal(seal_of(c), s.text(12), "campaign " + std::to_string(c.id));
  return c;
}

CampaignInfo campaign_row(const Statement& s) {
  CampaignInfo c = stored_campaign_row(s);
  c.origin = origin_of(c);
  return c;
}

std::int64_t insert_campaign(Database& db, const CampaignInfo& c) {
  Statement(db,
            "INSERT INTO campaign (created, name, plan, plan_hash, specimen, specimen_hash, rig_file, "
            "rig_uri, rig_identity, program_version, finished, origin, seal) "
            "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(c.created)
      .bind(c.name)
      .bind(c.plan)
      .bind(c.plan_hash)
      .bind(c.specimen)
      .bind(c.specimen_hash)
      .bind(c.rig_file)
      .bind(c.rig_uri)
      .bind(c.rig_identity)
      .bind(c.program_version)
      .bind(c.finished ? 1 : 0)
      .bind(c.origin == Origin::unknown ? std::string_view("") : name(c.origin))
      .bind(seal_of(c))
      .run();
  return db.last_id();
}

const std::string last_attempt =
    "shot.attempt = (SELECT max(attempt) FROM shot AS other WHERE other.campaign_id = shot.campaign_id AND "
    "other.kind = shot.kind AND other.number = shot.number) ";
const std::string shot_query =
    "SELECT " POWBENCH_SHOT_COLUMNS ", content_hash FROM shot LEFT JOIN record ON record.shot_id = shot.id ";

StoredShot shot_row(const Statement& s) {
  StoredShot shot = plain_shot(s);
  shot.conditions = stored_json([&] { return conditions_from_json(s.text(6)); });
  shot.record_hash = s.text(12);
  return shot;
}

std::int64_t insert_shot(Database& db, const StoredShot& shot) {
  const std::string conditions = to_json(shot.conditions);
  Statement(
      db,
      "INSERT INTO shot (campaign_id, kind, number, attempt, repeat, angle_deg, conditions, outcome, reason, "
      "started, seal) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(shot.campaign)
      .bind(name(shot.kind))
      .bind(shot.number)
      .bind(shot.attempt)
      .bind(shot.repeat)
      .bind(shot.angle_deg)
      .bind(conditions)
      .bind(name(shot.outcome))
      .bind(shot.reason)
      .bind(shot.started)
      .bind(seal_of(shot, conditions))
      .run();
  return db.last_id();
}

EventsRow events_row(const Statement& s, std::int64_t shot) {
  EventsRow e{s.integer(0), s.integer(1), s.text(2), s.text(3), s.text(4), s.text(5), s.text(6)};
  check_seal(seal_of(e), s.text(7), "events of shot " + std::to_string(shot));
  return e;
}

std::optional<std::int64_t> insert_events(Database& db, const EventsRow& e) {
  Statement(db,
            "INSERT OR IGNORE INTO events (record_id, method, parameters_hash, parameters, "
            "program_version, events, seal) "
            "VALUES (?, ?, ?, ?, ?, ?, ?)")
      .bind(e.record)
      .bind(e.method)
      .bind(e.parameters_hash)
      .bind(e.parameters)
      .bind(e.program_version)
      .bind(e.events)
      .bind(seal_of(e))
      .run();
  if (db.changes() == 0) return std::nullopt;
  return db.last_id();
}

std::array<Measured, 4> digest_values(const Events& e) {
  return {e.coil.closing_angle, quantity(e, "t_ct1"), quantity(e, "t_ct_bon"), quantity(e, "t_ct2")};
}

void write_digest(Database& db, std::int64_t shot, std::int64_t events_id, const Events& e) {
  const Digest d{digest_values(e)};
  Statement s(db, "INSERT OR REPLACE INTO digest VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  s.bind(shot).bind(events_id);
  for (const Measured& m : d.value) s.bind(m.value).bind(m.u);
  s.bind(seal_of(shot, events_id, d)).run();
}

namespace {

/// From eleven columns, the first of which is number `at`.
Digest digest_row(const Statement& s, int at, std::int64_t shot) {
  Digest d;
  for (int i = 0; i < 4; ++i)
    d.value[static_cast<std::size_t>(i)] = {s.real(at + 2 + 2 * i), s.real(at + 3 + 2 * i)};
  check_seal(seal_of(shot, s.integer(at + 1), d), s.text(at + 10),
             "the digest of shot " + std::to_string(shot));
  return d;
}

}  // namespace

std::optional<std::int64_t> digest_of(const Database& db, std::int64_t shot) {
  Statement s(db, "SELECT * FROM digest WHERE shot_id = ?");
  if (!s.bind(shot).step()) return std::nullopt;
  digest_row(s, 0, shot);
  return s.integer(1);
}

std::vector<ShotLine> shot_lines(const Database& db, std::int64_t campaign) {
  std::vector<ShotLine> list;
  Statement s(db, "SELECT " POWBENCH_SHOT_COLUMNS
                  ", digest.* FROM shot LEFT JOIN digest ON digest.shot_id = shot.id WHERE campaign_id = ? "
                  "ORDER BY kind, number, shot.attempt");
  s.bind(campaign);
  while (s.step()) {
    ShotLine line;
    line.shot = plain_shot(s);
    line.digested = s.integer(12) != 0;
    if (line.digested) {
      const Digest d = digest_row(s, 12, line.shot.id);
      line.reached = d.value[0], line.touch = d.value[1], line.bounce = d.value[2], line.settled = d.value[3];
    }
    const bool again = !list.empty() && list.back().shot.kind == line.shot.kind &&
                       list.back().shot.number == line.shot.number;
    if (again)
      list.back() = std::move(line);
    else
      list.push_back(std::move(line));
  }
  return list;
}

void insert_annotation(Database& db, std::int64_t campaign, const Annotation& a) {
  Statement(db, "INSERT INTO annotation (campaign_id, created, key, text, seal) VALUES (?, ?, ?, ?, ?)")
      .bind(campaign)
      .bind(a.created)
      .bind(a.key)
      .bind(a.text)
      .bind(seal_of(campaign, a))
      .run();
}

std::vector<Annotation> select_annotations(const Database& db, std::int64_t campaign) {
  std::vector<Annotation> list;
  Statement s(db, "SELECT created, key, text, seal FROM annotation WHERE campaign_id = ? ORDER BY id");
  s.bind(campaign);
  while (s.step()) {
    list.push_back({s.text(0), s.text(1), s.text(2)});
    check_seal(seal_of(campaign, list.back()), s.text(3),
               "an annotation of campaign " + std::to_string(campaign));
  }
  return list;
}

std::string select_prediction(const Database& db, std::int64_t shot) {
  Statement s(db, "SELECT uncertainty, seal FROM prediction WHERE shot_id = ?");
  if (!s.bind(shot).step()) return {};
  check_seal(Seal().add(shot).add(s.text(0)).hex(), s.text(1),
             "the prediction of shot " + std::to_string(shot));
  return s.text(0);
}

void insert_prediction(Database& db, std::int64_t shot, const std::string& text) {
  Statement(db, "INSERT INTO prediction (shot_id, uncertainty, seal) VALUES (?, ?, ?)")
      .bind(shot)
      .bind(text)
      .bind(Seal().add(shot).add(text).hex())
      .run();
}

}  // namespace powbench::host
