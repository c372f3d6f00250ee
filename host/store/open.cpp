#include "host/store/open.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <span>

#include "host/store/migrations.h"

namespace powbench::host {

namespace fs = std::filesystem;
using sqlite::Database;

namespace {

constexpr std::size_t header_bytes = 100;
using Header = std::array<unsigned char, header_bytes>;

/// Big-endian field of the SQLite header (file format, section 1.3).
std::uint32_t field(const Header& h, std::size_t at) {
  return static_cast<std::uint32_t>(h[at]) << 24 | static_cast<std::uint32_t>(h[at + 1]) << 16 |
         static_cast<std::uint32_t>(h[at + 2]) << 8 | h[at + 3];
}

bool has_content(const fs::path& file) {
  std::error_code ignored;
  const auto size = fs::file_size(file, ignored);
  return !ignored && size > 0;
}

void refuse_newer(const std::string& path, int version) {
  if (version > Store::schema_version)
    throw StoreError(path + ": made by a newer powbench (schema " + std::to_string(version) +
                     ", this one knows " + std::to_string(Store::schema_version) + "); update the program");
}

/// Nothing in it that no editor would write.
bool is_text(std::span<const unsigned char> bytes) {
  return std::all_of(bytes.begin(), bytes.end(),
                     [](unsigned char c) { return (c >= ' ' && c != 127) || (c >= '\t' && c <= '\r'); });
}

void inspect(const std::string& path) {
  const auto size = fs::file_size(path);
  Header h{};
  const std::size_t there = sqlite::first_bytes(path, h);
  if (there == 0) throw StoreError(path + ": cannot be read; check its permissions");
  if (std::memcmp(h.data(), "SQLite format 3", std::min<std::size_t>(there, 16)) != 0)
    throw WrongStore(path + (is_text(std::span(h).first(there))
                                 ? ": a text file, not a powbench store; name another file"
                                 : ": not a powbench store; name another file"));
  if (there < header_bytes)
    throw StoreError(path + ": the file is damaged (cut off); restore it from a copy");
  if (field(h, 68) != Store::application_id)
    throw WrongStore(path + ": a database of another program; name another file");
  refuse_newer(path, static_cast<int>(field(h, 60)));
  const std::uint64_t page = (h[16] << 8 | h[17]) == 1 ? 65536U : static_cast<unsigned>(h[16] << 8 | h[17]);
  // an unfinished checkpoint may leave the file short, but then the log holds the rest
  if (!has_content(path + "-wal") && size < field(h, 28) * page)
    throw StoreError(path + ": the file is damaged (cut off); restore it from a copy");
}

void migrate(Database& db) {
  const auto known = [&] { return static_cast<std::size_t>(db.number("PRAGMA user_version")); };
  while (known() < store_migrations.size()) {
    sqlite::Transaction t(db);
    const std::size_t version = known();  // again, inside: another process may have been quicker
    if (version < store_migrations.size()) {
      db.run(std::string(store_migrations[version]));
      db.run("PRAGMA user_version = " + std::to_string(version + 1));
    }
    t.commit();
  }
}

/// The bytes of a file are on the disk when this returns.
void flush(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool flushed = file >= 0 && fsync(file) == 0;
  const int trouble = errno;
  if (file >= 0) close(file);
  if (!flushed) sqlite::fail(SQLITE_IOERR, path, "flush", trouble);
}

/// A new store is made aside and renamed into place: a file under its final name is always whole.
void create(const std::string& path) {
  const std::string aside = aside_file(path, ".new-");
  {
    Database db(aside, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
    // nobody knows the file yet: one flush at the end is enough
    db.run("PRAGMA synchronous = OFF");
    db.run("PRAGMA journal_mode = MEMORY");
    db.run("PRAGMA application_id = " + std::to_string(Store::application_id));
    migrate(db);
    db.run("PRAGMA journal_mode = WAL");
  }
  flush(aside);
  put_in_place(aside, path);
}

/// Read-only. A log beside the file needs its index, which needs a folder that can be written; without a log the file
/// is all there is and can be taken as it stands.
Database open_for_reading(const std::string& path) {
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  const bool writable = access(path.c_str(), W_OK) == 0 && access(folder.c_str(), W_OK) == 0;
  if (!writable && !has_content(path + "-wal"))
    return Database(path, SQLITE_OPEN_READONLY, Database::Immutable{});
  // a reader that may write clears the log away behind itself; query_only keeps it from changing anything
  Database db(path, writable ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY);
  db.run("PRAGMA query_only = ON");
  return db;
}

}  // namespace

namespace {

/// A reader of an older store: the file is migrated first, if it may be written.
Database bring_up_to_date(const std::string& path, Database old) {
  if (access(path.c_str(), W_OK) != 0)
    throw StoreError(path + ": made by an older powbench and cannot be brought up to date: make it writable");
  { const Database closed = std::move(old); }
  {
    Database db(path, SQLITE_OPEN_READWRITE);
    migrate(db);
  }
  return open_for_reading(path);
}

}  // namespace

std::string aside_file(const std::string& path, const std::string& mark) {
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  if (!fs::is_directory(folder))
    throw WrongStore(path + ": there is no folder " + folder.string() + "; make it first");
  const std::string beginning = fs::path(path).filename().string() + mark;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(beginning)) continue;
    const pid_t owner = static_cast<pid_t>(std::atol(name.c_str() + beginning.size()));
    if (owner <= 0 || (kill(owner, 0) != 0 && errno == ESRCH)) fs::remove(entry.path());
  }
  const std::string aside = path + mark + std::to_string(getpid());
  fs::remove(aside);
  return aside;
}

