#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/store/sqlite.h"
#include "host/store/store.h"

/// Rows of the store and their seals, read and written in one place. All readers throw StoreError for a row that does
/// not match.

namespace powbench::host {

Outcome outcome_from(const std::string& word);
Origin origin_from(
    const std::string& word);  ///< unknown for a word that is none, as in rows from before there were origins
std::string utc_text(std::chrono::system_clock::time_point);  ///< ISO 8601
std::string utc_now();

/// Stored JSON that cannot be read is damage, not bad input.
template <class F>
auto stored_json(F&& read) {
  try {
    return read();
  } catch (const std::invalid_argument& e) {
    throw StoreError(std::string("the file is damaged: ") + e.what());
  }
}

void check_seal(const std::string& expected, const std::string& found, const std::string& what);

/// Columns of campaign_row.
inline constexpr const char* campaign_columns =
    "id, created, name, plan, plan_hash, specimen, specimen_hash, rig_file, rig_uri, rig_identity, "
    "program_version, finished, seal, origin";
/// `c.origin` as it stands in the file; campaigns from before origins were kept have none.
CampaignInfo stored_campaign_row(const sqlite::Statement&);
/// The same with what the name of the rig can only mean where no origin is kept.
CampaignInfo campaign_row(const sqlite::Statement&);
/// Writes all but the id; returns the new one.
std::int64_t insert_campaign(sqlite::Database&, const CampaignInfo&);

/// Ends in FROM shot LEFT JOIN record: add WHERE.
extern const std::string shot_query;
/// Condition: of all attempts at a shot the last one.
extern const std::string last_attempt;
StoredShot shot_row(const sqlite::Statement&);
std::int64_t insert_shot(sqlite::Database&, const StoredShot&);

struct EventsRow {
  std::int64_t id = 0, record = 0;
  std::string method, parameters_hash, parameters, program_version, events;
};
/// Columns of events_row.
inline constexpr const char* events_columns =
    "events.id, record_id, events.method, parameters_hash, parameters, events.program_version, events, "
    "events.seal";
EventsRow events_row(const sqlite::Statement&, std::int64_t shot);
/// The new row's id; nothing where this extraction is there already.
std::optional<std::int64_t> insert_events(sqlite::Database&, const EventsRow&);

/// What a list shows of a shot: closing angle (rad), touch, bounce, settled (s).
std::array<Measured, 4> digest_values(const Events&);
/// What a list shows of a shot's newest events, kept beside them.
void write_digest(sqlite::Database&, std::int64_t shot, std::int64_t events_id, const Events&);
/// The id of the events that the shot's digest is from.
std::optional<std::int64_t> digest_of(const sqlite::Database&, std::int64_t shot);
/// Shots of a campaign by kind and number, of each the last attempt. Those without a digest have `digested` false.
std::vector<ShotLine> shot_lines(const sqlite::Database&, std::int64_t campaign);

void insert_annotation(sqlite::Database&, std::int64_t campaign, const Annotation&);
std::vector<Annotation> select_annotations(const sqlite::Database&, std::int64_t campaign);

/// Text of the prediction of a shot; empty: none.
std::string select_prediction(const sqlite::Database&, std::int64_t shot);
void insert_prediction(sqlite::Database&, std::int64_t shot, const std::string& text);

}  // namespace powbench::host
