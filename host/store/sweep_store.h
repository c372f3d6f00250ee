#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// Sweeps in the store: one row for the design, one for each block of points.

namespace powbench::host {

struct SweepInfo {
  std::int64_t id = 0;
  std::string created;  ///< UTC, ISO 8601
  std::string design;   ///< JSON
  std::string design_hash;
  std::int64_t points = 0;
  std::string columns;  ///< separated by blanks
  std::string program_version;
};

struct SweepBlock {
  std::int64_t first = 0, count = 0;
  std::vector<double> numbers;  ///< count x columns
};

/// Opens the same file as `Store`, with the same checks; throws StoreError.
class SweepStore {
 public:
  explicit SweepStore(const std::string& path);
  ~SweepStore();
  SweepStore(const SweepStore&) = delete;
  SweepStore& operator=(const SweepStore&) = delete;

  /// The sweep of this design, made if missing; id and created of `info` are ignored.
  std::int64_t open_sweep(const SweepInfo& info);
  std::vector<SweepInfo> sweeps() const;

  /// One transaction. A block that is there already is kept as it is.
  void put(std::int64_t sweep, std::span<const SweepBlock> blocks);
  /// In ascending order; throws StoreError when a block does not match its seal.
  std::vector<SweepBlock> blocks(std::int64_t sweep) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::host
