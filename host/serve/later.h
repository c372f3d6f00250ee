#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace powbench::host {

/// Tasks one after another, on a thread that the machine runs after all others: nobody waits for them. Every function
/// may be called from any thread.
class Later {
 public:
  static constexpr std::size_t most_waiting = 50;

  Later();
  /// Waits for the task that is on, which may look at `ending`; those that wait are dropped.
  ~Later();
  Later(const Later&) = delete;
  Later& operator=(const Later&) = delete;

  /// Of more than `most_waiting` tasks the oldest are dropped. A task does not throw.
  void add(std::function<void()> task);

  /// A long task looks at this between its steps and gives up.
  bool ending() const { return ending_; }

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable news_;
  std::deque<std::function<void()>> tasks_;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

}  // namespace powbench::host
