#pragma once

#include <functional>
#include <memory>

/// Threads that work on one job at a time. What each worker does depends on its number alone, so results can be made
/// independent of the number of threads by summing in a fixed order afterwards.

namespace powbench::sim {

class Team {
 public:
  /// `workers` >= 1, the caller counted; throws std::invalid_argument otherwise.
  explicit Team(int workers);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int workers() const;

  /// Calls job(worker) once for each worker 0 .. workers() - 1, number 0 on the caller's thread; returns when all
  /// have returned. Rethrows the exception of the lowest-numbered worker that threw. Not re-entrant.
  void run(const std::function<void(int)>& job);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Calls body(k) for k = 0 .. count - 1, spread over the team in the order the workers get to it.
void for_each_index(Team&, int count, const std::function<void(int)>& body);

}  // namespace powbench::sim
