#include "host/store/store.h"

#include <chrono>
#include <ctime>

#include "host/store/hash.h"
#include "host/store/json.h"
#include "host/store/open.h"
#include "host/store/record_rows.h"
#include "host/store/seal.h"

namespace powbench::host {

using sqlite::Database;
using sqlite::Statement;
using sqlite::Transaction;

namespace {

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm tm{};
  gmtime_r(&now, &tm);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &tm);
  return text;
}

Outcome outcome_from(const std::string& word) {
  for (std::size_t i = 0; i < outcome_names.size(); ++i)
    if (outcome_names[i] == word) return static_cast<Outcome>(i);
  throw StoreError("unknown outcome '" + word + "' in the store: the file is damaged");
}

/// Stored JSON that cannot be read is damage, not bad input.
template <class F>
auto stored_json(F&& read) {
  try {
    return read();
  } catch (const std::invalid_argument& e) {
    throw StoreError(std::string("the file is damaged: ") + e.what());
  }
}

constexpr const char* campaign_columns =
    "id, created, name, plan, plan_hash, specimen, specimen_hash, rig_file, rig_uri, rig_identity, "
    "program_version, "
    "finished, seal, origin";

std::string seal_of(const CampaignInfo& c) {
  Seal seal;
  for (const std::string* text : {&c.created, &c.name, &c.plan, &c.plan_hash, &c.specimen, &c.specimen_hash,
                                  &c.rig_file, &c.rig_uri, &c.rig_identity, &c.program_version})
    seal.add(*text);
  if (c.origin != Origin::unknown) seal.add(name(c.origin));  // rows from before it was kept have none
  return seal.hex();
}

Origin origin_from(const std::string& word) {
  for (std::size_t i = 0; i < origin_names.size(); ++i)
    if (origin_names[i] == word) return static_cast<Origin>(i);
  return Origin::unknown;
}

/// Of a campaign from before its origin was kept: what its rig's name can only mean.
Origin origin_of(const CampaignInfo& c) {
  if (c.origin != Origin::unknown) return c.origin;
  if (c.rig_uri.starts_with("sim:")) return Origin::simulated_rig;
  if (c.rig_uri.starts_with("qemu:")) return Origin::emulated_board;
  if (c.rig_uri.starts_with("file:")) return Origin::import;
  return c.rig_uri.empty() ? Origin::simulation : Origin::unknown;
}

std::string seal_of(const StoredShot& s) {
  Seal seal;
  if (s.attempt > 1) seal.add(s.attempt);  // rows from before there were attempts have none
  return seal.add(s.campaign)
      .add(name(s.kind))
      .add(s.number)
      .add(s.repeat)
      .add(s.angle_deg)
      .add(to_json(s.conditions))
      .add(name(s.outcome))
      .add(s.reason)
      .add(s.started)
      .hex();
}

std::string seal_of_events(std::int64_t record, const std::string& method, const std::string& parameters_hash,
                           const std::string& parameters, const std::string& version,
                           const std::string& events) {
  return Seal().add(record).add(method).add(parameters_hash).add(parameters).add(version).add(events).hex();
}

void check_seal(const std::string& expected, const std::string& found, const std::string& what) {
  if (expected != found)
    throw StoreError("the file is damaged: " + what + " does not match its checksum; restore it from a copy");
}

CampaignInfo campaign_row(const Statement& s) {
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
  c.origin = origin_of(c);
  return c;
}

/// Columns of shot_row(); `shot` is the alias of the table. Of all attempts at a shot the last one is the shot.
const std::string last_attempt =
    "shot.attempt = (SELECT max(attempt) FROM shot AS other WHERE other.campaign_id = shot.campaign_id AND "
    "other.kind = shot.kind AND other.number = shot.number) ";
const std::string shot_query =
    "SELECT shot.id, campaign_id, kind, number, repeat, angle_deg, conditions, outcome, reason, started, "
    "content_hash, "
    "shot.seal, shot.attempt FROM shot LEFT JOIN record ON record.shot_id = shot.id ";

StoredShot shot_row(const Statement& s) {
  StoredShot shot{.id = s.integer(0),
                  .campaign = s.integer(1),
                  .kind = s.text(2) == "measured" ? ShotKind::measured : ShotKind::simulated,
                  .number = static_cast<int>(s.integer(3)),
                  .repeat = static_cast<int>(s.integer(4)),
                  .angle_deg = s.real(5),
                  .conditions = stored_json([&] { return conditions_from_json(s.text(6)); }),
                  .outcome = outcome_from(s.text(7)),
                  .reason = s.text(8),
                  .started = s.text(9),
                  .record_hash = s.text(10),
                  .attempt = static_cast<int>(s.integer(12))};
  check_seal(seal_of(shot), s.text(11), "shot " + std::to_string(shot.id));
  return shot;
}

}  // namespace

std::string_view name(ShotKind kind) {
  return kind == ShotKind::measured ? "measured" : "simulated";
}

struct Store::Impl {
  Database db;

