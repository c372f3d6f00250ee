#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>

#include "host/serve/ahead.h"
#include "host/serve/bench.h"
#include "host/serve/later.h"
#include "host/serve/looker.h"
#include "host/serve/stoppable_rig.h"
#include "host/serve/touch.h"
#include "rigs/rig_watch.h"

namespace powbench::host {

/// The state of a bench and its threads: one that fires, the looker's, and whoever calls. Parts in bench.cpp
/// (firing), bench_stop.cpp (stopping), bench_single.cpp (single closings) and bench_state.cpp (what others see).
struct Bench::Impl final : RunWatcher {
  struct Job {
    Scene scene;
    std::vector<PlannedShot> shots;
    std::int64_t campaign = 0;  ///< 0: a new one
    bool single = false;
    std::optional<TouchAim::Aim> aim;  ///< of a closing at touch
    std::size_t before = 0;            ///< shots that the campaign has already
    std::size_t done = 0, outside = 0;
    std::size_t lacking = 0;  ///< of `done`: without a record
    std::string why;          ///< it ends early, one sentence
    std::size_t cut = 0;      ///< of `done`: stopped in the middle, so still to be fired
    double begun = 0;         ///< of `clock`, s; without what a person paused
    double pauses = 0;        ///< s that the plan's pauses between shots have taken
    double pause_left = 0;    ///< s of the one that is on
    std::string doing = "waiting";
    bool stopped_late = false;  ///< a stop came when all of it was fired
  };

  Impl(const std::string& rig_uri, const Scene& first, const std::string& database_file,
       std::function<void()> on_change, std::function<void()> on_record, Clock& clock);
  ~Impl() override;

  void work();
  std::string run_job(const Job&);
  rigs::RigInfo rig_now() const;
  void doing(const char*);
  bool is_ending() const;  ///< the program ends
  bool stopped() override { return stop_flag || end_asked; }
  void resting(double left) override;
  void between() override;
  void stored(std::int64_t shot) override;

  StopAnswer stop();
  void acknowledge(int number);
  void begin(Job, Instant asked);
  Job single(double angle) const;
  void complete(Job& single) const;  ///< what it takes from the plan in force; the lock is held
  void prepare(double angle);
  static std::optional<StoredShot> simulated(const Store&, const StoredShot& beside);
  static Ahead::Key key_of(const Job& single);
  void simulate_ahead(const Job& single);
  void predict_later(const Store&, const Job& single);
  TouchAim::Aim aim(double touch_angle);

  void log_line(const std::string&);  ///< the lock is held
  void say(const std::string&);
  std::string state() const;
  std::string doing_words(const Job&) const;
  std::optional<double> seconds_left(const Job&) const;  ///< nothing where it is not known; the lock is held

  const std::string uri, database;
  const std::function<void()> changed, recorded;
  Clock& clock;
  const RigFile sensors;
  const rigs::Endpoint endpoint;

  mutable std::mutex mutex;
  std::condition_variable wake;
  Scene scene;
  rigs::RigInfo info;  ///< when the bench was started
  struct Ended {
    std::string name;
    std::int64_t campaign = 0;
    std::size_t done = 0, shots = 0;  ///< done: with a record
    std::string why;                  ///< it was not fired to its end
  };
  std::optional<Job> job;
  std::optional<Ended> ended;  ///< the plan that ended last, until something else begins
  bool paused = false, waiting = false,
       ending = false;  ///< paused: asked for; waiting: and no shot is in flight
  std::int64_t single_campaign = 0, newest_campaign = 0, newest_shot = 0;
  std::optional<TouchAim::Aim> newest_aim;  ///< of newest_shot, where its touch was asked for
  std::int64_t newest_prediction = 0;       ///< simulated shot whose uncertainty was told last
  int singles = 0;                          ///< single closings of this plan, so far
  std::optional<StopAnswer> last_stop;
  std::vector<StoredShot> interrupted;  ///< on when the program ended before; set by the constructor alone
  std::deque<std::string> log;
  std::shared_ptr<const std::string> frame;  ///< of the newest record

  std::mutex aim_mutex;
  std::optional<TouchAim> touch;

  std::optional<Instant> aiming;  ///< when the closing at touch was asked for whose angle is sought
  std::atomic<Instant> stopped_at = Instant::min();
  std::atomic<bool> stop_flag = false, end_asked = false, inside = false;
  bool acknowledging = false;  ///< the line of the thread that fires is in use
  std::unique_ptr<StoppableRig> rig;
  std::atomic<int> stopping = 0;
  std::mutex stop_mutex;  ///< one stop at a time; `mutex` is taken inside
  std::unique_ptr<rigs::RigWatch> stop_line;
  rigs::RigInfo job_rig;  ///< the one that the job fires: no other can confirm a stop
  std::unique_ptr<Looker> looker;
  Ahead ahead;
  std::function<void()>
      with_shot;  ///< of the thread that fires: what is stored with the shot that it has just stored
  std::thread worker;
  Later later;  ///< last: its tasks use what stands above
};

}  // namespace powbench::host
