#include "sim/team.h"

#include <atomic>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <thread>
#include <vector>

namespace powbench::sim {
namespace {

/// Waits a short while awake, because jobs are often shorter than a sleep, then asleep.
template <class T>
T wait_change(const std::atomic<T>& value, T old) {
  constexpr int awake = 2000;
  for (int k = 0; k < awake; ++k)
    if (const T now = value.load(std::memory_order_acquire); now != old) return now;
  value.wait(old, std::memory_order_acquire);
  return value.load(std::memory_order_acquire);
}

}  // namespace

struct Team::Impl {
  std::vector<std::thread> threads;
  std::vector<std::exception_ptr> failures;
  const std::function<void(int)>* job = nullptr;
  std::atomic<std::uint32_t> round{0};
  std::atomic<int> busy{0};
  bool ending = false;  ///< published with `round`

  void work(int worker) {
    try {
      (*job)(worker);
    } catch (...) {
      failures[static_cast<std::size_t>(worker)] = std::current_exception();
    }
  }

  void serve(int worker) {
    std::uint32_t seen = 0;
    while (true) {
      seen = wait_change(round, seen);
      if (ending) return;
      work(worker);
      if (busy.fetch_sub(1, std::memory_order_acq_rel) == 1) busy.notify_one();
    }
  }

  void call_all() {
    round.fetch_add(1, std::memory_order_acq_rel);
    round.notify_all();
  }
};

Team::Team(int workers) : impl_(std::make_unique<Impl>()) {
  if (workers < 1) throw std::invalid_argument("a team needs at least one worker");
  impl_->failures.resize(static_cast<std::size_t>(workers));
  for (int k = 1; k < workers; ++k) impl_->threads.emplace_back([impl = impl_.get(), k] { impl->serve(k); });
}

Team::~Team() {
  impl_->ending = true;
  impl_->call_all();
  for (auto& thread : impl_->threads) thread.join();
}

int Team::workers() const {
  return static_cast<int>(impl_->failures.size());
}

void Team::run(const std::function<void(int)>& job) {
  impl_->job = &job;
  impl_->busy.store(workers() - 1, std::memory_order_release);
  impl_->call_all();
  impl_->work(0);
  for (int left = impl_->busy.load(std::memory_order_acquire); left > 0;)
    left = wait_change(impl_->busy, left);
  std::exception_ptr first;
  for (auto& failure : impl_->failures) {
    if (failure && !first) first = failure;
    failure = nullptr;
  }
  if (first) std::rethrow_exception(first);
}

void for_each_index(Team& team, int count, const std::function<void(int)>& body) {
  std::atomic<int> next{0};
  team.run([&](int) {
    for (int k = next.fetch_add(1); k < count; k = next.fetch_add(1)) body(k);
  });
}

}  // namespace powbench::sim