  std::optional<std::int64_t> record_of(std::int64_t shot) const {
    Statement s(db, "SELECT id FROM record WHERE shot_id = ?");
    s.bind(shot);
    if (!s.step()) return std::nullopt;
    return s.integer(0);
  }

  void insert_events(std::int64_t record, const Events& e, const ExtractionInfo& info) {
    const std::string text = to_json(e);
    Statement(db,
              "INSERT OR IGNORE INTO events (record_id, method, parameters_hash, parameters, "
              "program_version, events, seal) "
              "VALUES (?, ?, ?, ?, ?, ?, ?)")
        .bind(record)
        .bind(e.method)
        .bind(e.parameters_hash)
        .bind(info.parameters)
        .bind(info.program_version)
        .bind(text)
        .bind(
            seal_of_events(record, e.method, e.parameters_hash, info.parameters, info.program_version, text))
        .run();
  }

  /// The number of the next attempt at this shot; one that gave a valid record has none.
  int next_attempt(const StoredShot& shot) {
    Statement s(db,
                "SELECT outcome, attempt FROM shot WHERE campaign_id = ? AND kind = ? AND number = ? "
                "ORDER BY attempt DESC LIMIT 1");
    s.bind(shot.campaign).bind(name(shot.kind)).bind(shot.number);
    if (!s.step()) return 1;
    const Outcome before = outcome_from(s.text(0));
    if (measured(before))
      throw StoreError("shot " + std::to_string(shot.number) + " is stored already and is not overwritten");
    return static_cast<int>(s.integer(1)) + 1;
  }
};

Store::Store(const std::string& path, Mode mode) : impl_(new Impl{open_store(path, mode)}) {}
Store::~Store() = default;
Store::Store(Store&&) noexcept = default;
Store& Store::operator=(Store&&) noexcept = default;

