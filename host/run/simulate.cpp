#include "host/run/simulate.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "core/channels.h"
#include "core/counted.h"
#include "core/phase.h"
#include "core/quantities.h"
#include "core/version.h"
#include "dsp/options.h"
#include "dsp/signal/signal.h"
#include "host/compare/compare.h"
#include "host/compare/repeats.h"
#include "host/run/simulated_point.h"
#include "host/run/stop.h"
#include "host/store/hash.h"
#include "host/store/json.h"

namespace powbench::host {

namespace {

/// Mean and u of what the closings show of an input; `value` stays where none shows it.
template <class Of>
double mean_of(std::span<const Events> measured, const Of& of, double& value) {
  std::vector<Measured> seen;
  for (const Events& e : measured) seen.push_back(of(e));
  const Repeats r = repeats_of(seen);
  if (r.n == 0) return 0.0;
  value = r.mean;
  return std::isfinite(r.u) ? r.u : 0.0;
}

constexpr Channel smooth_channels[] = {Channel::laser, Channel::coil_current};
constexpr double spread_step = 1e-4, spread_end = 60e-3;  // s

/// A curve in means over `spread_step` from switch-on; NaN where it was not recorded.
std::vector<double> coarse(const Record& record, Channel channel) {
  const dsp::Signal s = dsp::to_signal(record, channel);
  std::vector<double> out;
  for (double from = 0; !s.empty() && from < spread_end;
       from = static_cast<double>(out.size()) * spread_step) {
    const std::size_t i = s.index_at(from), end = s.index_at(from + spread_step);
    double sum = 0;
    for (std::size_t n = i; n < end; ++n) sum += s.value[n];
    out.push_back(end > i ? sum / static_cast<double>(end - i) : unknown);
  }
  return out;
}

/// One simulated closing: its events, and each of `smooth_channels`.
/// The closing that `make` simulates with the step of the coil voltage at the angle of `c`: behind a switch with a
/// delay the command has to come earlier.
template <class Make>
auto at_the_step(const Make& make, const Conditions& c, const RunOptions& options, Events& events) {
  constexpr double told = radians(0.5);
  auto closing = make(c);
  events = extract_checked(closing.record, options);
  const double off = wrap_half_turn(events.coil.closing_angle.value - effective_angle(c));
  if (!(std::abs(off) > told)) return closing;
  Conditions earlier = c;
  earlier.closing_angle = wrap_turn(c.closing_angle - off);
  closing = make(earlier);
  closing.record.conditions = c;
  events = extract_checked(closing.record, options);
  return closing;
}

struct Twin {
  Twin(const Conditions& c, const sim::Specimen& specimen, const rigs::SimRigConfig& rig,
       const RunOptions& options) {
    const auto make = [&](const Conditions& at) { return rigs::simulate_record(specimen, at, rig); };
    const Record record = at_the_step(make, c, options, events).record;
    for (const Channel channel : smooth_channels) curves.push_back(coarse(record, channel));
  }
  Events events;
  std::vector<std::vector<double>> curves;
};

/// `c` at the angle, voltage and frequency that a closing shows, as far as it does.
Conditions reached_by(const Events& closing, Conditions c) {
  const CoilEvents& coil = closing.coil;
  if (std::isfinite(coil.closing_angle.value))
    c.closing_angle =
        wrap_turn(c.closing_angle + wrap_half_turn(coil.closing_angle.value - effective_angle(c)));
  if (std::isfinite(coil.supply_volts.value)) c.supply_volts = coil.supply_volts.value;
  if (std::isfinite(coil.mains_hertz.value)) c.mains_hertz = coil.mains_hertz.value;
  return c;
}

/// All that went into a simulation.
std::string inputs_text(const ClosingInputs& in, const std::string& made_with) {
  return fmt::format("{}\n{}\n{:.17g} {:.17g} {:.17g} {:.17g}\n{}", program_version, to_json(in.conditions),
                     in.u_angle, in.u_volts, in.u_hertz, in.u_ambient, made_with);
}

/// And into its events and its prediction.
std::string point_text(const ClosingInputs& in, const Simulation& how, const rigs::SimRigConfig& rig,
                       const RunOptions& options, bool measured, std::span<const NumberedClosing> alone) {
  std::string text =
      inputs_text(in, how.made_with) +
      fmt::format("\n{} {:.17g} {}\n", dsp::to_text(options.extract), options.angle_tolerance, measured);
  text += fmt::format("channels {}", static_cast<std::uint64_t>(rig.sensors.channels));
  for (const auto& [number, events] : alone) text += fmt::format("\n{} {}", number, to_json(events));
  return text;
}

/// What a simulation came from: in words, and the hash of all that went in.
std::string basis(const ClosingInputs& in, std::size_t closings, const std::string& made_with) {
  const std::string text = inputs_text(in, made_with);
  constexpr std::size_t digits = 12;
  return fmt::format("{}; inputs {}",
                     closings == 0 ? std::string("at the conditions that the plan asks for")
                                   : "under the mean conditions of " + counted(closings, "measured closing"),
                     sha256_hex(text).substr(0, digits));
}

}  // namespace

ClosingInputs inputs_of(const Conditions& asked, std::span<const Events> measured,
                        const RunOptions& options) {
  ClosingInputs in;
  in.conditions = asked;
  const double commanded = effective_angle(asked);
  double off = 0;
  in.u_angle = mean_of(
      measured,
      [&](const Events& e) {
        Measured m = e.coil.closing_angle;
        m.value = wrap_half_turn(m.value - commanded);
        return m;
      },
      off);
  in.conditions.closing_angle = wrap_turn(asked.closing_angle + off);
  in.u_volts = mean_of(
      measured, [](const Events& e) { return e.coil.supply_volts; }, in.conditions.supply_volts);
  if (!measured.empty()) in.u_volts = std::hypot(in.u_volts, options.supply_u * in.conditions.supply_volts);
  in.u_hertz = mean_of(
      measured, [](const Events& e) { return e.coil.mains_hertz; }, in.conditions.mains_hertz);
  in.u_ambient = options.coil_temperature_u;
  return in;
}

ClosingInputs inputs_as_asked(const Conditions& asked, std::span<const Events> measured,
                              const RunOptions& options) {
  ClosingInputs in = inputs_of(asked, measured, options);
  in.u_angle = std::hypot(in.u_angle, wrap_half_turn(in.conditions.closing_angle - asked.closing_angle));
  in.u_volts = std::hypot(in.u_volts, in.conditions.supply_volts - asked.supply_volts);
  in.u_hertz = std::hypot(in.u_hertz, in.conditions.mains_hertz - asked.mains_hertz);
  in.conditions = asked;
  return in;
}

InputSpread input_uncertainty(const ClosingInputs& in, const sim::Specimen& specimen,
                              const rigs::SimRigConfig& rig, const RunOptions& options,
                              std::span<const NumberedClosing> alone, const std::function<bool()>& over) {
  const auto twin = [&](const Conditions& c) {
    if (over && over()) throw NotNeeded();
    return Twin(c, specimen, rig, options);
  };
  struct Input {
    double Conditions::*place;
    double u, least_step;  ///< a step below is lost in the samples
  };
  const Input inputs[] = {{&Conditions::closing_angle, in.u_angle, radians(0.2)},
                          {&Conditions::supply_volts, in.u_volts, 0.002 * in.conditions.supply_volts},
                          {&Conditions::mains_hertz, in.u_hertz, 0.001 * in.conditions.mains_hertz},
                          {&Conditions::ambient, in.u_ambient, 1.0}};
  std::map<std::string, double> variance;
  for (const Quantity& q : quantity_table) variance[std::string(q.symbol)] = 0;
  std::vector<std::vector<double>> curve_variance(std::size(smooth_channels));
  const Twin middle = twin(in.conditions);
  for (const Input& input : inputs) {
    if (!(input.u > 0.01 * input.least_step)) continue;  // moves nothing that a sample shows
    const double step = std::max(input.u, input.least_step);
    Conditions low = in.conditions, high = in.conditions;
    low.*input.place -= step;
    high.*input.place += step;
    low.closing_angle = wrap_turn(low.closing_angle);
    high.closing_angle = wrap_turn(high.closing_angle);
    const Twin a = twin(low), b = twin(high);
    const double scale = input.u / (2 * step);
    const auto square = [scale](double d) { return d * scale * d * scale; };
    for (const Quantity& q : quantity_table) {
      const double from = q.of(middle.events).value;
      variance[std::string(q.symbol)] +=
          2 * (square(q.of(a.events).value - from) + square(q.of(b.events).value - from));
    }
    for (std::size_t c = 0; c < curve_variance.size(); ++c) {
      curve_variance[c].resize(std::min(a.curves[c].size(), b.curves[c].size()));
      for (std::size_t k = 0; k < curve_variance[c].size(); ++k)
        curve_variance[c][k] += square(b.curves[c][k] - a.curves[c][k]);
    }
  }
  InputSpread out;
  for (const auto& [symbol, v] : variance) out.u[symbol] = std::sqrt(v);
  for (const auto& [number, closing] : alone) {
    const Twin own = twin(reached_by(closing, in.conditions));
    for (const Quantity& q : quantity_table)
      out.moved[number][std::string(q.symbol)] = q.of(own.events).value - q.of(middle.events).value;
  }
  for (std::size_t c = 0; c < curve_variance.size(); ++c) {
    if (curve_variance[c].empty()) continue;
    out.curves.push_back({std::string(info(smooth_channels[c]).name), 0, spread_step, {}});
    for (const double v : curve_variance[c]) out.curves.back().u.push_back(static_cast<float>(std::sqrt(v)));
  }
  return out;
}

std::int64_t keep_simulated(Store& store, StoredShot shot, const Record& record, const Events& events,
                            const RunOptions& options) {
  shot.outcome = Outcome::not_judged;
  return store.store_shot(shot, &record, &events, extraction_info(options));
}

SimulatedCount simulate_campaign(Store& store, std::int64_t campaign, std::span<const PlannedShot> plan,
                                 const sim::Specimen& specimen, const rigs::SimRigConfig& rig,
                                 const RunOptions& options, Progress& progress, const Simulation& how) {
  std::map<double, StoredShot> known;
  for (const StoredShot& s : store.shots(campaign, ShotKind::simulated)) known[s.angle_deg] = s;
  std::map<double, std::vector<Events>> measured;
  std::map<double, std::vector<NumberedClosing>> alone;
  std::size_t closed = 0;
  if (!how.nominal)
    for (const StoredShot& s : store.shots(campaign, ShotKind::measured))
      if (auto events = powbench::measured(s.outcome) ? store.load_events(s.id) : std::nullopt) {
        if (++closed <= most_alone) alone[s.angle_deg].push_back({s.number, *events});
        measured[s.angle_deg].push_back(std::move(*events));
      }
  if (closed > most_alone) alone.clear();
  // one simulation for each angle: its closings differ by noise and by what a mean of their conditions holds
  std::map<double, StoredShot> angles;
  for (const PlannedShot& planned : plan) {
    StoredShot shot = stored(campaign, ShotKind::simulated, planned);
    angles.emplace(shot.angle_deg, shot);
  }
  SimulatedCount count;
  std::vector<StoredShot> shots;
  std::vector<ClosingInputs> inputs;
  std::vector<std::int64_t> numbers;  // among all angles
  std::int64_t number = 0;
  for (auto& [angle, shot] : angles) {
    const std::vector<Events>& closings = measured[angle];
    alone[angle];  // there for every angle before the threads look
    const ClosingInputs in =
        closings.empty() ? ClosingInputs{shot.conditions} : inputs_of(shot.conditions, closings, options);
    ++number;
    shot.conditions = in.conditions;
    shot.reason = basis(in, closings.size(), how.made_with);
    const auto before = known.find(angle);
    if (before != known.end() && before->second.reason == shot.reason) {
      ++count.kept;
      const auto events = store.load_events(before->second.id);
      count.beyond_fields += events && (events->flags & flag_beyond_fields) != 0;
      continue;
    }
    shots.push_back(shot), inputs.push_back(in), numbers.push_back(number - 1);
  }

  Points none;
  Points& points = how.points != nullptr ? *how.points : none;
  std::vector<std::optional<SimulatedPoint>> results(shots.size());
  std::atomic<std::size_t> next = 0, finished = 0;
  std::mutex mutex;
  std::exception_ptr trouble;
  std::size_t first_open = 0;  // all before the first are stored
  const auto store_one = [&](std::size_t i) {
    const auto result = std::exchange(results[i], {});
    if (!result) return;
    const std::int64_t id = keep_simulated(store, shots[i], result->record, result->events, options);
    if (!result->prediction.empty()) store.store_prediction(id, result->prediction);
    ++count.stored;
    count.field_states += result->field_states, count.field_beyond += result->field_beyond;
    count.beyond_fields += (result->events.flags & flag_beyond_fields) != 0;
    if (known.contains(shots[i].angle_deg)) ++count.renewed;
  };
  const auto work = [&] {
    for (std::size_t i = next++; i < shots.size() && !StopOnSignal::asked(); i = next++) {
      try {
        const bool predicted = !measured.at(shots[i].angle_deg).empty();
        const auto& others = alone.at(shots[i].angle_deg);
        const auto simulate = [&] {
          SimulatedPoint p;
          if (predicted) p.prediction = input_uncertainty(inputs[i], specimen, rig, options, others);
          const auto make = [&](const Conditions& at) { return how.make(specimen, at, rig); };
          const auto closing = at_the_step(make, shots[i].conditions, options, p.events);
          p.record = closing.record;
          p.field_states = closing.field_states, p.field_beyond = closing.field_beyond;
          if (static_cast<double>(p.field_beyond) > few_beyond * static_cast<double>(p.field_states))
            p.events.flags |= flag_beyond_fields;
          return bytes_of(p);
        };
        const auto bytes =
            points.get(numbers[i], point_text(inputs[i], how, rig, options, predicted, others), simulate);
        const std::scoped_lock lock(mutex);
        if (bytes && !points.part()) results[i] = simulated_point(*bytes, shots[i].conditions);
        // stored in the order of the angles, whatever thread was first
        for (; first_open < shots.size() && results[first_open]; ++first_open) store_one(first_open);
        progress.update(++finished);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        trouble = std::current_exception();
        return;
      }
    }
  };
  std::vector<std::thread> pool;
  for (int t = 0; t < std::max(how.threads, 1); ++t) pool.emplace_back(work);
  for (auto& t : pool) t.join();
  // behind an angle that was stopped or has failed
  for (; first_open < shots.size(); ++first_open) store_one(first_open);
  if (trouble) std::rethrow_exception(trouble);
  return count;
}

}  // namespace powbench::host
