#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <tuple>

#include "host/store/content.h"
#include "host/store/json.h"
#include "host/store/maintain.h"
#include "host/store/open.h"
#include "host/store/point_rows.h"

namespace powbench::host {

namespace fs = std::filesystem;
using sqlite::Database;
using sqlite::Statement;
using sqlite::Transaction;

namespace {

/// Copies rows as they stand: `columns` of `table` where `key` = `from_key`, with `to_key` in place of it.
void copy_rows(const Database& from, Database& to, const std::string& table, const std::string& key,
               const std::string& columns, std::int64_t from_key, std::int64_t to_key) {
  Statement read(from, "SELECT " + columns + " FROM " + table + " WHERE " + key + " = ?");
  read.bind(from_key);
  const auto n = 1 + std::count(columns.begin(), columns.end(), ',');
  std::string marks = "?";
  for (std::int64_t i = 0; i < n; ++i) marks += ", ?";
  while (read.step()) {
    Statement write(to, "INSERT INTO " + table + " (" + key + ", " + columns + ") VALUES (" + marks + ")");
    write.bind(to_key);
    for (int i = 0; i < n; ++i) write.bind_column(read, i);
    write.run();
  }
}

class Merger {
 public:
  Merger(const Database& from, Database& to) : from_(from), to_(to) {}
  Merged run(std::int64_t only_campaign = 0, bool sweeps = true) {
    for (const CampaignInfo& c : all_campaigns(from_))
      if (only_campaign == 0 || c.id == only_campaign) add(c);
    if (sweeps) {
      for (const SweepInfo& s : select_sweeps(from_)) add(s);
      each_point(from_, [this](const PointRow& p) { add(p); });
    }
    return made_;
  }

 private:
  [[noreturn]] void conflict(const std::string& what) const {
    throw WrongStore(what + " is not the same in " + from_.path() + " and in " + to_.path() +
                     " (or a store merged before): nothing was merged");
  }

  void add(const CampaignInfo& c) {
    std::int64_t to = 0;
    bool finished = c.finished;
    for (const CampaignInfo& there : all_campaigns(to_))
      if (campaign_key(there) == campaign_key(c)) to = there.id, finished = finished || there.finished;
    if (to == 0) {
      to = insert_campaign(to_, c);
      ++made_.campaigns;
    }
    Statement(to_, "UPDATE campaign SET finished = ? WHERE id = ?").bind(finished ? 1 : 0).bind(to).run();
    using Place = std::tuple<ShotKind, int, int>;
    std::map<Place, StoredShot> there;
    for (StoredShot& s : all_attempts(to_, to)) there[{s.kind, s.number, s.attempt}] = std::move(s);
    for (const StoredShot& s : all_attempts(from_, c.id)) {
      const auto at = there.find({s.kind, s.number, s.attempt});
      const std::string what =
          "campaign '" + c.name + "' of " + c.created + ": shot number " + std::to_string(s.number);
      const RecordName record = record_name(from_, s.id);
      if (at == there.end()) {
        add_shot(s, record, to, what);
        continue;
      }
      if (shot_key(s, record) != shot_key(at->second, record_name(to_, at->second.id))) conflict(what);
      add_events(s.id, record.id, at->second.id, what);
      add_prediction(s.id, at->second.id, what);
    }
    add_annotations(c.id, to);
  }

  void add_shot(const StoredShot& s, const RecordName& record, std::int64_t campaign,
                const std::string& what) {
    StoredShot copy = s;
    copy.campaign = campaign;
    std::int64_t to = 0;
    try {
      to = insert_shot(to_, copy);
    } catch (const StoreError&) {  // valid there under another attempt
      conflict(what);
    }
    ++made_.shots;
    if (record.id != 0) {
      copy_rows(
          from_, to_, "record", "shot_id",
          "content_hash, sample_rate, samples, fire_sample, fire_offset, gaps, overruns, crc32, rig_shot_id, "
          "rig, firmware, calibration, seal, sealed, packing, scans",
          s.id, to);
      copy_rows(from_, to_, "channel", "record_id",
                "position, name, unit, scale, offset, delay, corner_hertz, clip_low, clip_high", record.id,
                record_name(to_, to).id);
      add_events(s.id, record.id, to, what);
    }
    add_prediction(s.id, to, what);
  }

  /// One list of extractions must go on where the other ends: then the longer one is both.
  void add_events(std::int64_t shot, std::int64_t record, std::int64_t to, const std::string& what) {
    const std::vector<EventsRow> list = all_events(from_, record, shot);
    const std::int64_t to_record = record_name(to_, to).id;
    const std::vector<EventsRow> there = all_events(to_, to_record, to);
    for (std::size_t i = 0; i < std::min(list.size(), there.size()); ++i)
      if (events_key(list[i]) != events_key(there[i])) conflict(what + ": its extraction");
    for (std::size_t i = there.size(); i < list.size(); ++i) {
      EventsRow row = list[i];
      row.record = to_record;
      const auto id = insert_events(to_, row);
      if (!id) conflict(what + ": its extraction");
      ++made_.events;
      if (i + 1 == list.size())
        write_digest(to_, to, *id, stored_json([&] { return events_from_json(row.events); }));
    }
  }

  void add_prediction(std::int64_t shot, std::int64_t to, const std::string& what) {
    const std::string text = select_prediction(from_, shot), there = select_prediction(to_, to);
    if (text.empty() || text == there) return;
    if (!there.empty()) conflict(what + ": its prediction");
    insert_prediction(to_, to, text);
  }

