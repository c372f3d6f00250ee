#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

/// One study on many machines: points that do not know of each other, kept under the hash of all they depend on.

namespace powbench::host {

/// Part `index` of `of`, both from 1. Points, or blocks of points, go round: number k, from 0, is of part k % of + 1.
struct Shard {
  std::int64_t index = 1, of = 1;
  bool has(std::int64_t number) const { return number % of == index - 1; }
};

/// The points of one study: those in a store are read, the others computed and added. For many threads.
class Points {
 public:
  Points();  ///< without a store: all are computed, none is kept
  /// Opens `path` or makes it. `study`: one word. Throws StoreError as `Store` does.
  Points(const std::string& path, std::string study, Shard = {},
         std::string program = "");  ///< "": the version alone
  ~Points();
  Points(const Points&) = delete;
  Points& operator=(const Points&) = delete;

  bool stored() const { return impl_ != nullptr; }
  /// Only some of the points are wanted, and no result.
  bool part() const { return shard_.of > 1; }

  /// Content of the point that is a function of `basis` (specimen, conditions, seed, options, as text) and of the
  /// program's version; not there: from `compute`, and kept. Nothing: point `number`, from 0, is of another shard.
  /// Throws StoreError where a stored one does not match its seal.
  std::optional<std::string> get(std::int64_t number, const std::string& basis,
                                 const std::function<std::string()>& compute);

  /// Of the points so far: read, and computed.
  std::int64_t found() const { return found_; }
  std::int64_t computed() const { return computed_; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  Shard shard_;
  std::int64_t found_ = 0, computed_ = 0;
};

}  // namespace powbench::host
