#include <fmt/format.h>

#include <span>

#include "core/phase.h"
#include "host/run/simulate.h"
#include "host/serve/bench_impl.h"
#include "rigs/simulated_record.h"

/// Single closings: their conditions, their simulation made ahead, and the angle of switch-on for a wanted touch.

namespace powbench::host {

/// The closing that stands beside a shot; nothing where none is stored.
std::optional<StoredShot> Bench::Impl::simulated(const Store& store, const StoredShot& beside) {
  for (const StoredShot& s : store.shots(beside.campaign, ShotKind::simulated))
    if (s.angle_deg == beside.angle_deg) return s;
  return std::nullopt;
}

/// What the uncertainties of the closing's conditions move its simulation by: eight closings more, so after the
/// picture.
void Bench::Impl::predict_later(const Store& store, const Job& single) {
  const PlannedShot& shot = single.shots.front();
  std::int64_t campaign = 0, measured_shot = 0;
  {
    const std::scoped_lock lock(mutex);
    campaign = newest_campaign, measured_shot = newest_shot;
  }
  const auto beside = simulated(store, powbench::host::stored(campaign, ShotKind::simulated, shot));
  const auto events = store.load_events(measured_shot);
  if (!beside || !events || !store.prediction(beside->id).empty()) return;
  later.add([this, id = beside->id, asked = shot.conditions,
             closing = NumberedClosing{store.shot(measured_shot).number, *events},
             specimen = single.scene.specimen, options = run_options(single.scene.plan)] {
    try {
      Store own(database);
      if (!own.prediction(id).empty()) return;
      const ClosingInputs inputs = inputs_as_asked(asked, std::span(&closing.events, 1), options);
      own.store_prediction(id, input_uncertainty(inputs, specimen, sensors.config, options,
                                                 std::span(&closing, 1), [this] { return later.ending(); }));
      const std::scoped_lock lock(mutex);
      newest_prediction = id;
    } catch (const NotNeeded&) {
      return;
    } catch (const std::exception& e) {
      say(fmt::format("the uncertainty of simulated shot {} is not known: {}", id, e.what()));
      return;
    }
    changed();
  });
}

Ahead::Key Bench::Impl::key_of(const Job& single) {
  const Conditions& c = single.shots.front().conditions;
  return {single.scene.plan_hash, single.scene.specimen_hash, c.closing_angle, c.seed};
}

void Bench::Impl::simulate_ahead(const Job& single) {
  ahead.want(key_of(single), [specimen = single.scene.specimen, conditions = single.shots.front().conditions,
                              rig_config = sensors.config, options = run_options(single.scene.plan)] {
    Ahead::Closing a{rigs::simulate_record(specimen, conditions, rig_config), {}};
    a.events = extract_checked(a.simulated.record, options);
    return a;
  });
}

void Bench::Impl::complete(Job& single) const {
  single.scene = scene;
  single.campaign = single_campaign;
  PlannedShot& shot = single.shots.front();
  shot.index = singles;
  shot.conditions.seed = shot_seed(scene.plan.seed, shot.index);
}

void Bench::Impl::prepare(double angle) {
  Job next = single(angle);
  {
    const std::scoped_lock lock(mutex);
    if (job) return;  // it needs the processor, and what follows it has another seed
    complete(next);
  }
  if (next.campaign != 0 &&
      simulated(Store(database, Store::Mode::read_only),
                powbench::host::stored(next.campaign, ShotKind::simulated, next.shots.front())))
    return;
  const std::scoped_lock lock(mutex);
  if (!job) simulate_ahead(next);
}

Bench::Impl::Job Bench::Impl::single(double angle) const {
  Job next;
  next.single = true;
  PlannedShot shot;
  {
    const std::scoped_lock lock(mutex);
    if (!scene.shots.empty()) shot.conditions = scene.shots.front().conditions;
  }
  shot.conditions.polarity = +1;
  shot.conditions.closing_angle = wrap_turn(angle);
  next.shots = {shot};
  return next;
}

TouchAim::Aim Bench::Impl::aim(double touch_angle) {
  Scene now;
  {
    const std::scoped_lock lock(mutex);
    now = scene;
  }
  const std::scoped_lock one(aim_mutex);
  if (!touch || !touch->fits(now)) touch.emplace(now, sensors.config);
  const auto found = touch->at(wrap_turn(touch_angle));
  if (!found)
    throw NotNow(
        fmt::format("with the coil on at no angle do the simulated contacts touch at {:.1f} deg of the "
                    "mains; choose another "
                    "angle, or choose 'Coil on at'",
                    degrees(touch_angle)));
  return *found;
}

void Bench::fire(double angle, Instant asked) {
  impl_->begin(impl_->single(angle), asked);
}

void Bench::prepare(double angle) {
  impl_->prepare(angle);
}

void Bench::fire_at_touch(double touch_angle, Instant asked) {
  {
    const std::scoped_lock lock(impl_->mutex);
    if (impl_->job) throw NotNow("a job is on: " + impl_->job->doing + "; stop it or wait for its end");
    if (impl_->aiming && *impl_->aiming > impl_->stopped_at.load())
      throw NotNow("the angle of a closing at touch is being sought; stop it or wait for its end");
    impl_->aiming = asked;
    impl_->last_stop.reset();  // its confirmation is not of what is fired next
  }
  impl_->changed();
  const auto over = [&] {
    {
      const std::scoped_lock lock(impl_->mutex);
      if (impl_->aiming == asked) impl_->aiming.reset();
    }
    impl_->changed();
  };
  try {
    const TouchAim::Aim aim = impl_->aim(touch_angle);
    Impl::Job job = impl_->single(aim.closing_angle);
    job.aim = aim;
    impl_->begin(std::move(job), asked);
  } catch (...) {
    over();
    throw;
  }
  over();
}

}  // namespace powbench::host
