#include "host/store/store.h"

#include <filesystem>
#include <set>

#include "core/quantities.h"
#include "host/store/begun_rows.h"
#include "host/store/in_flight.h"
#include "host/store/json.h"
#include "host/store/open.h"
#include "host/store/record_rows.h"
#include "host/store/rows.h"

namespace powbench::host {

using sqlite::Database;
using sqlite::Statement;
using sqlite::Transaction;

std::string_view name(ShotKind kind) {
  return kind == ShotKind::measured ? "measured" : "simulated";
}

struct Store::Impl {
  Database db;
  InFlight in_flight{std::filesystem::weakly_canonical(db.path()).string()};

  std::optional<std::int64_t> record_of(std::int64_t shot) const {
    Statement s(db, "SELECT id FROM record WHERE shot_id = ?");
    s.bind(shot);
    if (!s.step()) return std::nullopt;
    return s.integer(0);
  }

  void insert(std::int64_t shot, std::int64_t record, const Events& e, const ExtractionInfo& info) {
    const EventsRow row{0,         record, e.method, e.parameters_hash, info.parameters, info.program_version,
                        to_json(e)};
    if (const auto id = insert_events(db, row)) write_digest(db, shot, *id, e);
  }

  /// Before its indices are used for the first time: a flipped bit in an index must not hide a row.
  void need(const char* table) const {
    if (checked.insert(table).second) check_table(db, table);
  }
  mutable std::set<std::string> checked{};

  /// The number of the next attempt at this shot; a closing that gave a valid record has none.
  int next_attempt(const StoredShot& shot) {
    Statement s(db,
                "SELECT outcome, attempt FROM shot WHERE campaign_id = ? AND kind = ? AND number = ? "
                "ORDER BY attempt DESC LIMIT 1");
    s.bind(shot.campaign).bind(name(shot.kind)).bind(shot.number);
    if (!s.step()) return 1;
    const Outcome before = outcome_from(s.text(0));
    if (shot.kind == ShotKind::measured && measured(before))
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
  c.finished = false;
  return insert_campaign(impl_->db, c);
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

void Store::begin_shot(const StoredShot& given) {
  StoredShot shot = given;
  if (shot.started.empty()) shot.started = utc_now();
  insert_begun(impl_->db, shot);
  impl_->in_flight.begin(shot.campaign, shot.number);
}

std::vector<StoredShot> Store::close_begun() {
  Database& db = impl_->db;
  std::vector<StoredShot> closed;
  Transaction t(db);
  for (BegunRow& row : select_begun(db)) {
    if (row.running || impl_->in_flight.elsewhere(row.shot.campaign, row.shot.number)) continue;
    row.shot.outcome = Outcome::error;
    row.shot.reason =
        "the program ended while this shot was fired: the coil may have been on, nothing was recorded";
    row.shot.attempt = impl_->next_attempt(row.shot);
    row.shot.id = insert_shot(db, row.shot);
    remove_begun(db, row.shot.campaign, row.shot.number);
    // the shot may be fired again, and an attempt before the last is in no list
    insert_annotation(db, row.shot.campaign,
                      {utc_now(), course_key,
                       "the program ended while shot " + std::to_string(row.shot.number + 1) +
                           " of the plan was fired: its coil may have been on"});
    closed.push_back(std::move(row.shot));
  }
  t.commit();
  return closed;
}

std::int64_t Store::store_shot(const StoredShot& given, const Record* record, const Events* events,
                               const ExtractionInfo& extraction) {
  Database& db = impl_->db;
  StoredShot shot = given;
  if (shot.started.empty()) shot.started = utc_now();
  Transaction t(db);
  shot.attempt = impl_->next_attempt(shot);
  const std::int64_t id = insert_shot(db, shot);
  if (shot.kind == ShotKind::measured) remove_begun(db, shot.campaign, shot.number);
  if (record) {
    const std::int64_t record_id = insert_record(db, id, *record);
    if (events) impl_->insert(id, record_id, *events, extraction);
  }
  t.commit();
  if (shot.kind == ShotKind::measured) impl_->in_flight.end(shot.campaign, shot.number);
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

std::vector<StoredShot> Store::shots_after(std::int64_t campaign, std::int64_t after) const {
  std::vector<StoredShot> list;
  Statement s(impl_->db,
              shot_query + "WHERE shot.id > ? AND campaign_id = ? AND " + last_attempt + "ORDER BY shot.id");
  s.bind(after).bind(campaign);
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

std::vector<ShotLine> Store::lines(std::int64_t campaign) const {
  impl_->need("digest");
  std::vector<ShotLine> list = shot_lines(impl_->db, campaign);
  for (ShotLine& line : list) {
    if (line.digested) continue;
    const auto events = load_events(line.shot.id);
    if (!events) continue;
    const auto of = [&](std::string_view symbol) { return find_quantity(symbol)->of(*events); };
    line.reached = events->coil.closing_angle;
    line.touch = of("t_ct1"), line.bounce = of("t_ct_bon"), line.settled = of("t_ct2");
  }
  return list;
}

std::optional<Events> Store::load_events(std::int64_t shot) const {
  const auto read = [&](Statement& s) {
    return stored_json([&] { return events_from_json(events_row(s, shot).events); });
  };
  const std::string query =
      std::string("SELECT ") + events_columns + ", shot_id FROM events JOIN record ON record.id = record_id ";
  // the digest names the row: no index is needed to find it, and none can hide it
  if (const auto id = digest_of(impl_->db, shot)) {
    Statement s(impl_->db, query + "WHERE events.id = ?");
    if (!s.bind(*id).step() || s.integer(8) != shot)
      throw StoreError("the file is damaged: the events of shot " + std::to_string(shot) +
                       " are missing; restore it from a copy");
    return read(s);
  }
  impl_->need("digest");
  impl_->need("events");
  Statement s(impl_->db, query + "WHERE shot_id = ? ORDER BY events.id DESC LIMIT 1");
  if (s.bind(shot).step()) return read(s);
  Statement row(impl_->db, "SELECT outcome FROM shot WHERE id = ?");
  if (row.bind(shot).step() && measured(outcome_from(row.text(0))) && !impl_->record_of(shot))
    throw StoreError("the file is damaged: the record of shot " + std::to_string(shot) +
                     " is missing; restore it from a copy");
  return std::nullopt;
}

void Store::store_events(std::int64_t shot, const Events& events, const ExtractionInfo& info) {
  const auto record = impl_->record_of(shot);
  if (!record) throw StoreError(impl_->db.path() + ": shot " + std::to_string(shot) + " has no record");
  Transaction t(impl_->db);
  impl_->insert(shot, *record, events, info);
  t.commit();
}

void Store::annotate(std::int64_t campaign, const std::string& key, const std::string& text) {
  insert_annotation(impl_->db, campaign, {utc_now(), key, text});
}

std::vector<Annotation> Store::annotations(std::int64_t campaign) const {
  return select_annotations(impl_->db, campaign);
}

void Store::store_prediction(std::int64_t shot, const InputSpread& p) {
  insert_prediction(impl_->db, shot, to_json(p));
}

InputSpread Store::prediction(std::int64_t shot) const {
  const std::string text = select_prediction(impl_->db, shot);
  if (text.empty()) return {};
  return stored_json([&] { return spread_from_json(text); });
}

void Store::limit_pages(int pages) {
  impl_->db.run("PRAGMA max_page_count = " + std::to_string(pages));
}

}  // namespace powbench::host
