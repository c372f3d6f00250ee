#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// A PostgreSQL connection with the lifetimes of C++: inside host/store/central only. All values travel in binary, so
/// that a double arrives as it was. Throws ServerError where the server is lost, WrongStore for what the user can
/// mend.

namespace powbench::host::postgres {

/// Values of one statement, $1 first.
class Values {
 public:
  Values& integer(std::int64_t);
  Values& real(double);  ///< NaN becomes NULL, as in the store
  Values& text(std::string_view);
  Values& bytes(std::span<const std::uint8_t>);
  Values& flag(bool);

 private:
  friend class Connection;
  struct Value {
    unsigned type;
    bool null;
    std::string content;
  };
  Values& add(unsigned type, std::string content, bool null = false);
  std::vector<Value> list_;
};

/// What one statement returned.
class Rows {
 public:
  explicit Rows(std::shared_ptr<void> result) : result_(std::move(result)) {}
  int size() const;
  std::int64_t integer(int row, int column) const;
  double real(int row, int column) const;       ///< NaN for NULL
  std::string text(int row, int column) const;  ///< empty for NULL
  bool flag(int row, int column) const;
  std::span<const std::uint8_t> bytes(int row, int column) const;

 private:
  std::shared_ptr<void> result_;
};

class Connection {
 public:
  /// Connects; the search path is the schema powbench.
  explicit Connection(const std::string& address);
  const std::string& address() const { return address_; }

  /// Several statements without values.
  void script(const std::string& sql);
  /// The result of this statement; what was queued before is sent too.
  Rows run(const std::string& sql, const Values& = {});
  /// Sends a statement and does not wait; finish() returns the results of all since the last one, in their order.
  void queue(const std::string& sql, const Values&);
  std::vector<Rows> finish();

 private:
  [[noreturn]] void fail(void* result) const;
  [[noreturn]] void lost() const;
  const std::string& prepared(const std::string& sql, const Values&);

  std::string address_;
  std::shared_ptr<void> connection_;
  std::map<std::string, std::string> names_;  ///< of prepared statements
  std::vector<bool> queued_;                  ///< true: a statement, false: its preparation
};

/// BEGIN until commit(); the server rolls it back where the connection ends before.
class Transaction {
 public:
  explicit Transaction(Connection& c, const std::string& mode = "") : c_(c) { c_.run("BEGIN " + mode); }
  void commit() { c_.run("COMMIT"); }

 private:
  Connection& c_;
};

/// Makes the schema powbench, or brings it up to date, where `write`; refuses one of a newer program, or none where
/// it is only read.
void open_schema(Connection&, bool write);

}  // namespace powbench::host::postgres
