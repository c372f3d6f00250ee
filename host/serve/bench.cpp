#include "host/serve/bench.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "core/origin.h"
#include "core/phase.h"
#include "core/version.h"
#include "host/run/simulate.h"
#include "host/serve/stoppable_rig.h"
#include "rigs/iio_rig.h"
#include "rigs/rig_watch.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr milliseconds connect_time{1500};
constexpr milliseconds stop_time{2000};
constexpr milliseconds look_interval{100};
constexpr std::size_t longest_log = 200;

double seconds_since(Clock::time_point t) {
  return std::chrono::duration<double>(Clock::now() - t).count();
}

}  // namespace

struct Bench::Impl final : RunWatcher {
  struct Job {
    Scene scene;
    std::vector<PlannedShot> shots;
    std::int64_t campaign = 0;  ///< 0: a new one
    bool single = false;
    std::size_t done = 0;
    Clock::time_point begun{};
    std::string doing = "waiting";
  };

  Impl(const std::string& rig_uri, const Scene& first, const std::string& database_file,
       std::function<void()> on_change)
      : uri(rig_uri),
        database(database_file),
        changed(std::move(on_change)),
        sensors(rig_file(rig_uri)),
        endpoint(rigs::endpoint(rig_uri, sensors.config,
                                sensors.specimen.empty() ? first.specimen : load_specimen(sensors))),
        scene(first) {
    Store(database, Store::Mode::read_write);  // there and sound, or the sentence that says what is wrong
    rig = std::make_unique<StoppableRig>(rigs::connect_iio(endpoint.uri), stop_flag, inside);
    info = rig->info();
    stop_line = std::make_unique<rigs::RigWatch>(endpoint.uri, connect_time);
    worker = std::thread([this] { work(); });
    looker = std::thread([this] { look(); });
  }

  ~Impl() override {
    {
      const std::scoped_lock lock(mutex);
      ending = true;
      end_asked = true;
      stop_flag = true;
    }
    wake.notify_all();
    if (inside) stop();
    worker.join();
    looker.join();
  }

  // ---- the thread that fires ----

  void work() {
    std::unique_lock lock(mutex);
    for (;;) {
      wake.wait(lock, [this] { return ending || job; });
      if (ending) return;
      Job now = *job;
      lock.unlock();
      std::string how;
      try {
        how = run_job(now);
      } catch (const std::exception& e) {
        how = e.what();
      }
      if (!how.empty()) say(how);
      lock.lock();
      job.reset();
      held = end_asked = false;
      lock.unlock();
      changed();
      lock.lock();
    }
  }

  std::string run_job(const Job& now) {
    Store store(database);
    std::int64_t campaign = now.campaign;
    if (campaign == 0) {
      CampaignInfo c = campaign_info(now.scene, uri, info.model + ", " + info.serial);
      c.origin = origin_of_kind(info.kind);
      campaign = store.create_campaign(c);
      if (const std::string late = note_calibration(store, campaign, info); !late.empty()) say(late);
    }
    {
      const std::scoped_lock lock(mutex);
      if (now.single) single_campaign = campaign;
      job->campaign = newest_campaign = campaign;
      job->begun = Clock::now();
      job->doing = "firing";
    }
    changed();
    RunOptions options = run_options(now.scene.plan);
    options.watcher = this;
    Progress silent("", now.shots.size(), Progress::Style::none);
    const RunSummary summary = run_campaign(store, campaign, now.shots, *rig, options, silent);
    if (!stopped() && summary.done() > 0) {
      doing("simulating");
      simulate_campaign(store, campaign, now.shots, now.scene.specimen, sensors.config, options, 1, silent,
                        rigs::simulate_record, now.single);
    }
    if (!now.single)
      say(fmt::format("plan {}: {} of {} shots recorded, {} outside limits{}{}", now.scene.plan.name,
                      summary.done(), summary.planned, summary.count(Outcome::fail),
                      summary.stopped.empty() ? "" : "; ", stop_flag ? "stopped" : summary.stopped));
    return {};
  }

  void doing(const char* what) {
    {
      const std::scoped_lock lock(mutex);
      if (job) job->doing = what;
    }
    changed();
  }

  bool stopped() override { return stop_flag || end_asked; }

  void between() override {
    std::unique_lock lock(mutex);
    wake.wait(lock, [this] { return !held || stopped(); });
  }

  void stored(std::int64_t shot) override {
    {
      const std::scoped_lock lock(mutex);
      if (job) ++job->done;
      newest_shot = shot;
    }
    const Store store(database, Store::Mode::read_only);
    const StoredShot s = store.shot(shot);
    if (!s.reason.empty()) say(fmt::format("shot {}: {}: {}", shot, name(s.outcome), s.reason));
    changed();
  }

