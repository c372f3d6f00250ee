#include "host/serve/later.h"

#include <sys/resource.h>

#include <utility>

namespace powbench::host {

Later::Later() : thread_([this] { work(); }) {}

Later::~Later() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;  // what runs looks at it: of the lowest priority it may take minutes beside other work
  }
  news_.notify_all();
  thread_.join();
}

void Later::add(std::function<void()> task) {
  {
    const std::scoped_lock lock(mutex_);
    tasks_.push_back(std::move(task));
    if (tasks_.size() > most_waiting) tasks_.pop_front();
  }
  news_.notify_all();
}

void Later::work() {
  constexpr int last = 19;
  setpriority(PRIO_PROCESS, 0, last);  // on Linux of this thread alone; refused, it is no harm
  std::unique_lock lock(mutex_);
  for (;;) {
    news_.wait(lock, [this] { return ending_ || !tasks_.empty(); });
    if (ending_) return;
    const auto task = std::move(tasks_.front());
    tasks_.pop_front();
    lock.unlock();
    task();
    lock.lock();
  }
}

}  // namespace powbench::host
