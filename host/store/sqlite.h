#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>

/// SQLite with the lifetimes of C++: inside host/store only.

namespace powbench::host::sqlite {

/// Throws StoreError in words for `code`; `path` names the file, `disk_error` is the errno behind it (0: unknown).
[[noreturn]] void fail(int code, const std::string& path, const std::string& detail, int disk_error = 0);

/// The first bytes of a file into `into`; how many there are, 0 where it cannot be opened. Read through SQLite's own
/// files: POSIX takes all locks of a process off a file as soon as it closes any other descriptor of it, and the
/// store may be in use on another thread.
std::size_t first_bytes(const std::string& path, std::span<unsigned char> into);

class Database {
 public:
  struct Immutable {};  ///< tag: the file is taken as it stands, without log and locks

  Database(const std::string& path, int flags) : Database(path, path, flags) {}
  Database(const std::string& path, int flags, Immutable);
  void run(const std::string& sql);
  std::int64_t number(const std::string& sql) const;
  sqlite3* handle() const { return db_.get(); }
  const std::string& path() const { return path_; }
  std::int64_t last_id() const { return sqlite3_last_insert_rowid(db_.get()); }
  int changes() const { return sqlite3_changes(db_.get()); }  ///< rows changed by the last statement
  [[noreturn]] void fail() const;
  /// Whether closing copies the log into the file; off until write_log_back(true).
  void write_log_back(bool on);

 private:
  Database(const std::string& path, const std::string& name, int flags);

  struct Close {
    void operator()(sqlite3* db) const { sqlite3_close(db); }
  };
  std::string path_;
  std::unique_ptr<sqlite3, Close> db_;
};

/// A prepared statement: bind in order, step, read columns.
class Statement {
 public:
  Statement(const Database& db, std::string_view sql);

  Statement& bind(std::int64_t);
  Statement& bind(int value) { return bind(static_cast<std::int64_t>(value)); }
  Statement& bind(double);
  Statement& bind(std::string_view);
  Statement& bind(const std::string& s) { return bind(std::string_view(s)); }
  Statement& bind(const char* s) { return bind(std::string_view(s)); }
  Statement& bind_blob(std::span<const std::uint8_t>);  ///< the bytes must live until step()

  /// A value of another statement's row, whatever its type; `row` must stay on that row until step().
  Statement& bind_column(const Statement& row, int column);

  bool step();  ///< true: a row is there
  void run() { step(); }

  std::int64_t integer(int column) const { return sqlite3_column_int64(s_.get(), column); }
  /// NaN for NULL; a NaN is bound as NULL.
  double real(int column) const {
    return sqlite3_column_type(s_.get(), column) == SQLITE_NULL ? std::numeric_limits<double>::quiet_NaN()
                                                                : sqlite3_column_double(s_.get(), column);
  }
  std::string text(int column) const;
  std::span<const std::uint8_t> blob(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* s) const { sqlite3_finalize(s); }
  };
  const Database& db_;
  std::unique_ptr<sqlite3_stmt, Finalize> s_;
  int next_ = 1;
};

/// BEGIN IMMEDIATE until commit(); rolled back otherwise.
class Transaction {
 public:
  explicit Transaction(Database& db) : db_(db) { db_.run("BEGIN IMMEDIATE"); }
  ~Transaction() {
    if (!done_) sqlite3_exec(db_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit() {
    db_.run("COMMIT");
    done_ = true;
  }

 private:
  Database& db_;
  bool done_ = false;
};

}  // namespace powbench::host::sqlite
