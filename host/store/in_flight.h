#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <tuple>

namespace powbench::host {

/// Shots that one open store of this program has begun and not ended. Of one thread; what the others of the program
/// have begun is seen by all.
class InFlight {
 public:
  explicit InFlight(std::string file) : file_(std::move(file)) {}
  ~InFlight();
  InFlight(const InFlight&) = delete;
  InFlight& operator=(const InFlight&) = delete;

  void begin(std::int64_t campaign, int number);
  void end(std::int64_t campaign, int number);
  /// Another open store of this program has begun it.
  bool elsewhere(std::int64_t campaign, int number) const;

 private:
  using Shot = std::tuple<std::string, std::int64_t, int>;

  std::string file_;
  std::set<Shot> own_;
};

}  // namespace powbench::host
