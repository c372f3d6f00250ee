#include "host/store/content.h"

#include <algorithm>
#include <tuple>

#include "host/store/json.h"
#include "host/store/seal.h"

namespace powbench::host {

using sqlite::Database;
using sqlite::Statement;

std::vector<CampaignInfo> all_campaigns(const Database& db) {
  std::vector<CampaignInfo> list;
  Statement s(db, std::string("SELECT ") + campaign_columns + " FROM campaign ORDER BY id");
  while (s.step()) list.push_back(stored_campaign_row(s));
  return list;
}

std::string campaign_key(const CampaignInfo& c) {
  Seal seal;
  for (const std::string* text : {&c.created, &c.name, &c.plan, &c.plan_hash, &c.specimen, &c.specimen_hash,
                                  &c.rig_file, &c.rig_uri, &c.rig_identity, &c.program_version})
    seal.add(*text);
  return seal.add(name(c.origin)).hex();
}

RecordName record_name(const Database& db, std::int64_t shot) {
  Statement s(db, "SELECT id, seal FROM record WHERE shot_id = ?");
  if (!s.bind(shot).step()) return {};
  return {s.integer(0), s.text(1)};
}

std::string shot_key(const StoredShot& s, const RecordName& record) {
  Seal seal;
  seal.add(s.attempt)
      .add(name(s.kind))
      .add(s.number)
      .add(s.repeat)
      .add(s.angle_deg)
      .add(to_json(s.conditions));
  return seal.add(name(s.outcome)).add(s.reason).add(s.started).add(record.seal).hex();
}

std::vector<StoredShot> all_attempts(const Database& db, std::int64_t campaign) {
  std::vector<StoredShot> list;
  Statement s(db, shot_query + "WHERE campaign_id = ? ORDER BY kind, number, attempt");
  s.bind(campaign);
  while (s.step()) list.push_back(shot_row(s));
  return list;
}

std::vector<EventsRow> all_events(const Database& db, std::int64_t record, std::int64_t shot) {
  std::vector<EventsRow> list;
  Statement s(
      db, std::string("SELECT ") + events_columns + " FROM events WHERE record_id = ? ORDER BY events.id");
  s.bind(record);
  while (s.step()) list.push_back(events_row(s, shot));
  return list;
}

std::string events_key(const EventsRow& e) {
  return Seal()
      .add(e.method)
      .add(e.parameters_hash)
      .add(e.parameters)
      .add(e.program_version)
      .add(e.events)
      .hex();
}

std::string annotation_key(const Annotation& a) {
  return Seal().add(a.created).add(a.key).add(a.text).hex();
}

namespace {

bool before(const Annotation& a, const Annotation& b) {
  return std::tie(a.created, a.key, a.text) < std::tie(b.created, b.key, b.text);
}

bool alike(const Annotation& a, const Annotation& b) {
  return !before(a, b) && !before(b, a);
}

bool begins(const std::vector<Annotation>& a, const std::vector<Annotation>& b) {
  return a.size() <= b.size() && std::equal(a.begin(), a.end(), b.begin(), alike);
}

}  // namespace

bool same_annotations(const std::vector<Annotation>& a, const std::vector<Annotation>& b) {
  return a.size() == b.size() && begins(a, b);
}

std::vector<Annotation> united(const std::vector<Annotation>& one, const std::vector<Annotation>& other) {
  if (begins(one, other)) return other;
  if (begins(other, one)) return one;
  std::vector<Annotation> all = other;
  all.insert(all.end(), one.begin(), one.end());
  std::sort(all.begin(), all.end(), before);
  all.erase(std::unique(all.begin(), all.end(), alike), all.end());
  return all;
}

std::string campaign_hash(const Database& db, const CampaignInfo& c) {
  Seal seal;
  seal.add(campaign_key(c)).add(c.finished ? 1 : 0);
  for (const StoredShot& shot : all_attempts(db, c.id)) {
    const RecordName record = record_name(db, shot.id);
    seal.add(shot_key(shot, record)).add(select_prediction(db, shot.id));
    for (const EventsRow& e : all_events(db, record.id, shot.id))
      seal.add(e.method).add(e.parameters_hash).add(e.parameters).add(e.program_version).add(e.events);
  }
  for (const Annotation& a : select_annotations(db, c.id)) seal.add(a.created).add(a.key).add(a.text);
  return seal.hex();
}

/// When it was begun is left out: a point is a function of the design and the program alone, whoever computed it when.
std::string sweep_hash(const Database& db, const SweepInfo& s) {
  Seal seal;
  seal.add(s.design).add(s.design_hash).add(s.points).add(s.columns).add(s.program_version);
  each_block(db, s.id, [&](const SweepBlock& b) {
    seal.add(b.first).add(b.count);
    for (const double x : b.numbers) seal.add(x);
  });
  return seal.hex();
}

}  // namespace powbench::host
