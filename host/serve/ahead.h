#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/events.h"
#include "rigs/simulated_record.h"

namespace powbench::host {

/// The simulation beside a single closing, made before it is needed: while a person still looks at the angle, else
/// while the rig fires. One thread; of several wishes the newest counts. Every function may be called from any
/// thread.
class Ahead {
 public:
  /// All that the simulation depends on: equal keys give the same closing, bit for bit.
  struct Key {
    std::string plan_hash, specimen_hash;
    double angle = 0;  ///< rad
    std::uint64_t seed = 0;
    bool operator==(const Key&) const = default;
  };
  struct Closing {
    rigs::SimulatedClosing simulated;
    Events events;
  };
  using Made = std::shared_ptr<const Closing>;

  Ahead();
  ~Ahead();
  Ahead(const Ahead&) = delete;
  Ahead& operator=(const Ahead&) = delete;

  /// Makes it, unless it is there or being made; what was wanted before and is not yet begun is forgotten.
  void want(const Key&, std::function<Closing()> make);
  /// Nothing where it is not there yet. Throws what `make` threw.
  Made ready(const Key&);
  /// Waits for it; nothing where nobody wants it any more. Throws what `make` threw.
  Made wait(const Key&);

 private:
  void work();
  Made found(const Key&) const;  ///< the lock is held

  std::mutex mutex_;
  std::condition_variable news_;
  bool ending_ = false;
  std::optional<Key> wanted_, making_, key_;  ///< the newest wish, the one at work, the one that is there
  std::function<Closing()> make_;
  Made made_;
  std::exception_ptr failed_;
  std::thread thread_;
};

}  // namespace powbench::host
