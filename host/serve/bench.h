#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/gather/scene.h"
#include "host/run/machine_clock.h"
#include "host/store/store.h"

namespace powbench::host {

/// What was asked cannot be done now; one sentence.
class NotNow : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// How a stop ended. `off`: the rig itself has said, after the stop, that it is neither armed nor firing.
struct StopAnswer {
  bool off = false;
  std::string text;  ///< one sentence
  double ms = 0.0;   ///< from the call to the rig's word
};

/// One rig and one store, worked on by one thread: single closings and plans. Beside it a line that looks on and a
/// line that does nothing but stop. Every function may be called from any thread.
class Bench {
 public:
  /// Opens rig and store; throws RigError, StoreError. `scene`: the plan that single closings take their conditions
  /// from. `changed` is called, from any thread, whenever state() has changed, `recorded` when frame() has. `clock`:
  /// of the pauses between shots and of the time left; outlives the bench.
  Bench(
      const std::string& rig_uri, const Scene& scene, const std::string& database,
      std::function<void()> changed, std::function<void()> recorded = [] {}, Clock& clock = machine_clock());
  ~Bench();
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  /// Everything a person wants to see of rig and job, as JSON (docs/how-to/serve.md).
  std::string state() const;
  Scene scene() const;
  const std::string& database() const;
  /// The newest record, as record_frame() packs it; nothing before the first one.
  std::shared_ptr<const std::string> frame() const;
  /// Every attribute of the rig. Throws RigError.
  std::vector<std::pair<std::string, std::string>> attributes() const;
  /// Of a simulated rig the file it was started with.
  const RigFile& rig_file() const;
  const std::string& rig_uri() const;

  // Each throws NotNow while another job is on, a stop is under way, or one has come since the closing was `asked`
  // for: what waited in a queue or for a search is not fired behind a STOP.
  using Instant = std::chrono::steady_clock::time_point;
  static Instant now() { return std::chrono::steady_clock::now(); }

  /// One closing at `angle`, rad, stored in this plan's campaign of single closings.
  void fire(double angle, Instant asked = now());
  /// That closing may come next: its simulation is made meanwhile. Changes nothing that can be seen; nothing is done
  /// while a job is on.
  void prepare(double angle);
  /// One closing whose contacts touch at `touch_angle` of the mains, rad, after the simulator. Throws NotNow where
  /// there is none. Meanwhile the state says `aiming`, and nothing else is fired.
  void fire_at_touch(double touch_angle, Instant asked = now());
  /// The scene is that of single closings from now on.
  void adopt(const Scene&);
  /// Every shot of the scene; the scene is that of single closings from now on.
  void run(const Scene&, Instant asked = now());

  /// What is missing of a campaign whose plan was not fired to its end, on the rig that began it and with its
  /// specimen. Throws NotNow with the reason where that cannot be.
  void resume(const CampaignInfo&, Instant asked = now());

  /// Between two shots: wait, or go on. Throws NotNow when no plan runs.
  void pause(bool);
  /// The shot in flight is the last one. Throws NotNow when no plan runs.
  void end();
  /// Ends the latched fault `number` of the rig, which a person has read, once its cause is gone. Nothing is switched
  /// on. Returns when the rig reports no fault; throws NotNow with the reason where it does not, where another fault
  /// is latched, and while a job is on.
  void acknowledge(int number);
  /// Coil off now, job over. Returns when the rig has confirmed it or has not for 2 s. Never throws.
  StopAnswer stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::host
