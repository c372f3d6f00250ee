#include "host/store/begun_rows.h"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>

#include "host/store/json.h"
#include "host/store/rows.h"
#include "host/store/seal.h"

namespace powbench::host {

using sqlite::Database;
using sqlite::Statement;

namespace {

/// Whether another program may fire it. A row with this program's process id is its own, that of one before it, or that
/// of another container: what is its own, InFlight knows.
bool may_run(const Firer& firer, const std::string& started) {
  const auto day = std::chrono::system_clock::now() - std::chrono::hours(24);
  if (started < utc_text(day)) return false;  // no shot lasts so long, and process ids come again
  const Firer own = this_program();
  if (firer.machine != own.machine) return true;
  if (firer.process == own.process) return false;
  return kill(static_cast<pid_t>(firer.process), 0) == 0 || errno != ESRCH;
}

std::string begun_seal(const StoredShot& s, const std::string& conditions, const Firer& firer) {
  return Seal()
      .add(s.campaign)
      .add(s.number)
      .add(s.repeat)
      .add(s.angle_deg)
      .add(conditions)
      .add(s.started)
      .add(firer.machine)
      .add(firer.process)
      .hex();
}

}  // namespace

Firer this_program() {
  std::array<char, 256> text{};
  return {gethostname(text.data(), text.size() - 1) == 0 ? text.data() : "", getpid()};
}

void insert_begun(Database& db, const StoredShot& shot, const Firer& firer) {
  const std::string conditions = to_json(shot.conditions);
  Statement(db, "INSERT OR REPLACE INTO begun VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(shot.campaign)
      .bind(shot.number)
      .bind(shot.repeat)
      .bind(shot.angle_deg)
      .bind(conditions)
      .bind(shot.started)
      .bind(firer.machine)
      .bind(firer.process)
      .bind(begun_seal(shot, conditions, firer))
      .run();
}

void remove_begun(Database& db, std::int64_t campaign, int number) {
  Statement(db, "DELETE FROM begun WHERE campaign_id = ? AND number = ?").bind(campaign).bind(number).run();
}

std::vector<BegunRow> select_begun(const Database& db) {
  std::vector<BegunRow> list;
  Statement s(db, "SELECT * FROM begun ORDER BY campaign_id, number");
  while (s.step()) {
    BegunRow row;
    row.shot.campaign = s.integer(0);
    row.shot.number = static_cast<int>(s.integer(1));
    row.shot.repeat = static_cast<int>(s.integer(2));
    row.shot.angle_deg = s.real(3);
    row.shot.conditions = stored_json([&] { return conditions_from_json(s.text(4)); });
    row.shot.started = s.text(5);
    const Firer firer{s.text(6), s.integer(7)};
    check_seal(begun_seal(row.shot, s.text(4), firer), s.text(8),
               "the shot begun in campaign " + std::to_string(row.shot.campaign));
    row.running = may_run(firer, row.shot.started);
    list.push_back(std::move(row));
  }
  return list;
}

}  // namespace powbench::host
