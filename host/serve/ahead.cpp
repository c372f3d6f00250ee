#include "host/serve/ahead.h"

#include <utility>

namespace powbench::host {

Ahead::Ahead() : thread_([this] { work(); }) {}

Ahead::~Ahead() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  news_.notify_all();
  thread_.join();
}

void Ahead::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    news_.wait(lock, [this] { return ending_ || wanted_; });
    if (ending_) return;
    making_ = std::exchange(wanted_, std::nullopt);
    const auto make = std::exchange(make_, nullptr);
    lock.unlock();
    Made made;
    std::exception_ptr failed;
    try {
      made = std::make_shared<const Closing>(make());
    } catch (...) {
      failed = std::current_exception();
    }
    lock.lock();
    key_ = std::exchange(making_, std::nullopt);
    made_ = std::move(made);
    failed_ = failed;
    news_.notify_all();
  }
}

void Ahead::want(const Key& key, std::function<Closing()> make) {
  {
    const std::scoped_lock lock(mutex_);
    if (making_ == key || (!making_ && key_ == key)) {
      wanted_.reset();  // an older wish would replace it
      return;
    }
    wanted_ = key;
    make_ = std::move(make);
  }
  news_.notify_all();
}

Ahead::Made Ahead::found(const Key& key) const {
  if (key_ != key) return {};
  if (failed_) std::rethrow_exception(failed_);
  return made_;
}

Ahead::Made Ahead::ready(const Key& key) {
  const std::scoped_lock lock(mutex_);
  return found(key);
}

Ahead::Made Ahead::wait(const Key& key) {
  std::unique_lock lock(mutex_);
  news_.wait(lock, [&] { return ending_ || (wanted_ != key && making_ != key); });
  return found(key);
}

}  // namespace powbench::host