bool put_in_place(const std::string& aside, const std::string& path) {
  // a link is refused where somebody else was quicker; an empty file in the way is replaced
  const bool linked = !has_content(path) && link(aside.c_str(), path.c_str()) == 0;
  if (linked || has_content(path)) {
    fs::remove(aside);
    return linked;
  }
  fs::rename(aside, path);
  return true;
}

void check_table(const Database& db, const std::string& table) {
  sqlite::Statement check(db, "PRAGMA integrity_check(" + table + ")");
  if (!check.step() || check.text(0) != "ok")
    throw StoreError(db.path() + ": the file is damaged (" + check.text(0) + "); restore it from a copy");
}

Database open_store(const std::string& path, Store::Mode mode) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) throw WrongStore(path + ": is a folder; name a file");
  if (!has_content(path)) {
    if (mode == Store::Mode::read_only)
      throw WrongStore(path + ": no such store; check its name, or make it by run, sim or import");
    create(path);
  }
  inspect(path);
  const bool has_log = has_content(path + "-wal");
  Database db =
      mode == Store::Mode::read_only ? open_for_reading(path) : Database(path, SQLITE_OPEN_READWRITE);
  if (has_log) db.write_log_back(false);  // nothing goes from the log into a file that may still be refused
  // a flipped bit in an index must not hide a campaign or a shot; the other tables are checked before their indices
  // are used, and channels are under the seal of their record
  for (const char* table : {"campaign", "shot"}) check_table(db, table);
  refuse_newer(path, static_cast<int>(db.number("PRAGMA user_version")));  // it may stand in the log only
  db.write_log_back(true);
  if (mode == Store::Mode::read_write) {
    db.run("PRAGMA synchronous = FULL");  // a stored shot survives a power cut; costs one flush a shot
    migrate(db);
  } else if (db.number("PRAGMA user_version") < Store::schema_version) {
    return bring_up_to_date(path, std::move(db));
  }
  db.run(
      "PRAGMA foreign_keys = ON");  // behind the migrations, which may replace a table that others refer to
  return db;
}

}  // namespace powbench::host
