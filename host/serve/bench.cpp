#include "host/serve/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/origin.h"
#include "core/phase.h"
#include "host/config/edit_text.h"
#include "host/gather/gather.h"
#include "host/run/simulate.h"
#include "host/serve/bench_impl.h"
#include "host/serve/frame.h"
#include "host/store/hash.h"
#include "rigs/iio_rig.h"

namespace powbench::host {
namespace {

constexpr std::chrono::milliseconds connect_time{1500};

}  // namespace

Bench::Impl::Impl(const std::string& rig_uri, const Scene& first, const std::string& database_file,
                  std::function<void()> on_change, std::function<void()> on_record, Clock& its_clock)
    : uri(rig_uri),
      database(database_file),
      changed(std::move(on_change)),
      recorded(std::move(on_record)),
      clock(its_clock),
      sensors(host::rig_file(rig_uri)),
      endpoint(rigs::endpoint(rig_uri, sensors.config,
                              sensors.specimen.empty() ? first.specimen : load_specimen(sensors))),
      scene(first) {
  // there and sound, or the sentence that says what is wrong
  interrupted = Store(database, Store::Mode::read_write).close_begun();
  for (const StoredShot& left : interrupted)
    log_line(fmt::format("shot {}, coil on at {:.2f} deg: ERROR: {}", left.id, left.angle_deg, left.reason));
  rig = std::make_unique<StoppableRig>(rigs::connect_iio(endpoint.uri), stop_flag, inside);
  info = rig->info();
  stop_line = std::make_unique<rigs::RigWatch>(endpoint.uri, connect_time);
  looker = std::make_unique<Looker>(
      endpoint.uri, [this] { changed(); }, [this](const std::string& text) { say(text); });
  worker = std::thread([this] { work(); });
}

Bench::Impl::~Impl() {
  {
    const std::scoped_lock lock(mutex);
    ending = true;
    end_asked = true;
    stop_flag = true;
  }
  wake.notify_all();
  if (inside) stop();
  worker.join();
  looker.reset();
}

// ---- the thread that fires ----

void Bench::Impl::work() {
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
    if (!job->single)
      ended =
          Ended{job->scene.plan.name, job->campaign, job->done - job->lacking, job->shots.size(), job->why};
    job.reset();
    paused = end_asked = false;
    lock.unlock();
    changed();
    lock.lock();
  }
}

rigs::RigInfo Bench::Impl::rig_now() const {
  const Looker::Look look = looker->look();
  return look.info ? *look.info : info;
}

