#include <algorithm>
#include <limits>
#include <map>
#include <span>
#include <tuple>

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

using postgres::Connection;
using postgres::Rows;
using postgres::Values;
using sqlite::Database;
using sqlite::Statement;

namespace {

/// What a transaction holds at most: the lock of its campaign is short, and a kill loses little.
constexpr std::size_t most_shots = 64;
constexpr std::int64_t most_bytes = 8'000'000;

using Place = std::tuple<ShotKind, int, int>;  ///< kind, number, attempt
Place place(const StoredShot& s) {
  return {s.kind, s.number, s.attempt};
}

/// What the database knows of a shot.
struct There {
  std::int64_t id = 0;
  std::string hash, prediction;
  std::vector<std::string> events;  ///< keys, oldest first
  bool completed = false;           ///< a measurement that is there once
};

bool completed(const StoredShot& s) {
  return s.kind == ShotKind::measured && measured(s.outcome);
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

class Pusher {
 public:
  Pusher(const Database& from, Connection& to, const Step& step) : from_(from), to_(to), step_(step) {}

  Pushed run() {
    std::vector<CampaignInfo> campaigns = all_campaigns(from_);
    std::vector<Part> parts;
    for (const CampaignInfo& c : campaigns) parts.push_back(compare(c));
    // everybody in one order, though a transaction has one lock only
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.hash < b.hash; });
    SweepPusher sweeps(from_, to_);
    PointPusher points(from_, to_);
    all_ = sweeps.compare() + points.compare();
    for (const Part& p : parts) all_ += static_cast<std::int64_t>(p.shots.size());
    if (all_ > 0) refuse_hidden();
    began_ = true;
    for (const Part& p : parts) push(p);
    sweeps.push([&](std::int64_t bytes) {
      ++made_.sweep_blocks;
      made_.bytes += bytes;
      count(1);
    });
    points.push([&](std::int64_t bytes) {
      ++made_.points;
      made_.bytes += bytes;
      count(1);
    });
    return made_;
  }

 private:
  /// A campaign with those of its shots that the database lacks, wholly or in part.
  struct Part {
    CampaignInfo campaign;
    std::string hash;
    std::vector<StoredShot> shots;
  };

  void count(std::size_t n) {
    done_ += static_cast<std::int64_t>(n);
    if (step_) step_(done_, all_);
  }

  std::string words(const CampaignInfo& c, int number) const {
    return "campaign '" + c.name + "' of " + c.created + ": shot number " + std::to_string(number);
  }

  [[noreturn]] void conflict(const std::string& what) const {
    refuse_hidden();
    throw WrongStore(what + " is not the same in " + from_.path() + " and in " + to_.address() + ": " +
                     (began_ ? "the push has stopped there" : "nothing was pushed"));
  }

  /// A flipped bit in an index must not hide a row.
  void refuse_hidden() const {
    for (const char* table : {"record", "events", "prediction", "annotation"}) check_table(from_, table);
  }

  std::map<Place, There> there(std::int64_t campaign, int first, int last) const {
    std::map<Place, There> list;
    // written so that every part of it is found by an index, however large the database is
    const Rows rows = to_.run(
        "SELECT s.id, s.kind, s.number, s.attempt, s.hash, s.outcome, (SELECT p.hash FROM prediction p WHERE "
        "p.shot_id = s.id), (SELECT string_agg(e.hash, ',' ORDER BY e.position) FROM events e WHERE "
        "e.shot_id = "
        "s.id) FROM shot s WHERE s.campaign_id = $1 AND s.kind IN ('measured', 'simulated') AND s.number "
        "BETWEEN "
        "$2 AND $3",
        Values().integer(campaign).integer(first).integer(last));
    for (int i = 0; i < rows.size(); ++i) {
      const ShotKind kind = rows.text(i, 1) == "measured" ? ShotKind::measured : ShotKind::simulated;
      const Place at{kind, static_cast<int>(rows.integer(i, 2)), static_cast<int>(rows.integer(i, 3))};
      list[at] = {rows.integer(i, 0), rows.text(i, 4), rows.text(i, 6), split(rows.text(i, 7)),
                  kind == ShotKind::measured && measured(outcome_from(rows.text(i, 5)))};
    }
    return list;
  }

  /// Whether the database lacks something of the shot; refuses what cannot be the same shot.
  bool lacks(const CampaignInfo& c, const StoredShot& s, const std::string& campaign_hash,
             const std::map<Place, There>& list) const {
    const RecordName record = record_name(from_, s.id);
    const auto at = list.find(place(s));
    if (at == list.end()) {
      for (auto other = list.lower_bound({s.kind, s.number, 0});
           other != list.end() && std::get<1>(other->first) == s.number; ++other)
        if (completed(s) && other->second.completed) conflict(words(c, s.number));
      return true;
    }
    const There& there = at->second;
    if (central_shot_key(campaign_hash, s, record) != there.hash) conflict(words(c, s.number));
    const auto events = all_events(from_, record.id, s.id);
    for (std::size_t i = 0; i < std::min(events.size(), there.events.size()); ++i)
      if (events_key(events[i]) != there.events[i]) conflict(words(c, s.number) + ": its extraction");
    const std::string prediction = select_prediction(from_, s.id);
    if (!prediction.empty() && !there.prediction.empty() && sha256_hex(prediction) != there.prediction)
      conflict(words(c, s.number) + ": its prediction");
    return events.size() > there.events.size() || (!prediction.empty() && there.prediction.empty());
  }

