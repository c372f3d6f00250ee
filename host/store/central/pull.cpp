#include <array>
#include <filesystem>

#include "host/store/central/central.h"
#include "host/store/central/columns.h"
#include "host/store/central/points.h"
#include "host/store/central/postgres.h"
#include "host/store/central/sweeps.h"
#include "host/store/content.h"
#include "host/store/hash.h"
#include "host/store/json.h"
#include "host/store/open.h"
#include "host/store/record_rows.h"

namespace powbench::host {

namespace fs = std::filesystem;
using postgres::Connection;
using postgres::Rows;
using postgres::Values;
using sqlite::Database;
using sqlite::Statement;

namespace {

/// Read at a time.
constexpr int most_together = 64;
constexpr std::int64_t most_read = 8'000'000;

/// One campaign after the other, each into a store that lacks it.
class Puller {
 public:
  Puller(Connection& from, Database& to, const Step& step) : from_(from), to_(to), step_(step) {}

  Merged run(const CampaignChoice& choice) {
    std::vector<Found> chosen;
    const Rows rows = from_.run(
        "SELECT c.id, c.hash, created, name, plan, plan_hash, specimen, specimen_hash, rig_file, rig_uri, "
        "rig_identity, program_version, origin, finished, (SELECT count(*) FROM shot WHERE campaign_id = "
        "c.id) "
        "FROM campaign c ORDER BY created, id");
    for (int i = 0; i < rows.size(); ++i) {
      Found f{campaign(rows, i), annotations(rows.integer(i, 0)), rows.integer(i, 0), rows.text(i, 1)};
      if (campaign_key(f.campaign) != f.hash)
        damaged("campaign '" + f.campaign.name + "' of " + f.campaign.created);
      if (choice && !choice(f.campaign, f.annotations)) continue;
      all_ += rows.integer(i, 14);
      chosen.push_back(std::move(f));
    }
    for (const Found& f : chosen) pull(f);
    if (!choice) made_.sweep_blocks = pull_sweeps(from_, to_);
    if (!choice) made_.points = pull_points(from_, to_);
    return made_;
  }

 private:
  struct Found {
    CampaignInfo campaign;
    std::vector<Annotation> annotations;
    std::int64_t id;
    std::string hash;
  };

  [[noreturn]] void damaged(const std::string& what) const {
    throw StoreError(from_.address() + ": " + what + " does not match its hash: the database is damaged");
  }

  static CampaignInfo campaign(const Rows& rows, int i) {
    CampaignInfo c{.id = 0,
                   .created = rows.text(i, 2),
                   .name = rows.text(i, 3),
                   .plan = rows.text(i, 4),
                   .plan_hash = rows.text(i, 5),
                   .specimen = rows.text(i, 6),
                   .specimen_hash = rows.text(i, 7),
                   .rig_file = rows.text(i, 8),
                   .rig_uri = rows.text(i, 9),
                   .rig_identity = rows.text(i, 10),
                   .program_version = rows.text(i, 11),
                   .finished = rows.flag(i, 13)};
    c.origin = origin_from(rows.text(i, 12));
    return c;
  }

  std::vector<Annotation> annotations(std::int64_t campaign) const {
    std::vector<Annotation> list;
    const Rows rows =
        from_.run("SELECT created, key, text, hash FROM annotation WHERE campaign_id = $1 ORDER BY position",
                  Values().integer(campaign));
    for (int i = 0; i < rows.size(); ++i) {
      list.push_back({rows.text(i, 0), rows.text(i, 1), rows.text(i, 2)});
      if (annotation_key(list.back()) != rows.text(i, 3)) damaged("an annotation");
    }
    return list;
  }

  void pull(const Found& f) {
    const std::int64_t id = insert_campaign(to_, f.campaign);
    ++made_.campaigns;
    if (f.campaign.finished) Statement(to_, "UPDATE campaign SET finished = 1 WHERE id = ?").bind(id).run();
    for (const Annotation& a : f.annotations) insert_annotation(to_, id, a);
    const Rows shots = from_.run(
        "SELECT s.id, hash, kind, number, attempt, repeat, angle_deg, conditions, outcome, reason, started, "
        "coalesce(octet_length(scans), 0)::bigint FROM shot s LEFT JOIN record r ON r.shot_id = s.id WHERE "
        "campaign_id = $1 ORDER BY s.id",
        Values().integer(f.id));
    for (int first = 0; first < shots.size();) {
      int last = first;
      for (std::int64_t bytes = 0; last < shots.size() && last < first + most_together && bytes < most_read;
           ++last)
        bytes += shots.integer(last, 11);
      sqlite::Transaction t(to_);
      pull(f, id, shots, first, last);
      t.commit();
      first = last;
      if (step_) step_(done_, all_);
    }
  }