std::string Bench::Impl::run_job(const Job& now) {
  Store store(database);
  const rigs::RigInfo found = rig_now();
  std::int64_t campaign = now.campaign;
  if (campaign == 0) {
    CampaignInfo c = campaign_info(now.scene, uri, found.model + ", " + found.serial);
    if (now.single) {  // nothing was planned: none of its closings is missing
      c.plan = by_hand_plan(c.plan);
      c.plan_hash = sha256_hex(c.plan);
      c.name = "single closings";
    }
    c.origin = origin_of_kind(found.kind);
    campaign = store.create_campaign(c);
  }
  const std::size_t noted = store.annotations(campaign).size();
  const std::string late = note_calibration(store, campaign, found);
  // of single closings once, not at each
  if (!late.empty() && (!now.single || store.annotations(campaign).size() > noted)) say(late);
  {
    const std::scoped_lock lock(mutex);
    job_rig = found;
    if (now.single) single_campaign = campaign;
    job->campaign = newest_campaign = campaign;
    job->begun = clock.now();
    job->doing = "firing";
  }
  changed();
  RunOptions options = run_options(now.scene.plan);
  options.watcher = this;
  options.clock = &clock;
  options.how_to_go_on = "go on with the button 'Fire the rest' on the page Documents";
  Progress silent("", now.shots.size(), Progress::Style::none);
  // a single closing is simulated as asked, which is known beforehand: beside the shot at the latest, and once for an
  // angle
  const StoredShot beside = powbench::host::stored(campaign, ShotKind::simulated, now.shots.front());
  bool wanting = now.single && !simulated(store, beside);
  if (wanting) simulate_ahead(now);
  with_shot = [&] {
    const Ahead::Made made = wanting ? ahead.ready(key_of(now)) : nullptr;
    if (made) keep_simulated(store, beside, made->simulated.record, made->events, options);
    if (made) wanting = false;
  };
  const RunSummary summary = run_campaign(store, campaign, now.shots, *rig, options, silent);
  with_shot = nullptr;
  // of a single closing that no STOP has cut the picture is made to the end: nothing is fired for it
  if (summary.done() > 0 && (!stopped() || (now.single && !is_ending()))) {
    doing("simulating");
    if (!now.single)
      simulate_campaign(store, campaign, now.shots, now.scene.specimen, sensors.config, options, silent,
                        {now.scene.specimen_text + resolved_text(sensors)});
    else if (const Ahead::Made made = wanting ? ahead.wait(key_of(now)) : nullptr)
      keep_simulated(store, beside, made->simulated.record, made->events, options);
    if (now.single) predict_later(store, now);
  }
  const bool all = summary.done() == summary.planned;
  const std::string how = !stop_flag ? summary.stopped
                          : all      ? "STOP came when all closings were already fired"
                                     : "stopped";
  {
    const std::scoped_lock lock(mutex);
    job->why = how;
  }
  if (!now.single)
    say(fmt::format("plan {}: {} of {} shots recorded{}{}{}", now.scene.plan.name, summary.done(),
                    summary.planned,
                    options.limits.empty() && summary.count(Outcome::fail) == 0
                        ? ", no limit is set"
                        : fmt::format(", {} outside limits", summary.count(Outcome::fail)),
                    how.empty() ? "" : "; ", how));
  return {};
}

bool Bench::Impl::is_ending() const {
  const std::scoped_lock lock(mutex);
  return ending;
}

void Bench::Impl::doing(const char* what) {
  {
    const std::scoped_lock lock(mutex);
    if (job) job->doing = what;
  }
  changed();
}

void Bench::Impl::resting(double left) {
  bool news = false;
  {
    const std::scoped_lock lock(mutex);
    if (!job) return;
    if (job->pause_left > left) job->pauses += job->pause_left - left;
    news = std::ceil(left) != std::ceil(job->pause_left);
    job->pause_left = left;
  }
  if (news) changed();
}

void Bench::Impl::between() {
  std::unique_lock lock(mutex);
  if (!paused || stopped()) return;
  const double from = clock.now();
  waiting = true;
  lock.unlock();
  changed();
  lock.lock();
  wake.wait(lock, [this] { return !paused || stopped(); });
  waiting = false;
  if (job) job->begun += clock.now() - from;  // what is left is told from the time that firing took
}

void Bench::Impl::stored(std::int64_t shot) {
  const Store store(database, Store::Mode::read_only);
  const StoredShot s = store.shot(shot);
  if (with_shot && measured(s.outcome))
    with_shot();  // where it is there already, the page draws both at once
  std::shared_ptr<const std::string> newest;
  if (!s.record_hash.empty())
    newest = std::make_shared<const std::string>(
        record_frame(store.load_record(shot), shot, std::string(name(origin_of_kind(rig_now().kind)))));
  {
    const std::scoped_lock lock(mutex);
    if (job) ++job->done;
    if (job && s.outcome == Outcome::aborted) ++job->cut;
    if (job && !measured(s.outcome)) ++job->lacking;
    if (job && s.outcome == Outcome::fail) ++job->outside;
    newest_shot = shot;
    newest_aim = job ? job->aim : std::nullopt;
    if (newest) frame = newest;
    const std::string asked =
        job && job->aim ? fmt::format(" to touch at {:.1f} deg", degrees(job->aim->wanted)) : std::string();
    log_line(fmt::format("shot {}, coil on at {:.2f} deg{}: {}{}{}", shot, s.angle_deg, asked,
                         name(s.outcome), s.reason.empty() ? "" : ": ", s.reason));
  }
  if (newest) recorded();
  changed();
}

// ---- what others ask ----