  Part compare(const CampaignInfo& c) const {
    Part part{c, campaign_key(c), {}};
    const Rows row = to_.run("SELECT id FROM campaign WHERE hash = $1", Values().text(part.hash));
    std::map<Place, There> list;
    if (row.size() > 0) list = there(row.integer(0, 0), 0, std::numeric_limits<int>::max());
    std::vector<StoredShot> shots = all_attempts(from_, c.id);
    if (row.size() > 0)
      std::erase_if(shots, [&](const StoredShot& s) { return !lacks(c, s, part.hash, list); });
    part.shots = std::move(shots);
    return part;
  }

  /// Locks the campaign's row, made if missing, until the transaction ends.
  std::int64_t lock(const Part& p) {
    const CampaignInfo& c = p.campaign;
    to_.queue(
        "INSERT INTO campaign (hash, created, name, plan, plan_hash, specimen, specimen_hash, rig_file, "
        "rig_uri, "
        "rig_identity, program_version, origin, finished) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, "
        "$11, "
        "$12, false) ON CONFLICT DO NOTHING RETURNING id",
        Values()
            .text(p.hash)
            .text(c.created)
            .text(c.name)
            .text(c.plan)
            .text(c.plan_hash)
            .text(c.specimen)
            .text(c.specimen_hash)
            .text(c.rig_file)
            .text(c.rig_uri)
            .text(c.rig_identity)
            .text(c.program_version)
            .text(c.origin == Origin::unknown ? std::string_view("") : name(c.origin)));
    to_.queue("SELECT id FROM campaign WHERE hash = $1 FOR UPDATE", Values().text(p.hash));
    const std::vector<Rows> rows = to_.finish();
    made_.campaigns += rows[0].size();
    return rows[1].integer(0, 0);
  }

  void push(const Part& p) {
    for (std::size_t first = 0; first < p.shots.size();) {
      std::size_t last = first;
      for (std::int64_t bytes = 0; last < p.shots.size() && last < first + most_shots && bytes < most_bytes;
           ++last)
        bytes += size_of(p.shots[last]);
      push(p, std::span(p.shots).subspan(first, last - first));
      count(last - first);
      first = last;
    }
    finish(p);
  }

  std::int64_t size_of(const StoredShot& s) const {
    Statement size(from_, "SELECT length(scans) FROM record WHERE shot_id = ?");
    return size.bind(s.id).step() ? size.integer(0) : 0;
  }