  /// The shots of rows `first` to before `last`, with all that belongs to them.
  void pull(const Found& f, std::int64_t campaign, const Rows& shots, int first, int last) {
    const Values range =
        Values().integer(f.id).integer(shots.integer(first, 0)).integer(shots.integer(last - 1, 0));
    const auto ask = [&](const std::string& columns, const std::string& table, const std::string& order) {
      from_.queue("SELECT t.shot_id, " + columns + " FROM " + table +
                      " t JOIN shot s ON s.id = t.shot_id WHERE s.campaign_id = $1 AND s.id BETWEEN $2 AND "
                      "$3 AND t.shot_id BETWEEN $2 AND $3 "
                      "ORDER BY t.shot_id" +
                      order,
                  range);
    };
    ask(column_list(record_columns, "t."), "record", "");
    ask(column_list(channel_columns, "t."), "channel", ", position");
    ask("t.hash, method, parameters_hash, parameters, program_version, events", "events", ", position");
    ask("t.hash, uncertainty", "prediction", "");
    const std::vector<Rows> rows = from_.finish();
    std::array<int, 4> at{};
    const auto next = [&](std::size_t table, std::int64_t shot) {
      return at[table] < rows[table].size() && rows[table].integer(at[table], 0) == shot;
    };
    for (int i = first; i < last; ++i) {
      const std::int64_t theirs = shots.integer(i, 0);
      StoredShot s = shot(shots, i);
      s.campaign = campaign;
      const std::string what =
          "shot number " + std::to_string(s.number) + " of campaign '" + f.campaign.name + "'";
      s.id = insert_shot(to_, s);
      ++made_.shots, ++done_;
      if (next(0, theirs)) {
        static const std::string record_insert = insert_text("record", "shot_id", record_columns, false);
        static const std::string channel_insert = insert_text("channel", "record_id", channel_columns, false);
        Statement record(to_, record_insert);
        record.bind(s.id);
        give_columns(record, rows[0], at[0]++, 1, record_columns);
        record.run();
        const std::int64_t record_id = to_.last_id();
        for (; next(1, theirs); ++at[1]) {
          Statement channel(to_, channel_insert);
          channel.bind(record_id);
          give_columns(channel, rows[1], at[1], 1, channel_columns);
          channel.run();
        }
        select_record(to_, s.id);  // throws where samples or channels do not match
        for (; next(2, theirs); ++at[2]) events(rows[2], at[2], s.id, record_id, what);
      }
      if (central_shot_key(f.hash, s, record_name(to_, s.id)) != shots.text(i, 1)) damaged(what);
      if (next(3, theirs)) {
        if (sha256_hex(rows[3].text(at[3], 2)) != rows[3].text(at[3], 1))
          damaged("the prediction of " + what);
        insert_prediction(to_, s.id, rows[3].text(at[3]++, 2));
      }
    }
  }

  static StoredShot shot(const Rows& rows, int i) {
    StoredShot s;
    s.kind = rows.text(i, 2) == "measured" ? ShotKind::measured : ShotKind::simulated;
    s.number = static_cast<int>(rows.integer(i, 3));
    s.attempt = static_cast<int>(rows.integer(i, 4));
    s.repeat = static_cast<int>(rows.integer(i, 5));
    s.angle_deg = rows.real(i, 6);
    s.conditions = stored_json([&] { return conditions_from_json(rows.text(i, 7)); });
    s.outcome = outcome_from(rows.text(i, 8));
    s.reason = rows.text(i, 9);
    s.started = rows.text(i, 10);
    return s;
  }

  void events(const Rows& rows, int i, std::int64_t shot, std::int64_t record, const std::string& what) {
    const EventsRow e{
        0, record, rows.text(i, 2), rows.text(i, 3), rows.text(i, 4), rows.text(i, 5), rows.text(i, 6)};
    if (events_key(e) != rows.text(i, 1)) damaged("an extraction of " + what);
    const auto id = insert_events(to_, e);
    if (!id) damaged("an extraction of " + what);
    write_digest(to_, shot, *id, stored_json([&] { return events_from_json(e.events); }));
    ++made_.events;
  }

  Connection& from_;
  Database& to_;
  const Step& step_;
  Merged made_;
  std::int64_t all_ = 0, done_ = 0;
};

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

}  // namespace

Merged pull_store(const std::string& address, const std::string& path, const CampaignChoice& choice,
                  const std::function<std::string()>& why_none, const Step& step) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) throw WrongStore(path + ": is a folder; name a file");
  const bool there = fs::exists(path) && fs::file_size(path) > 0;
  if (there) open_store(path, Store::Mode::read_only);  // refused before anything is fetched
  Connection from(address);
  postgres::open_schema(from, false);
  const std::string aside = aside_file(path, ".pull-");
  try {
    Merged made;
    {
      Database to = open_store(aside, Store::Mode::read_write);
      to.run("PRAGMA synchronous = NORMAL");  // flushed when it is closed; until then it has no name
      postgres::Transaction t(from,
                              "ISOLATION LEVEL REPEATABLE READ READ ONLY");  // one state of the database
      made = Puller(from, to, step).run(choice);
      t.commit();
      if (choice && made.campaigns == 0)
        throw WrongStore(address + ": " + (why_none ? why_none() : "no such campaign"));
    }
    if (!there && put_in_place(aside, path)) return made;
    made = merge_stores(path, {aside});
    fs::remove(aside);
    return made;
  } catch (const WrongStore& e) {
    for (const char* end : {"", "-wal", "-shm"}) fs::remove(aside + end, ignored);
    throw WrongStore(replaced(e.what(), aside, address));
  } catch (...) {
    for (const char* end : {"", "-wal", "-shm"}) fs::remove(aside + end, ignored);
    throw;
  }
}

}  // namespace powbench::host
