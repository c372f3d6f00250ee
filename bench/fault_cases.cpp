#include "bench/fault_cases.h"

#include <algorithm>
#include <cmath>

#include "bench/fault_injections.h"

namespace powbench::bench {

using firmware::Fault;
using firmware::Refusal;
using firmware::State;

namespace {

constexpr double us_per_sample = 1e6 / FaultBench::rate;
constexpr std::int64_t usual_hold_ms = 100;

CaseResult failed(std::string why) {
  return {.passed = false, .reaction_us = 0, .why = std::move(why)};
}

}  // namespace

FaultCases::FaultCases() : idle_(bench_.save()), armed_(idle_), energised_(idle_), energised_long_(idle_) {
  auto& b = bench_;
  const auto to_cycle = [&b] {
    while (b.world.next % FaultBench::cycle != 0) b.step();
  };
  const auto energise = [&](std::int64_t hold_ms) {
    arm_with(0, hold_ms);
    b.fire_control().fire();
    while (!b.world.pin) b.step();
    b.run(2 * FaultBench::cycle);
    to_cycle();
    return b.save();
  };
  b.run(FaultBench::cycle);
  to_cycle();
  idle_ = b.save();
  arm_with(0, usual_hold_ms);
  armed_ = b.save();
  energised_ = energise(100);
  energised_long_ = energise(400);
}

/// From idle to armed, at the start of a cycle: the set-points cannot change behind arm.
void FaultCases::arm_with(int centi_degrees, std::int64_t hold_ms) {
  auto& b = bench_;
  b.restore(idle_);
  b.fire_control().set_closing_angle(centi_degrees);
  b.fire_control().set_hold_time_ms(hold_ms);
  b.arm();
  b.run(FaultBench::cycle);
  while (b.world.next % FaultBench::cycle != 0) b.step();
}

/// Brings the bench to the state, injects, and lets the host go on as if nothing were wrong.
void FaultCases::start(Fault fault, Start start, int phase) {
  auto& b = bench_;
  auto& fire = b.fire_control();
  // the edge follows 0.3, 1 or 8 ms behind the injection
  constexpr std::array<int, 3> lead_degrees{6, 18, 144};
  const int edge = (phase + lead_degrees[static_cast<std::size_t>(phase % 3)]) % 360 * 100;
  const bool scheduled = start == Start::scheduled;
  if (scheduled || (start == Start::armed && fault == Fault::host_lost))
    arm_with(scheduled ? edge : 0, fault == Fault::host_lost ? 400 : usual_hold_ms);
  else
    b.restore(start == Start::idle                                          ? idle_
              : start != Start::energised                                   ? armed_
              : fault == Fault::host_lost || fault == Fault::watchdog_reset ? energised_long_
                                                                            : energised_);
  if (start == Start::idle && fault == Fault::host_lost) fire.set_hold_time_ms(400);
  b.survivor.forget();
  b.survivor.note_gate(start == Start::energised);
  at_ = b.world.next + (start == Start::scheduled ? FaultBench::cycle : 0) + phase * FaultBench::cycle / 360;
  if (scheduled) {
    while (b.world.next < at_ - 500) b.step();
    fire.fire();
  }
  ons_before_ = b.world.ons;
  b.inject_at = at_;
  b.inject = injection_of(fault);
  while (b.world.next <= at_) b.step();
  b.inject = nullptr;
  asked_at_ = start == Start::idle ? b.world.next : at_;
  if (start == Start::idle && fault != Fault::double_fire) fire.arm();
  if (start != Start::energised && start != Start::scheduled && fault != Fault::double_fire) fire.fire();
}

/// Until the fault has latched, with 12 ms more, or the shot is over.
bool FaultCases::run_until_over(std::int64_t most) {
  for (const std::int64_t end = bench_.world.next + most; bench_.world.next < end; bench_.step()) {
    const State state = bench_.fire_control().state();
    if (state != State::firing && state != State::armed && !bench_.fire_control().settling() &&
        !bench_.world.pin)
      return true;
  }
  return false;
}

CaseResult FaultCases::judge_latched(Fault fault, Start) {
  auto& b = bench_;
  std::int64_t latched = -1;
  for (const std::int64_t end = b.world.next + 65'000; b.world.next < end; b.step()) {
    if (b.fire_control().state() == State::fault) latched = b.world.next;
    if (latched >= 0 || b.fire_control().state() == State::captured) break;
  }
  if (latched < 0) return failed("no fault latched, state " + std::string(name(b.fire_control().state())));
  if (b.fire_control().fault() != fault)
    return failed("latched " + std::string(info(b.fire_control().fault()).name));
  const std::uint32_t ons = b.world.ons;
  b.run(1200);
  if (b.world.pin || b.world.ons != ons) return failed("the gate is on after the fault");
  if (b.fire_control().fire() == Refusal::accepted || b.fire_control().arm() == Refusal::accepted)
    return failed("a command was accepted in fault");
  if (info(fault).reaction == firmware::Reaction::open_relay && b.fire_control().relay_closed())
    return failed("the safety relay is closed");
  // some causes show only while the coil is energised, others only once it is not
  std::int64_t cause = info(fault).watch == firmware::Watch::shot ? asked_at_ : at_;
  if (fault == Fault::coil_not_energising || fault == Fault::host_lost)
    cause = std::max(at_, b.world.pin_on_since);
  if (fault == Fault::coil_stuck_on || fault == Fault::contact_welded)
    cause = std::max(at_, b.world.last_on + 1);
  if (fault == Fault::coil_stuck_on)
    cause = std::max(cause, b.world.conducts_since);  // not before the relay closes
  std::int64_t safe = std::max(latched, b.world.last_on + 1);
  if (fault == Fault::crash_reset || fault == Fault::reset_while_energised) {
    if (latched - cause > FaultBench::block_samples) return failed("started without the fault");
    safe = std::max(cause, b.world.last_on + 1);  // the pin falls by itself
  }
  return {true, us_per_sample * static_cast<double>(safe - cause), {}};
}

/// A fault that no longer matters once the edge is committed: the shot goes on to its end.
CaseResult FaultCases::finished_shot(Fault fault, Start start) {
  auto& b = bench_;
  const bool energised = start == Start::energised;
  if (!energised && b.world.ons == ons_before_) {
    while (b.fire_control().state() == State::firing && b.world.ons == ons_before_) b.step();
    if (b.world.ons == ons_before_) return judge_latched(fault, start);
    const double after = us_per_sample * static_cast<double>(b.world.pin_on_since - at_);
    if (after > info(fault).limit_us) return failed("energised after the limit");
  }
  // the checksum of the record waits for the background, too
  if (!run_until_over(fault == Fault::phase_stale ? 100'000 : 40'000)) return failed("the shot does not end");
  if (b.fire_control().state() != State::captured) return failed("the energised shot was not finished");
  if (fault == Fault::sensor_implausible && b.controller.recorder().marks() == 0)
    return failed("the record is not marked");
  return {true, 0, {}};
}

CaseResult FaultCases::phase_invalid(Start start) {
  auto& b = bench_;
  if (start == Start::energised) return finished_shot(Fault::phase_invalid, start);
  const auto& fire = b.fire_control();
  // what an edge needs: nothing wrong with the mains, and the bound at its own instant
  const auto good = [&] { return fire.phase().valid(0.001F, firmware::PhaseEstimate::usual_tolerance); };
  std::int64_t noticed = good() ? -1 : b.world.next;
  for (const std::int64_t end = at_ + 150'000; b.world.next < end && fire.state() == State::firing; b.step())
    if (noticed < 0 && !good()) noticed = b.world.next;
  if (b.world.ons != ons_before_ && b.world.pin_on_since > noticed + FaultBench::block_samples)
    return failed("energised on an invalid phase");
  if (b.world.ons == ons_before_ && fire.fault() != Fault::phase_invalid) return failed("no fault after 1 s");
  std::int64_t last = start == Start::idle ? at_ : noticed;
  if (b.world.ons != ons_before_) last = std::max(last, b.world.pin_on_since);
  return {true, us_per_sample * static_cast<double>(last - at_), {}};
}

/// The samples stop; they come back long after the hold time.
CaseResult FaultCases::blocks_stop(Start start) {
  auto& b = bench_;
  b.run(20'000);
  if (b.world.pin) return failed("the gate is still on");
  double reaction = 0;
  if (b.world.ons > 0) {
    const std::int64_t hold = b.fire_control().hold_time_ms() * FaultBench::rate / 1000;
    reaction = us_per_sample * static_cast<double>(b.world.pin_off_since - b.world.pin_on_since - hold);
  }
  b.world.causes.blocks_stop = false;
  b.world.last_feed =
      b.world.next;  // here the watchdog is taken to be off, so that the firmware has to notice
  const bool was_on = b.fire_control().gate_on();
  b.run(FaultBench::block_samples);
  const Fault expected = was_on ? Fault::on_time_exceeded : Fault::samples_lost;
  if (b.fire_control().fault() != expected) return failed("wrong fault when the samples came back");
  if (b.world.ons != ons_before_ && start != Start::scheduled) return failed("energised");
  return {true, reaction, {}};
}

CaseResult FaultCases::bad_parameter(Start start) {
  auto& b = bench_;
  auto& f = b.fire_control();
  const auto before = f.state();
  const auto angle = f.closing_angle();
  const auto hold = f.hold_time_ms();
  bool refused =
      f.set_closing_angle(-1) != Refusal::accepted && f.set_closing_angle(36'000) != Refusal::accepted;
  refused = refused && f.set_hold_time_ms(0) != Refusal::accepted &&
            f.set_hold_time_ms(10'001) != Refusal::accepted;
  refused = refused && f.set_touch_delay_us(-1) != Refusal::accepted &&
            f.set_touch_delay_us(50'001) != Refusal::accepted;
  if (!refused) return failed("a value out of range was accepted");
  if (f.state() != before || f.closing_angle() != angle || f.hold_time_ms() != hold ||
      f.touch_delay_us() != 0)
    return failed("a refused value had an effect");
  if (!run_until_over(60'000)) return failed("the shot does not end");
  if (f.state() != State::captured) return failed("the shot was not finished");
  return {true, start == Start::idle ? 0.0 : 0.0, {}};
}

CaseResult FaultCases::double_fire(Start start) {
  auto& b = bench_;
  auto& f = b.fire_control();
  int accepted = 0;
  const int allowed = start == Start::armed ? 1 : 0;
  for (int i = 0; i < 1500; ++i) {
    accepted += f.fire() == Refusal::accepted;
    if (start == Start::scheduled || start == Start::energised) accepted += f.arm() == Refusal::accepted;
    b.step();
    if (f.state() == State::captured) break;
  }
  if (accepted != allowed) return failed(std::to_string(accepted) + " commands accepted");
  const std::uint32_t ons = b.world.ons - ons_before_;
  if (ons != (start == Start::armed || start == Start::scheduled ? 1U : 0U))
    return failed("energised twice or never");
  return {true, 0, {}};
}

/// For 45 ms every block is handled too late for the edge that lies in the next one.
CaseResult FaultCases::deadline_missed(Start start) {
  auto& b = bench_;
  auto& f = b.fire_control();
  const std::uint32_t missed = f.deadlines_missed();
  if (start != Start::idle) {
    const std::uint32_t ons = b.world.ons;
    const bool committed = start == Start::energised || !b.world.pin;
    while (b.world.next < at_ + 4500) b.step();
    if (start != Start::energised && b.world.ons != ons && !committed) return failed("a late edge");
    if (start == Start::armed && f.deadlines_missed() == missed)
      return failed("no missed deadline was counted");
  }
  b.world.causes.late = 0;
  if (!run_until_over(60'000)) return failed("the shot does not end");
  if (f.state() != State::captured) return failed("the shot was not finished");
  if (start != Start::energised) {
    const double wanted = static_cast<double>(f.closing_angle()) / 36'000.0;
    const double error = 360.0 * std::remainder(b.phase_turns(b.world.pin_on_since) - wanted, 1.0);
    if (std::fabs(error) > 0.3) return failed("edge off its angle by " + std::to_string(error) + " deg");
  }
  return {true, 0, {}};
}

/// A reset without current in the coil: the bench is idle, and what the host sends is refused or a new shot.
CaseResult FaultCases::clean_reset() {
  auto& b = bench_;
  if (b.world.ons != ons_before_) return failed("energised across a reset");
  if (b.fire_control().fault() != Fault::none) return failed("a clean reset latched a fault");
  return {true, 0, {}};
}

/// Lost samples while nothing goes on: no fault, and the next shot is whole.
CaseResult FaultCases::ignored(Start) {
  if (!run_until_over(60'000)) return failed("the shot does not end");
  if (bench_.fire_control().state() != State::captured) return failed("the shot after it failed");
  return {true, 0, {}};
}

/// The shot goes on, for the relay is to be closed in it; behind it the relay has to open, and does not.
CaseResult FaultCases::relay_welded() {
  auto& b = bench_;
  const auto& fire = b.fire_control();
  for (const std::int64_t end = b.world.next + 65'000; b.world.next < end && fire.state() != State::fault;)
    b.step();
  if (fire.fault() != Fault::relay_welded) return failed("latched " + std::string(name(fire.state())));
  const auto told = std::max(at_, b.world.relay_told_at);
  if (b.world.relay_told || b.world.last_on > told)
    return failed("the relay was not told to open behind the shot");
  b.fire_control().abort();
  if (fire.state() != State::fault) return failed("acknowledged with the relay welded");
  return {true, us_per_sample * static_cast<double>(b.world.next - told), {}};
}

/// Never an edge without the relay; where the coil is energised already, the current that ends is noticed first.
CaseResult FaultCases::relay_open(Start start) {
  auto& b = bench_;
  const auto& fire = b.fire_control();
  while (fire.state() != State::fault && b.world.next < at_ + 20'000) b.step();
  const bool energised = start == Start::energised || b.world.ons != ons_before_;
  const Fault expected = energised ? Fault::coil_not_energising : Fault::relay_open;
  if (fire.fault() != expected) return failed("state " + std::string(name(fire.state())));
  if (start == Start::idle || start == Start::armed)
    if (b.world.ons != ons_before_) return failed("energised without its relay");
  return {true,
          us_per_sample *
              static_cast<double>(b.world.next - std::max(at_, start == Start::idle ? asked_at_ : at_)),
          {}};
}

CaseResult FaultCases::run(Fault fault, Start state, int phase) {
  start(fault, state, phase);
  CaseResult result;
  const bool resting = state == Start::idle;
  switch (fault) {
    case Fault::phase_invalid:
      result = phase_invalid(state);
      break;
    case Fault::on_time_exceeded:
      result = blocks_stop(state);
      break;
    case Fault::bad_parameter:
      result = bad_parameter(state);
      break;
    case Fault::double_fire:
      result = double_fire(state);
      break;
    case Fault::deadline_missed:
      result = deadline_missed(state);
      break;
    case Fault::relay_welded:
      result = relay_welded();
      break;
    case Fault::relay_open:
      result = relay_open(state);
      break;
    case Fault::reset_while_energised:
      result = state == Start::energised ? judge_latched(fault, state) : clean_reset();
      break;
    case Fault::sensor_implausible:
    case Fault::phase_stale:
      result = finished_shot(fault, state);
      break;
    case Fault::samples_lost:
      result = resting ? ignored(state) : judge_latched(fault, state);
      break;
    case Fault::emergency_stop:
      if (resting)
        result = bench_.fire_control().state() == State::idle ? CaseResult{true, 0, {}} : failed("armed");
      else
        result = judge_latched(fault, state);
      break;
    default:
      result = judge_latched(fault, state);
      break;
  }
  if (fault == Fault::config_corrupt) flip_config_bit(bench_);  // repaired for the next case
  if (result.passed && result.reaction_us > info(fault).limit_us) {
    result.passed = false;
    result.why = "too slow";
  }
  return result;
}

}  // namespace powbench::bench