std::int64_t Store::create_campaign(const CampaignInfo& info) {
  CampaignInfo c = info;
  c.created = utc_now();
  Statement(impl_->db,
            "INSERT INTO campaign (created, name, plan, plan_hash, specimen, specimen_hash, rig_file, "
            "rig_uri, rig_identity, "
            "program_version, origin, seal) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
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
      .bind(c.origin == Origin::unknown ? std::string_view("") : name(c.origin))
      .bind(seal_of(c))
      .run();
  return impl_->db.last_id();
}

void Store::set_finished(std::int64_t campaign, bool finished) {
  Statement(impl_->db, "UPDATE campaign SET finished = ? WHERE id = ?")
      .bind(finished ? 1 : 0)
      .bind(campaign)
      .run();
}

std::vector<CampaignInfo> Store::campaigns() const {
  std::vector<CampaignInfo> list;
  Statement s(impl_->db, std::string("SELECT ") + campaign_columns + " FROM campaign ORDER BY id");
  while (s.step()) list.push_back(campaign_row(s));
  return list;
}

CampaignInfo Store::campaign(std::optional<std::int64_t> id) const {
  Statement s(impl_->db, std::string("SELECT ") + campaign_columns +
                             " FROM campaign WHERE ?1 < 0 OR id = ?1 ORDER BY id DESC LIMIT 1");
  s.bind(id.value_or(-1));
  if (s.step()) return campaign_row(s);
  throw WrongStore(impl_->db.path() + ": " +
                   (id ? "no campaign " + std::to_string(*id) : "no campaign yet; run a plan first"));
}

std::optional<CampaignInfo> Store::find_campaign(const std::string& plan_hash,
                                                 const std::string& specimen_hash) const {
  Statement s(impl_->db, std::string("SELECT ") + campaign_columns +
                             " FROM campaign WHERE plan_hash = ? AND specimen_hash = ? AND rig_uri <> '' "
                             "ORDER BY id DESC LIMIT 1");
  s.bind(plan_hash).bind(specimen_hash);
  if (!s.step()) return std::nullopt;
  return campaign_row(s);
}

std::int64_t Store::store_shot(const StoredShot& given, const Record* record, const Events* events,
                               const ExtractionInfo& extraction) {
  Database& db = impl_->db;
  StoredShot shot = given;
  if (shot.started.empty()) shot.started = utc_now();
  Transaction t(db);
  shot.attempt = impl_->next_attempt(shot);
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
      .bind(to_json(shot.conditions))
      .bind(name(shot.outcome))
      .bind(shot.reason)
      .bind(shot.started)
      .bind(seal_of(shot))
      .run();
  const std::int64_t id = db.last_id();
  if (record) {
    const std::int64_t record_id = insert_record(db, id, *record);
    if (events) impl_->insert_events(record_id, *events, extraction);
  }
  t.commit();
  return id;
}

std::vector<StoredShot> Store::shots(std::int64_t campaign) const {
  std::vector<StoredShot> list = shots(campaign, ShotKind::measured);
  for (auto& s : shots(campaign, ShotKind::simulated)) list.push_back(std::move(s));
  return list;
}

std::vector<StoredShot> Store::shots(std::int64_t campaign, ShotKind kind) const {
  std::vector<StoredShot> list;
  Statement s(impl_->db,
              shot_query + "WHERE campaign_id = ? AND kind = ? AND " + last_attempt + "ORDER BY number");
  s.bind(campaign).bind(name(kind));
  while (s.step()) list.push_back(shot_row(s));
  return list;
}

std::map<Outcome, std::size_t> Store::outcomes(std::int64_t campaign, ShotKind kind) const {
  std::map<Outcome, std::size_t> counts;
  Statement s(impl_->db, "SELECT outcome, count(*) FROM shot WHERE campaign_id = ? AND kind = ? AND " +
                             last_attempt + "GROUP BY outcome");
  s.bind(campaign).bind(name(kind));
  while (s.step()) counts[outcome_from(s.text(0))] = static_cast<std::size_t>(s.integer(1));
  return counts;
}

std::vector<StoredShot> Store::earlier_attempts(std::int64_t campaign) const {
  std::vector<StoredShot> list;
  Statement s(impl_->db, shot_query + "WHERE campaign_id = ? AND NOT " + last_attempt +
                             "ORDER BY kind, number, attempt");
  s.bind(campaign);
  while (s.step()) list.push_back(shot_row(s));
  return list;
}

StoredShot Store::shot(std::int64_t id) const {
  Statement s(impl_->db, shot_query + "WHERE shot.id = ?");
  s.bind(id);
  if (!s.step()) throw WrongStore(impl_->db.path() + ": no shot " + std::to_string(id));
  return shot_row(s);
}

Record Store::load_record(std::int64_t shot) const {
  const StoredShot info = this->shot(shot);
  Record record = select_record(impl_->db, shot);
  record.conditions = info.conditions;
  return record;
}

std::string Store::sealed_text(std::int64_t shot) const {
  Statement s(impl_->db, "SELECT sealed FROM record WHERE shot_id = ?");
  return s.bind(shot).step() ? s.text(0) : std::string();
}

std::optional<Events> Store::load_events(std::int64_t shot) const {
  Statement s(
      impl_->db,
      "SELECT record_id, events.method, parameters_hash, parameters, events.program_version, events, "
      "events.seal "
      "FROM events JOIN record ON record.id = record_id WHERE shot_id = ? ORDER BY events.id DESC LIMIT 1");
  s.bind(shot);
  if (!s.step()) return std::nullopt;
  check_seal(seal_of_events(s.integer(0), s.text(1), s.text(2), s.text(3), s.text(4), s.text(5)), s.text(6),
             "events of shot " + std::to_string(shot));
  return stored_json([&] { return events_from_json(s.text(5)); });
}

void Store::store_events(std::int64_t shot, const Events& events, const ExtractionInfo& info) {
  const auto record = impl_->record_of(shot);
  if (!record) throw StoreError(impl_->db.path() + ": shot " + std::to_string(shot) + " has no record");
  impl_->insert_events(*record, events, info);
}

namespace {

std::string seal_of(std::int64_t campaign, const Annotation& a) {
  return Seal().add(campaign).add(a.created).add(a.key).add(a.text).hex();
}

}  // namespace

void Store::annotate(std::int64_t campaign, const std::string& key, const std::string& text) {
  const Annotation a{utc_now(), key, text};
  Statement(impl_->db,
            "INSERT INTO annotation (campaign_id, created, key, text, seal) VALUES (?, ?, ?, ?, ?)")
      .bind(campaign)
      .bind(a.created)
      .bind(a.key)
      .bind(a.text)
      .bind(seal_of(campaign, a))
      .run();
}

std::vector<Annotation> Store::annotations(std::int64_t campaign) const {
  std::vector<Annotation> list;
  Statement s(impl_->db, "SELECT created, key, text, seal FROM annotation WHERE campaign_id = ? ORDER BY id");
  s.bind(campaign);
  while (s.step()) {
    list.push_back({s.text(0), s.text(1), s.text(2)});
    check_seal(seal_of(campaign, list.back()), s.text(3),
               "an annotation of campaign " + std::to_string(campaign));
  }
  return list;
}

void Store::store_prediction(std::int64_t shot, const std::map<std::string, double>& u) {
  const std::string text = numbers_to_json(u);
  Statement(impl_->db, "INSERT INTO prediction (shot_id, uncertainty, seal) VALUES (?, ?, ?)")
      .bind(shot)
      .bind(text)
      .bind(Seal().add(shot).add(text).hex())
      .run();
}

std::map<std::string, double> Store::prediction(std::int64_t shot) const {
  Statement s(impl_->db, "SELECT uncertainty, seal FROM prediction WHERE shot_id = ?");
  s.bind(shot);
  if (!s.step()) return {};
  check_seal(Seal().add(shot).add(s.text(0)).hex(), s.text(1),
             "the prediction of shot " + std::to_string(shot));
  return stored_json([&] { return numbers_from_json(s.text(0)); });
}

void Store::limit_pages(int pages) {
  impl_->db.run("PRAGMA max_page_count = " + std::to_string(pages));
}

}  // namespace powbench::host