void Bench::Impl::begin(Job next, Instant asked) {
  const auto seen = looker->look().status;
  {
    const std::scoped_lock lock(mutex);
    if (aiming && *aiming > stopped_at.load() && !next.aim)
      throw NotNow("the angle of a closing at touch is being sought; stop it or wait for its end");
    if (job) throw NotNow("a job is on: " + job->doing + "; stop it or wait for its end");
    if (acknowledging) throw NotNow("a fault of the rig is being acknowledged");
    if (seen && seen->state == "fault")
      throw NotNow(fmt::format("the rig is in fault, {}: {}", seen->fault, rigs::advice(seen->last_error)));
    // cleared first, looked at second: a stop that comes in between is not lost
    stop_flag = false;
    if (stopping > 0) {
      stop_flag = true;
      throw NotNow("a stop is under way");
    }
    if (asked <= stopped_at.load()) {
      stop_flag = true;
      throw NotNow("STOP came after this was asked for: nothing was fired; ask again");
    }
    if (next.single) {
      complete(next);
      ++singles;
    } else {
      scene = next.scene;
      single_campaign = 0;
      singles = 0;
    }
    end_asked = paused = false;
    last_stop.reset();
    ended.reset();
    job = std::move(next);
  }
  wake.notify_all();
  changed();
}

Bench::Bench(const std::string& rig_uri, const Scene& scene, const std::string& database,
             std::function<void()> changed, std::function<void()> recorded, Clock& clock)
    : impl_(
          std::make_unique<Impl>(rig_uri, scene, database, std::move(changed), std::move(recorded), clock)) {}
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

void Bench::adopt(const Scene& scene) {
  {
    const std::scoped_lock lock(impl_->mutex);
    if (impl_->job) throw NotNow("a job is on: " + impl_->job->doing + "; stop it or wait for its end");
    impl_->scene = scene;
    impl_->single_campaign = 0;
    impl_->singles = 0;
  }
  impl_->changed();
}
std::shared_ptr<const std::string> Bench::frame() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->frame;
}
std::vector<std::pair<std::string, std::string>> Bench::attributes() const {
  return impl_->looker->attributes();
}
const RigFile& Bench::rig_file() const {
  return impl_->sensors;
}
const std::string& Bench::rig_uri() const {
  return impl_->uri;
}

void Bench::run(const Scene& scene, Instant asked) {
  Impl::Job job;
  job.scene = scene;
  job.shots = scene.shots;
  impl_->begin(std::move(job), asked);
}

void Bench::resume(const CampaignInfo& c, Instant asked) {
  const std::string name = fmt::format("campaign {}", c.id);
  const Scene now = scene();
  Impl::Job job;
  Plan plan = stored_plan(c);
  if (plan.order == Order::by_hand) throw NotNow(name + " is of single closings: nothing of it was planned");
  if (c.finished) throw NotNow(name + " is finished: every shot of its plan is stored");
  plan.folder = now.plan.folder;
  if (plan.specimen == now.plan.specimen) job.scene = make_scene(plan);
  if (job.scene.plan_hash != c.plan_hash || job.scene.specimen_hash != c.specimen_hash)
    throw NotNow(name +
                 " was begun with another specimen file, or by another version of the program; start the "
                 "bench with that one, or run the plan anew");
  const rigs::RigInfo rig = impl_->rig_now();
  if (const std::string here = rig.model + ", " + rig.serial; c.rig_identity != here)
    throw NotNow(fmt::format("{} was begun on '{}', this rig is '{}'; go on there, or run the plan anew",
                             name, c.rig_identity, here));
  job.shots = job.scene.shots;
  job.campaign = c.id;
  job.before = job.done = recorded_shots(Store(impl_->database, Store::Mode::read_only), c.id).size();
  impl_->begin(std::move(job), asked);
}

void Bench::pause(bool on) {
  {
    const std::scoped_lock lock(impl_->mutex);
    if (!impl_->job || impl_->job->single) throw NotNow("no plan runs");
    impl_->paused = on;
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

void Bench::acknowledge(int number) {
  impl_->acknowledge(number);
}

StopAnswer Bench::stop() {
  return impl_->stop();
}

}  // namespace powbench::host