  void add_annotations(std::int64_t from, std::int64_t to) {
    const std::vector<Annotation> there = select_annotations(to_, to);
    const std::vector<Annotation> both = united(select_annotations(from_, from), there);
    if (same_annotations(both, there)) return;
    Statement(to_, "DELETE FROM annotation WHERE campaign_id = ?").bind(to).run();
    for (const Annotation& a : both) insert_annotation(to_, to, a);
  }

  void add(const SweepInfo& s) {
    const std::string what = "sweep of " + s.created;
    SweepInfo target;
    for (const SweepInfo& there : select_sweeps(to_))
      if (there.design_hash == s.design_hash) target = there;
    if (target.id == 0) {
      target.id = insert_sweep(to_, s);
    } else {
      if (target.design != s.design || target.points != s.points || target.columns != s.columns ||
          target.program_version != s.program_version)
        conflict(what);
      if (s.created < target.created) set_sweep_created(to_, target, s.created);
    }
    each_block(from_, s.id, [&](const SweepBlock& b) { add(b, target.id, what); });
  }

  /// Looks at no other block of the target: the cost of many merges is that of all blocks once.
  void add(const SweepBlock& b, std::int64_t sweep, const std::string& what) {
    if (overlaps_block(to_, sweep, b.first, b.count))
      conflict(what + ": the cut into blocks at " + std::to_string(b.first));
    if (const auto there = select_block(to_, sweep, b.first)) {
      const bool alike = there->count == b.count && there->numbers.size() == b.numbers.size() &&
                         std::memcmp(there->numbers.data(), b.numbers.data(), 8 * b.numbers.size()) == 0;
      if (!alike) conflict(what + ": its block " + std::to_string(b.first));
      return;
    }
    insert_block(to_, sweep, b.first, b.count, b.numbers);
    ++made_.sweep_blocks;
  }

  void add(const PointRow& p) {
    if (const auto there = select_point(to_, p.id)) {
      if (there->content != p.content) conflict("point " + p.id.substr(0, 12) + " of " + p.study);
      return;
    }
    insert_point(to_, p);
    ++made_.points;
  }

  const Database& from_;
  Database& to_;
  Merged made_;
};

void refuse_damaged(const std::string& path) {
  const StoreContent c = check_store(path);
  if (!c.damage.empty()) throw StoreError(path + ": " + c.damage.front() + "; nothing was merged");
}

/// Rows of sweeps and points are checked on the way: every byte of a source is read and hashed once.
Merged merge_from(const std::string& source, Database& to) {
  const Database from = open_store(source, Store::Mode::read_only);
  const auto refuse = [&](const std::string& damage) {
    throw StoreError(source + ": " + damage + "; nothing was merged");
  };
  if (const std::string damage = campaign_damage(from); !damage.empty()) refuse(damage);
  try {
    return Merger(from, to).run();
  } catch (const WrongStore&) {
    throw;
  } catch (const StoreError& e) {
    const std::string text = e.what();
    if (text.find(to.path()) != std::string::npos || text.find(source) != std::string::npos) throw;
    refuse(text);
  }
  return {};
}

}  // namespace

Merged merge_stores(const std::string& target, const std::vector<std::string>& sources) {
  std::error_code ignored;
  const bool fresh = !fs::exists(target, ignored);
  for (const std::string& source : sources) {
    if (fs::equivalent(source, target, ignored))
      throw WrongStore(source + ": is the target itself; name another file");
  }
  if (!fresh) refuse_damaged(target);
  Merged all;
  try {
    Database to = open_store(target, Store::Mode::read_write);
    Transaction t(to);
    for (const std::string& source : sources) {
      const Merged m = merge_from(source, to);
      all.campaigns += m.campaigns, all.shots += m.shots, all.events += m.events,
          all.sweep_blocks += m.sweep_blocks, all.points += m.points;
    }
    t.commit();
  } catch (...) {
    if (fresh) fs::remove(target, ignored);
    throw;
  }
  return all;
}

std::vector<std::string> split_store(const std::string& path, const std::string& folder,
                                     std::int64_t campaign) {
  refuse_damaged(path);
  const Database from = open_store(path, Store::Mode::read_only);
  std::vector<std::pair<std::int64_t, std::string>> parts;  // campaign, 0: sweeps
  for (const CampaignInfo& c : all_campaigns(from))
    if (campaign == 0 || c.id == campaign)
      parts.emplace_back(c.id, (fs::path(folder) / ("campaign-" + std::to_string(c.id) + ".db")).string());
  if (campaign != 0 && parts.empty()) throw WrongStore(path + ": no campaign " + std::to_string(campaign));
  if (campaign == 0 && (!select_sweeps(from).empty() || from.number("SELECT count(*) FROM point") > 0))
    parts.emplace_back(0, (fs::path(folder) / "sweeps.db").string());
  fs::create_directories(folder);
  for (const auto& [id, file] : parts)
    if (fs::exists(file)) throw WrongStore(file + ": is there already; name another folder");
  std::vector<std::string> files;
  for (const auto& [id, file] : parts) {
    Database to = open_store(file, Store::Mode::read_write);
    Transaction t(to);
    Merger(from, to).run(id == 0 ? -1 : id, id == 0);
    t.commit();
    files.push_back(file);
  }
  return files;
}

}  // namespace powbench::host
