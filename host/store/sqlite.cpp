#include "host/store/sqlite.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <memory>
#include <vector>

#include "host/store/store.h"

namespace powbench::host::sqlite {

void fail(int code, const std::string& path, const std::string& detail, int disk_error) {
  // a full disk shows as an input/output error where SQLite had not expected to need room
  if (disk_error == ENOSPC || disk_error == EDQUOT) code = SQLITE_FULL;
  switch (code & 0xFF) {
    case SQLITE_FULL:
      throw StoreError(path + ": no room left on the disk; free some, then go on");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw StoreError(path + ": another program is writing to it; wait for it or use another file");
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      throw StoreError(path + ": the file is damaged (" + detail + "); restore it from a copy");
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
      throw StoreError(path + ": cannot be opened for writing (" + detail +
                       "); check the folder and its permissions");
    case SQLITE_IOERR:
      throw StoreError(path + ": the disk does not read or write (" + detail + "); check it before going on");
    default:
      throw StoreError(path + ": " + detail);
  }
}

std::size_t first_bytes(const std::string& path, std::span<unsigned char> into) {
  sqlite3_vfs* vfs = sqlite3_vfs_find(nullptr);
  std::vector<char> full(static_cast<std::size_t>(vfs->mxPathname) + 1);
  if (vfs->xFullPathname(vfs, path.c_str(), static_cast<int>(full.size()), full.data()) != SQLITE_OK)
    return 0;
  const std::unique_ptr<const char, void (*)(const char*)> name(
      sqlite3_create_filename(full.data(), "", "", 0, nullptr), sqlite3_free_filename);
  const auto memory = std::make_unique<std::byte[]>(static_cast<std::size_t>(vfs->szOsFile));
  auto* file = reinterpret_cast<sqlite3_file*>(memory.get());
  int given = 0;
  std::size_t there = 0;
  if (vfs->xOpen(vfs, name.get(), file, SQLITE_OPEN_READONLY | SQLITE_OPEN_MAIN_DB, &given) == SQLITE_OK) {
    sqlite3_int64 size = 0;
    if (file->pMethods->xFileSize(file, &size) == SQLITE_OK)
      there = std::min(into.size(), static_cast<std::size_t>(size));
    if (file->pMethods->xRead(file, into.data(), static_cast<int>(there), 0) != SQLITE_OK) there = 0;
  }
  if (file->pMethods != nullptr) file->pMethods->xClose(file);
  return there;
}

namespace {

/// Path as a URI that opens the file as it stands.
std::string immutable_uri(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path) {
    if (c == '%' || c == '?' || c == '#') {
      uri += '%';
      uri += "0123456789ABCDEF"[static_cast<unsigned char>(c) >> 4];
      uri += "0123456789ABCDEF"[static_cast<unsigned char>(c) & 15U];
    } else {
      uri += c;
    }
  }
  return uri + "?immutable=1";
}

}  // namespace

Database::Database(const std::string& path, int flags, Immutable)
    : Database(path, immutable_uri(path), flags | SQLITE_OPEN_URI) {}

Database::Database(const std::string& path, const std::string& name, int flags) : path_(path) {
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &raw, flags, nullptr);
  db_.reset(raw);
  if (code != SQLITE_OK)
    sqlite::fail(code, path_, raw ? sqlite3_errmsg(raw) : sqlite3_errstr(code),
                 raw ? sqlite3_system_errno(raw) : 0);
  sqlite3_busy_timeout(raw, 5000);
}

void Database::write_log_back(bool on) {
  sqlite3_db_config(db_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, on ? 0 : 1, nullptr);
}

void Database::fail() const {
  sqlite3* db = db_.get();
  const int code = sqlite3_errcode(db);
  const bool disk = (code & 0xFF) == SQLITE_IOERR || (code & 0xFF) == SQLITE_CANTOPEN;
  sqlite::fail(code, path_, sqlite3_errmsg(db), disk ? sqlite3_system_errno(db) : 0);
}

void Database::run(const std::string& sql) {
  if (sqlite3_exec(db_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

std::int64_t Database::number(const std::string& sql) const {
  Statement s(*this, sql);
  return s.step() ? s.integer(0) : 0;
}

Statement::Statement(const Database& db, std::string_view sql) : db_(db) {
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(db.handle(), sql.data(), static_cast<int>(sql.size()), &raw, nullptr) != SQLITE_OK)
    db.fail();
  s_.reset(raw);
}

Statement& Statement::bind(std::int64_t value) {
  if (sqlite3_bind_int64(s_.get(), next_++, value) != SQLITE_OK) db_.fail();
  return *this;
}
Statement& Statement::bind(double value) {
  if (sqlite3_bind_double(s_.get(), next_++, value) != SQLITE_OK) db_.fail();
  return *this;
}
Statement& Statement::bind(std::string_view value) {
  if (sqlite3_bind_text(s_.get(), next_++, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT) !=
      SQLITE_OK)
    db_.fail();
  return *this;
}
Statement& Statement::bind_blob(std::span<const std::uint8_t> bytes) {
  if (sqlite3_bind_blob64(s_.get(), next_++, bytes.data(), bytes.size(), SQLITE_STATIC) != SQLITE_OK)
    db_.fail();
  return *this;
}

Statement& Statement::bind_column(const Statement& row, int column) {
  if (sqlite3_bind_value(s_.get(), next_++, sqlite3_column_value(row.s_.get(), column)) != SQLITE_OK)
    db_.fail();
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(s_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) db_.fail();
  return false;
}

std::string Statement::text(int column) const {
  const auto* chars = reinterpret_cast<const char*>(sqlite3_column_text(s_.get(), column));
  return chars ? std::string(chars, static_cast<std::size_t>(sqlite3_column_bytes(s_.get(), column)))
               : std::string{};
}

std::span<const std::uint8_t> Statement::blob(int column) const {
  const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(s_.get(), column));
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(s_.get(), column))};
}

}  // namespace powbench::host::sqlite
