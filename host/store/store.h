#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/conditions.h"
#include "core/events.h"
#include "core/origin.h"
#include "core/outcome.h"
#include "core/record.h"
#include "host/store/input_spread.h"

/// The store: one SQLite file (WAL, STRICT tables) that holds campaigns, shots, raw records and events. A shot is
/// written in one transaction; raw samples are never changed.

namespace powbench::host {

/// The file cannot be used: damaged, foreign, from a newer program, full, or not writable. One sentence: what and what
/// to do. A refused file is left as it was.
class StoreError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class ShotKind { measured, simulated };
std::string_view name(ShotKind);

struct CampaignInfo {
  std::int64_t id = 0;
  std::string created;  ///< UTC, ISO 8601
  std::string name;
  std::string plan;  ///< resolved, TOML
  std::string plan_hash;
  std::string specimen;  ///< resolved, TOML
  std::string specimen_hash;
  std::string rig_file;  ///< resolved, TOML
  std::string rig_uri;
  std::string rig_identity;
  std::string program_version;
  bool finished = false;
  Origin origin = Origin::unknown;  ///< of its records
};

/// One shot as it is stored.
struct StoredShot {
  std::int64_t id = 0;
  std::int64_t campaign = 0;
  ShotKind kind = ShotKind::measured;
  int number = 0;  ///< place in the plan's order
  int repeat = 0;
  double angle_deg = 0.0;  ///< commanded, polarity included; of an import the one found; NaN = not known
  Conditions conditions;
  Outcome outcome = Outcome::error;
  std::string reason;
  std::string started;      ///< UTC, ISO 8601
  std::string record_hash;  ///< sha256 of the scans, empty without a record
  int attempt = 1;          ///< 1 first; the last one is the shot, the ones before are history
};

/// What a list shows of a shot. `shot` without conditions and record_hash.
struct ShotLine {
  StoredShot shot;
  bool digested = false;  ///< from the short row kept beside the events, not from the events themselves
  Measured reached;       ///< rad: closing angle
  Measured touch, bounce, settled;  ///< s: t_ct1, t_ct_bon, t_ct2
};

/// What was learned about a campaign after it was sealed.
struct Annotation {
  std::string created;  ///< UTC, ISO 8601
  std::string key, text;
};

/// Key of the annotations that the program makes by itself: that a campaign stopped early, and that it was gone on
/// with.
inline constexpr const char* course_key = "course";

/// No store is there, or what is there is none: the name is wrong, nothing is damaged.
class WrongStore : public StoreError {
  using StoreError::StoreError;
};

/// What store_events needs beside the events.
struct ExtractionInfo {
  std::string parameters;  ///< canonical text
  std::string program_version;
};

class Store {
 public:
  /// Marks the file as a powbench store ("PoWb").
  static constexpr std::uint32_t application_id = 0x506F5762;
  static constexpr int schema_version = 8;

  enum class Mode { read_only, read_write };

  /// Opens `path`; in read_write mode a missing or empty file becomes a new store, and an older schema is migrated.
  explicit Store(const std::string& path, Mode mode = Mode::read_write);
  ~Store();
  Store(Store&&) noexcept;
  Store& operator=(Store&&) noexcept;

  /// Stores the campaign; id, created and finished of `info` are ignored. Returns its id.
  std::int64_t create_campaign(const CampaignInfo& info);
  void set_finished(std::int64_t campaign, bool finished);
  std::vector<CampaignInfo> campaigns() const;
  /// The newest campaign, or the one with this id. Throws StoreError when there is none.
  CampaignInfo campaign(std::optional<std::int64_t> id = std::nullopt) const;
  /// The newest campaign of this plan and specimen that was fired on a rig, finished or not.
  std::optional<CampaignInfo> find_campaign(const std::string& plan_hash,
                                            const std::string& specimen_hash) const;

  /// Marks a measured shot as being fired, before its coil is switched on; store_shot takes the mark away. id, outcome,
  /// reason and attempt of `shot` are ignored.
  void begin_shot(const StoredShot& shot);
  /// Stores what a program that no longer runs has begun as ERROR, with the reason; what another program or another
  /// open Store of this one fires stays. This Store itself has nothing in flight. Returns what it stored, of all
  /// campaigns.
  std::vector<StoredShot> close_begun();

  /// Shot, record and events in one transaction. id, record_hash and attempt of `shot` are ignored. Returns the
  /// shot's id. A shot that is there already (same campaign, kind, number) gets another attempt, a measured one only
  /// if it has no valid record.
  std::int64_t store_shot(const StoredShot& shot, const Record* record, const Events* events,
                          const ExtractionInfo& extraction);
  /// All shots of a campaign, by kind, then number; of each the last attempt.
  std::vector<StoredShot> shots(std::int64_t campaign) const;
  std::vector<StoredShot> shots(std::int64_t campaign, ShotKind kind) const;
  /// Those of `shots` whose id is larger than `after`, by id; the others are not read.
  std::vector<StoredShot> shots_after(std::int64_t campaign, std::int64_t after) const;
  /// The same shots as `shots`, with the few numbers of a list: 20 000 of them in well below a second.
  std::vector<ShotLine> lines(std::int64_t campaign) const;
  /// How many shots of a campaign ended how, without reading them: their seals are not checked.
  std::map<Outcome, std::size_t> outcomes(std::int64_t campaign, ShotKind kind) const;
  /// The attempts before the last ones, which failed.
  std::vector<StoredShot> earlier_attempts(std::int64_t campaign) const;
  StoredShot shot(std::int64_t id) const;

  /// Throws StoreError when the samples do not match their hash.
  Record load_record(std::int64_t shot) const;
  /// The rig's sealed shot as it came, without the samples; empty: none.
  std::string sealed_text(std::int64_t shot) const;
  /// The newest events of a shot.
  std::optional<Events> load_events(std::int64_t shot) const;
  void store_events(std::int64_t shot, const Events&, const ExtractionInfo&);

  /// Adds to a campaign; nothing that is there is changed.
  void annotate(std::int64_t campaign, const std::string& key, const std::string& text);
  std::vector<Annotation> annotations(std::int64_t campaign) const;

  /// What the uncertainties of a simulated shot's inputs leave open; empty: nominal conditions.
  void store_prediction(std::int64_t shot, const InputSpread&);
  InputSpread prediction(std::int64_t shot) const;

  /// For tests: refuse to grow beyond this many pages, as a full disk does.
  void limit_pages(int pages);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::host
