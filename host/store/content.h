#pragma once

#include <string>
#include <vector>

#include "host/store/rows.h"
#include "host/store/sweep_rows.h"

/// The content of a store without the numbers that depend on the order of writing. Readers throw StoreError for a
/// damaged row.

namespace powbench::host {

std::vector<CampaignInfo> all_campaigns(const sqlite::Database&);

/// The first damage of a store, but for sweeps and points, whose rows are checked where they are read; "": none.
std::string campaign_damage(const sqlite::Database&);

/// Of a campaign: all of its row but id and `finished`.
std::string campaign_key(const CampaignInfo&);

/// Id and seal of the record of a shot; id 0 = none.
struct RecordName {
  std::int64_t id = 0;
  std::string seal;
};
RecordName record_name(const sqlite::Database&, std::int64_t shot);

/// Of a shot and its record, without ids: equal keys, equal measurement.
std::string shot_key(const StoredShot&, const RecordName&);

/// All shots of a campaign, all attempts, by kind, number, attempt.
std::vector<StoredShot> all_attempts(const sqlite::Database&, std::int64_t campaign);

/// All extractions of a record, oldest first.
std::vector<EventsRow> all_events(const sqlite::Database&, std::int64_t record, std::int64_t shot);

/// Of an extraction, without ids.
std::string events_key(const EventsRow&);
std::string annotation_key(const Annotation&);

bool same_annotations(const std::vector<Annotation>&, const std::vector<Annotation>&);
/// The annotations of one campaign from two stores: the longer list where it begins with the other, else all in the
/// order in which they were written, each once.
std::vector<Annotation> united(const std::vector<Annotation>&, const std::vector<Annotation>&);

/// Of one campaign with all that belongs to it.
std::string campaign_hash(const sqlite::Database&, const CampaignInfo&);
std::string sweep_hash(const sqlite::Database&, const SweepInfo&);

}  // namespace powbench::host