  /// One transaction. What others have pushed since compare() is looked at once more, under the lock.
  void push(const Part& p, std::span<const StoredShot> shots) {
    postgres::Transaction t(to_);
    const std::int64_t campaign = lock(p);
    const auto numbers = std::minmax_element(
        shots.begin(), shots.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
    std::map<Place, There> list = there(campaign, numbers.first->number, numbers.second->number);
    std::vector<const StoredShot*> fresh;
    std::vector<const StoredShot*> lacking;
    for (const StoredShot& s : shots) {
      if (!lacks(p.campaign, s, p.hash, list)) continue;
      lacking.push_back(&s);
      if (list.contains(place(s))) continue;
      fresh.push_back(&s);
      queue_shot(campaign, p.hash, s);
    }
    const std::vector<Rows> ids = to_.finish();
    for (std::size_t i = 0; i < fresh.size(); ++i) {
      if (ids[i].size() == 0) conflict(words(p.campaign, fresh[i]->number));
      list[place(*fresh[i])].id = ids[i].integer(0, 0);
      queue_record(fresh[i]->id, ids[i].integer(0, 0));
    }
    made_.shots += static_cast<std::int64_t>(fresh.size());
    for (const StoredShot* s : lacking) queue_results(*s, list.at(place(*s)));
    to_.finish();
    t.commit();
  }

  void queue_shot(std::int64_t campaign, const std::string& campaign_hash, const StoredShot& s) {
    const RecordName record = record_name(from_, s.id);
    if (record.id != 0) select_record(from_, s.id);  // throws where its samples are damaged
    to_.queue(
        "INSERT INTO shot (campaign_id, hash, kind, number, attempt, repeat, angle_deg, conditions, outcome, "
        "reason, started) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11) ON CONFLICT DO NOTHING "
        "RETURNING id",
        Values()
            .integer(campaign)
            .text(central_shot_key(campaign_hash, s, record))
            .text(name(s.kind))
            .integer(s.number)
            .integer(s.attempt)
            .integer(s.repeat)
            .real(s.angle_deg)
            .text(to_json(s.conditions))
            .text(name(s.outcome))
            .text(s.reason)
            .text(s.started));
  }

  void queue_record(std::int64_t shot, std::int64_t to) {
    static const std::string record_insert = insert_text("record", "shot_id", record_columns, true);
    static const std::string channel_insert = insert_text("channel", "shot_id", channel_columns, true);
    Statement record(from_, "SELECT " + column_list(record_columns) + ", id FROM record WHERE shot_id = ?");
    if (!record.bind(shot).step()) return;
    constexpr int scans = static_cast<int>(record_columns.size()) - 1;
    made_.bytes += static_cast<std::int64_t>(record.blob(scans).size());
    Values values;
    take_columns(values.integer(to), record, record_columns);
    to_.queue(record_insert + " ON CONFLICT DO NOTHING", values);
    Statement channel(from_, "SELECT " + column_list(channel_columns) +
                                 " FROM channel WHERE record_id = ? ORDER BY position");
    channel.bind(record.integer(scans + 1));
    while (channel.step()) {
      Values one;
      take_columns(one.integer(to), channel, channel_columns);
      to_.queue(channel_insert + " ON CONFLICT DO NOTHING", one);
    }
  }

  /// The extractions behind those that are there, and the prediction.
  void queue_results(const StoredShot& s, const There& there) {
    const auto events = all_events(from_, record_name(from_, s.id).id, s.id);
    for (std::size_t i = there.events.size(); i < events.size(); ++i) {
      const EventsRow& e = events[i];
      Values values;
      values.integer(there.id)
          .integer(static_cast<std::int64_t>(i))
          .text(events_key(e))
          .text(e.method)
          .text(e.parameters_hash)
          .text(e.parameters)
          .text(e.program_version)
          .text(e.events);
      for (const Measured& m : digest_values(stored_json([&] { return events_from_json(e.events); })))
        values.real(m.value).real(m.u);
      to_.queue(
          "INSERT INTO events VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16) "
          "ON CONFLICT DO NOTHING",
          values);
      ++made_.events;
    }
    const std::string prediction = select_prediction(from_, s.id);
    if (!prediction.empty() && there.prediction.empty())
      to_.queue("INSERT INTO prediction VALUES ($1, $2, $3) ON CONFLICT DO NOTHING",
                Values().integer(there.id).text(sha256_hex(prediction)).text(prediction));
  }

  std::vector<Annotation> annotations(const std::string& campaign_hash) const {
    std::vector<Annotation> list;
    const Rows rows = to_.run(
        "SELECT a.created, a.key, a.text FROM annotation a JOIN campaign c ON c.id = a.campaign_id WHERE "
        "c.hash = "
        "$1 ORDER BY a.position",
        Values().text(campaign_hash));
    for (int i = 0; i < rows.size(); ++i) list.push_back({rows.text(i, 0), rows.text(i, 1), rows.text(i, 2)});
    return list;
  }

  /// Annotations, and `finished` behind all shots: a campaign that says so is whole. Writes nothing where nothing is
  /// new.
  void finish(const Part& p) {
    const std::vector<Annotation> ours = select_annotations(from_, p.campaign.id);
    const Rows row = to_.run("SELECT finished FROM campaign WHERE hash = $1", Values().text(p.hash));
    const bool known = row.size() > 0 && (row.flag(0, 0) || !p.campaign.finished);
    std::vector<Annotation> theirs = annotations(p.hash);
    if (known && same_annotations(united(ours, theirs), theirs)) return;
    postgres::Transaction t(to_);
    const std::int64_t campaign = lock(p);
    if (p.campaign.finished)
      to_.queue("UPDATE campaign SET finished = true WHERE id = $1 AND NOT finished",
                Values().integer(campaign));
    theirs = annotations(p.hash);
    const std::vector<Annotation> both = united(ours, theirs);
    if (!same_annotations(both, theirs)) {
      to_.queue("DELETE FROM annotation WHERE campaign_id = $1", Values().integer(campaign));
      for (std::size_t i = 0; i < both.size(); ++i)
        to_.queue("INSERT INTO annotation VALUES ($1, $2, $3, $4, $5, $6)",
                  Values()
                      .integer(campaign)
                      .integer(static_cast<std::int64_t>(i))
                      .text(annotation_key(both[i]))
                      .text(both[i].created)
                      .text(both[i].key)
                      .text(both[i].text));
      made_.annotations += static_cast<std::int64_t>(both.size() - theirs.size());
    }
    to_.finish();
    t.commit();
  }

  const Database& from_;
  Connection& to_;
  const Step& step_;
  Pushed made_;
  std::int64_t all_ = 0, done_ = 0;
  bool began_ = false;
};

}  // namespace

Pushed push_store(const std::string& path, const std::string& address, const Step& step) {
  Database from = open_store(path, Store::Mode::read_only);
  from.run("BEGIN");  // one state of the store, whoever writes to it meanwhile
  Connection to(address);
  postgres::open_schema(to, true);
  return Pusher(from, to, step).run();
}

}  // namespace powbench::host