  // ---- the thread that looks on ----

  void look() {
    std::unique_ptr<rigs::RigWatch> line;
    std::unique_lock lock(mutex);
    while (!ending) {
      lock.unlock();
      std::optional<rigs::RigStatus> seen;
      std::optional<rigs::RigInfo> found;
      std::string trouble;
      const auto asked = Clock::now();
      try {
        if (!line) {
          line = std::make_unique<rigs::RigWatch>(endpoint.uri, connect_time);
          found = line->info();
        }
        seen = line->status();
      } catch (const rigs::RigError& e) {
        line.reset();
        trouble = e.what();
      }
      const double took = 1e3 * seconds_since(asked);
      lock.lock();
      const bool news = seen != status || trouble != link_error;
      if (trouble.empty() != link_error.empty() || !status.has_value())
        log_line(trouble.empty() ? "the rig answers" : "the rig does not answer: " + trouble);
      status = seen;
      link_error = trouble;
      answer_ms = took;
      if (found) {
        found->uri = info.uri;
        info = *found;
      }
      if (news) {
        lock.unlock();
        changed();
        lock.lock();
      }
      wake.wait_for(lock, look_interval, [this] { return ending; });
    }
  }

  // ---- the stop ----

  StopAnswer stop() {
    const auto begun = Clock::now();
    struct Stopping {
      explicit Stopping(std::atomic<int>& n) : count(n) { ++count; }
      ~Stopping() { --count; }
      std::atomic<int>& count;
    } const under_way(stopping);
    stop_flag = true;  // from here on nothing is fired; what is in flight is stopped below
    const std::scoped_lock one(stop_mutex);
    { const std::scoped_lock lock(mutex); }  // whoever waits has seen the flag, or sleeps and is woken
    wake.notify_all();
    StopAnswer answer;
    answer.text = "the rig has not confirmed that its coil is off";
    while (seconds_since(begun) < std::chrono::duration<double>(stop_time).count()) {
      try {
        if (!stop_line) stop_line = std::make_unique<rigs::RigWatch>(endpoint.uri, milliseconds(500));
        stop_line->stop();
        const bool nobody = !inside;  // before the rig is asked: nothing can arm it afterwards
        const std::string state = stop_line->state();
        if (nobody && state != "armed" && state != "firing") {
          answer.off = true;
          answer.text = "coil off, confirmed by the rig: " + state;
          break;
        }
      } catch (const rigs::RigError& e) {
        stop_line.reset();
        answer.text = std::string("THE RIG DOES NOT ANSWER, the coil may be on: ") + e.what();
        std::this_thread::sleep_for(milliseconds(50));
      }
      std::this_thread::sleep_for(milliseconds(1));
    }
    answer.ms = 1e3 * seconds_since(begun);
    {
      const std::scoped_lock lock(mutex);
      last_stop = answer;
      log_line(fmt::format("STOP after {:.0f} ms: {}", answer.ms, answer.text));
    }
    changed();
    return answer;
  }

  // ---- what others ask ----

  void begin(Job next) {
    {
      const std::scoped_lock lock(mutex);
      if (job) throw NotNow("a job is on: " + job->doing + "; stop it or wait for its end");
      // cleared first, looked at second: a stop that comes in between is not lost
      stop_flag = false;
      if (stopping > 0) {
        stop_flag = true;
        throw NotNow("a stop is under way");
      }
      if (next.single) {
        next.scene = scene;
        next.campaign = single_campaign;
        PlannedShot& shot = next.shots.front();
        shot.index = singles++;
        shot.conditions.seed = shot_seed(scene.plan.seed, shot.index);
      } else {
        scene = next.scene;
        single_campaign = 0;
        singles = 0;
      }
      end_asked = held = false;
      last_stop.reset();
      job = std::move(next);
    }
    wake.notify_all();
    changed();
  }

  /// The lock is held.
  void log_line(const std::string& text) {
    const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
    log.push_back(
        fmt::format("{:%H:%M:%S} {}", fmt::gmtime(std::chrono::system_clock::to_time_t(now)), text));
    if (log.size() > longest_log) log.pop_front();
  }
  void say(const std::string& text) {
    {
      const std::scoped_lock lock(mutex);
      log_line(text);
    }
    changed();
  }

