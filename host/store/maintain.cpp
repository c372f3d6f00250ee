#include "host/store/maintain.h"

#include <algorithm>
#include <filesystem>

#include "host/store/begun_rows.h"
#include "host/store/content.h"
#include "host/store/json.h"
#include "host/store/open.h"
#include "host/store/point_rows.h"
#include "host/store/record_rows.h"
#include "host/store/seal.h"

namespace powbench::host {

using sqlite::Database;
using sqlite::Statement;
using sqlite::Transaction;

namespace {

constexpr std::size_t most_damage = 20;

/// Calls `look`; what it finds wrong becomes a sentence.
template <class F>
bool sound(StoreContent& c, F&& look) {
  try {
    look();
    return true;
  } catch (const StoreError& e) {
    if (c.damage.size() < most_damage) c.damage.emplace_back(e.what());
    return false;
  }
}

void check_structure(const Database& db, StoreContent& c) {
  Statement s(db, "PRAGMA integrity_check(20)");
  while (s.step())
    if (s.text(0) != "ok" && c.damage.size() < most_damage) c.damage.push_back("structure: " + s.text(0));
  Statement orphans(db, "PRAGMA foreign_key_check");
  while (orphans.step())
    if (c.damage.size() < most_damage)
      c.damage.push_back("table " + orphans.text(0) + ": row " + std::to_string(orphans.integer(1)) +
                         " belongs to none of table " + orphans.text(2));
}

/// Samples, events and digest of one shot.
void check_shot(const Database& db, const StoredShot& shot, StoreContent& c) {
  const RecordName record = record_name(db, shot.id);
  if (record.id == 0) return;
  ++c.records;
  sound(c, [&] { select_record(db, shot.id); });
  const std::vector<EventsRow> events = all_events(db, record.id, shot.id);
  c.events += static_cast<std::int64_t>(events.size());
  const auto digest = digest_of(db, shot.id);
  if (events.empty()) {
    if (measured(shot.outcome))
      throw StoreError("the events of shot " + std::to_string(shot.id) + " are missing");
    return;
  }
  if (!digest) {
    ++c.undigested;
  } else if (*digest != events.back().id) {
    throw StoreError("the digest of shot " + std::to_string(shot.id) + " is not that of its newest events");
  }
}

/// Structure and everything of campaigns.
void check_campaigns(const Database& db, StoreContent& c, const Step& step,
                     std::vector<std::string>& hashes) {
  check_structure(db, c);
  sound(c, [&] { select_begun(db); });
  const std::int64_t all = db.number("SELECT count(*) FROM shot");
  for (const CampaignInfo& campaign : all_campaigns(db)) {
    ++c.campaigns;
    sound(c, [&] {
      for (const StoredShot& shot : all_attempts(db, campaign.id)) {
        sound(c, [&] { check_shot(db, shot, c); });
        ++c.shots;
        if (step) step(c.shots, all);
      }
    });
    sound(c, [&] { hashes.push_back(campaign_hash(db, campaign)); });
  }
}

void check_rows(const Database& db, StoreContent& c, const Step& step) {
  std::vector<std::string> hashes;
  check_campaigns(db, c, step, hashes);
  for (const SweepInfo& sweep : select_sweeps(db)) {
    ++c.sweeps;
    sound(c, [&] { hashes.push_back(sweep_hash(db, sweep)); });
  }
  sound(c, [&] {
    each_point(db, [&](const PointRow& p) {
      hashes.push_back(point_hash(p));
      ++c.points;
    });
  });
  std::sort(hashes.begin(), hashes.end());
  Seal seal;
  for (const std::string& h : hashes) seal.add(h);
  if (c.damage.empty()) c.hash = seal.hex();
}

}  // namespace

StoreContent check_store(const std::string& path, const Step& step) {
  StoreContent c;
  Database db = open_store(path, Store::Mode::read_only);
  c.bare = db.number("SELECT count(*) FROM record WHERE packing = ''");
  sound(c, [&] { check_rows(db, c, step); });
  if (!c.damage.empty()) c.hash.clear();
  return c;
}

std::string campaign_damage(const Database& db) {
  StoreContent c;
  std::vector<std::string> hashes;
  sound(c, [&] { check_campaigns(db, c, {}, hashes); });
  return c.damage.empty() ? "" : c.damage.front();
}

Migrated migrate_store(const std::string& path, bool compact, const Step& step) {
  Migrated m;
  Database db = open_store(path, Store::Mode::read_write);
  std::vector<std::int64_t> shots;
  {
    Statement s(
        db,
        "SELECT shot_id FROM record WHERE packing = '' OR (NOT EXISTS (SELECT 1 FROM digest WHERE "
        "digest.shot_id = record.shot_id) AND EXISTS (SELECT 1 FROM events WHERE record_id = record.id))");
    while (s.step()) shots.push_back(s.integer(0));
  }
  constexpr std::size_t together = 64;  // shots a transaction
  for (std::size_t first = 0; first < shots.size(); first += together) {
    Transaction t(db);
    for (std::size_t i = first; i < std::min(first + together, shots.size()); ++i) {
      m.packed += pack_record(db, shots[i]) ? 1 : 0;
      const auto events = all_events(db, record_name(db, shots[i]).id, shots[i]);
      if (events.empty() || digest_of(db, shots[i])) continue;
      const EventsRow& newest = events.back();
      write_digest(db, shots[i], newest.id, stored_json([&] { return events_from_json(newest.events); }));
      ++m.digested;
    }
    t.commit();
    if (step)
      step(static_cast<std::int64_t>(std::min(first + together, shots.size())),
           static_cast<std::int64_t>(shots.size()));
  }
  if (compact) db.run("VACUUM");
  return m;
}

}  // namespace powbench::host