  std::string state() const {
    const std::scoped_lock lock(mutex);
    Json channels = Json::array();
    for (const auto& c : info.channels)
      channels.push_back({{"id", c.id}, {"label", c.label}, {"unit", c.unit}, {"per_count", c.scale}});
    Json out = {{"version", program_version},
                {"rig",
                 {{"uri", uri},
                  {"model", info.model},
                  {"serial", info.serial},
                  {"firmware", info.firmware},
                  {"boot_id", info.boot_id},
                  {"origin", name(origin_of_kind(info.kind))},
                  {"calibration", info.calibration},
                  {"calibration_expires", info.calibration_expires},
                  {"sample_rate_hz", info.sample_rate},
                  {"programmable_source", info.programmable_source},
                  {"channels", channels}}},
                {"link", {{"answers", status.has_value()}, {"error", link_error}, {"answer_ms", answer_ms}}},
                {"status", nullptr},
                {"plan",
                 {{"name", scene.plan.name},
                  {"specimen", scene.specimen.name},
                  {"supply_volts", scene.plan.supply_volts},
                  {"mains_hertz", scene.plan.mains_hertz},
                  {"hold_time_ms", 1e3 * scene.plan.hold_time},
                  {"shots", scene.shots.size()}}},
                {"job", nullptr},
                {"newest_shot", newest_shot ? Json(newest_shot) : Json(nullptr)},
                {"newest_campaign", newest_campaign ? Json(newest_campaign) : Json(nullptr)},
                {"stop", nullptr},
                {"log", log}};
    if (status)
      out["status"] = {{"state", status->state}, {"live", status->live()},
                       {"fault", status->fault}, {"phase", status->phase},
                       {"owner", status->owner}, {"last_error", status->last_error}};
    if (job) {
      const auto total = job->shots.size();
      const double eta = job->done > 0 && job->done < total
                             ? seconds_since(job->begun) / static_cast<double>(job->done) *
                                   static_cast<double>(total - job->done)
                             : estimated_seconds(job->scene.plan);
      out["job"] = {{"kind", job->single ? "single" : "plan"},
                    {"name", job->scene.plan.name},
                    {"campaign", job->campaign ? Json(job->campaign) : Json(nullptr)},
                    {"doing", held ? "held" : job->doing},
                    {"held", held},
                    {"ending", end_asked.load()},
                    {"done", job->done},
                    {"shots", total},
                    {"seconds_left", job->single ? Json(nullptr) : Json(eta)}};
    }
    if (last_stop) out["stop"] = {{"off", last_stop->off}, {"text", last_stop->text}, {"ms", last_stop->ms}};
    return out.dump();
  }

  const std::string uri, database;
  const std::function<void()> changed;
  const RigFile sensors;
  const rigs::Endpoint endpoint;

  mutable std::mutex mutex;
  std::condition_variable wake;
  Scene scene;
  rigs::RigInfo info;
  std::optional<Job> job;
  bool held = false, ending = false;
  std::int64_t single_campaign = 0, newest_campaign = 0, newest_shot = 0;
  int singles = 0;  ///< single closings of this plan, so far
  std::optional<rigs::RigStatus> status;
  std::string link_error;
  double answer_ms = 0.0;
  std::optional<StopAnswer> last_stop;
  std::deque<std::string> log;

  std::atomic<bool> stop_flag = false, end_asked = false, inside = false;
  std::unique_ptr<StoppableRig> rig;
  std::atomic<int> stopping = 0;
  std::mutex stop_mutex;  ///< one stop at a time; `mutex` is taken inside
  std::unique_ptr<rigs::RigWatch> stop_line;
  std::thread worker, looker;
};

Bench::Bench(const std::string& rig_uri, const Scene& scene, const std::string& database,
             std::function<void()> changed)
    : impl_(std::make_unique<Impl>(rig_uri, scene, database, std::move(changed))) {}
Bench::~Bench() = default;

std::string Bench::state() const {
  return impl_->state();
}
Scene Bench::scene() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->scene;
}
const std::string& Bench::database() const {
  return impl_->database;
}

void Bench::fire(double angle) {
  Impl::Job job;
  job.single = true;
  PlannedShot shot;
  const Scene base = scene();
  if (!base.shots.empty()) shot.conditions = base.shots.front().conditions;
  shot.conditions.polarity = +1;
  shot.conditions.closing_angle = wrap_turn(angle);
  job.shots = {shot};
  impl_->begin(std::move(job));
}

void Bench::run(const Scene& scene) {
  Impl::Job job;
  job.scene = scene;
  job.shots = scene.shots;
  impl_->begin(std::move(job));
}

void Bench::hold(bool on) {
  {
    const std::scoped_lock lock(impl_->mutex);
    if (!impl_->job || impl_->job->single) throw NotNow("no plan runs");
    impl_->held = on;
  }
  impl_->wake.notify_all();
  impl_->changed();
}

void Bench::end() {
  {
    const std::scoped_lock lock(impl_->mutex);
    if (!impl_->job || impl_->job->single) throw NotNow("no plan runs");
    impl_->end_asked = true;
  }
  impl_->wake.notify_all();
  impl_->changed();
}

StopAnswer Bench::stop() {
  return impl_->stop();
}

}  // namespace powbench::host
