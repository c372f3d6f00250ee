#include "rigs/iio_rig.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <thread>

#include "core/crc32.h"
#include "rigs/iio_link.h"
#include "rigs/interlock_list.h"
#include "rigs/rig_owner.h"
#include "rigs/rig_watch.h"
#include "rigs/sealed_shot.h"
#include "rigs/shot_set_points.h"

/// A shot over a line that may break at any byte. Before the coil is energised the rig's own sealed account of the
/// set-points is compared with those asked for; afterwards the sealed account of the shot decides whether a record is
/// that of this shot. When the link breaks in between, boot id and shot number tell what became of it.

namespace powbench::rigs {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;
using Device = IioLink::Device;

constexpr milliseconds lease_time{5000};      // an owner that is gone holds the bench no longer
constexpr milliseconds lease_patience{6000};  // so long another owner is waited for
constexpr milliseconds heartbeat{100};        // the coil goes off after 250 ms of silence
constexpr int most_breaks = 6;                // in one shot: then the line is no line
constexpr std::array states{"idle", "armed", "firing", "captured", "fault"};

/// A shot between arming and its record.
struct OpenShot {
  Conditions conditions;
  std::string boot;
  std::int64_t number = 0;      ///< the rig's; 0: not armed yet
  bool may_have_fired = false;  ///< `fire` has been written
};

/// Ends a shot without a record.
struct Failed {
  Outcome outcome = Outcome::error;
  std::string reason;
  bool interlock = false;
  bool latched = false;
};

class IioRig final : public Rig {
 public:
  IioRig(std::string uri, milliseconds limit, milliseconds request)
      : uri_(std::move(uri)), limit_(limit), request_(request) {
    connect(limit_);
  }
  ~IioRig() override;

  const RigInfo& info() const override { return info_; }
  Shot fire(const Conditions&, milliseconds limit) override;
  bool abort() override;
  bool reconnect() override;
  std::optional<Shot> recover(milliseconds limit) override;
  void stop_when(std::function<bool()> asked) override { stop_asked_ = std::move(asked); }

 private:
  void connect(milliseconds limit);
  bool connect_same(milliseconds limit);
  Shot attempt(Clock::time_point deadline);
  void arm(OpenShot&, Clock::time_point deadline);
  Record finish(OpenShot&, Clock::time_point deadline);
  [[noreturn]] void give_up();
  bool stopped() const { return stop_asked_ && stop_asked_(); }
  std::optional<Record> kept(const OpenShot&);
  std::string claim(Clock::time_point until);
  void set_conditions(const Conditions&);
  SealedShot read_sealed();
  std::string read_state();
  bool wait_while_firing(Clock::time_point deadline);
  void refuse_other_set_points(const SealedShot&, const Conditions&) const;
  Record read_record(const SealedShot&, const Conditions&);
  Failed trip();
  std::string last_error();
  std::string owned(const std::string& value) const { return value + " " + token_; }

  std::string uri_;
  milliseconds limit_, request_;
  std::unique_ptr<IioLink> link_;
  RigInfo info_;
  std::string token_ = make_token(), name_ = make_name();
  Clock::time_point renewed_{};
  std::optional<OpenShot> open_;  ///< its outcome is not known yet
  std::function<bool()> stop_asked_;
};

void IioRig::connect(milliseconds limit) {
  link_.reset();
  auto link = std::make_unique<IioLink>(uri_, limit, request_);
  info_ = link->read_info(uri_);
  link_ = std::move(link);
}

IioRig::~IioRig() {
  if (!link_ || renewed_ == Clock::time_point{}) return;
  try {
    link_->write(Device::control, "lease", token_ + " 0");
  } catch (...) {
    // it ends by itself
  }
}

/// The bench is ours, or a sentence that says whose it is. Renews a lease that is ours already.
std::string IioRig::claim(Clock::time_point until) {
  for (auto pause = milliseconds(1);; pause = std::min(2 * pause, milliseconds(50))) {
    try {
      link_->write(Device::control, "lease", token_ + " " + std::to_string(lease_time.count()) + " " + name_);
      renewed_ = Clock::now();
      return {};
    } catch (const Refusal& r) {
      if (r.error != EBUSY) throw;
    }
    const std::string owner = link_->read(Device::control, "lease");
    if (Clock::now() >= until || stopped()) return "the bench belongs to " + owner;
    std::this_thread::sleep_for(pause);
  }
}

void IioRig::set_conditions(const Conditions& c) {
  const auto wanted = shot_set_points(c, link_->has_source());
  const auto set = [&](Device d, const char* name, std::int64_t value) {
    link_->write(d, name, owned(std::to_string(value)));
  };
  if (wanted.source) {
    set(Device::plant, "supply_millivolts", wanted.source->supply_millivolts);
    set(Device::plant, "mains_millihertz", wanted.source->mains_millihertz);
    set(Device::plant, "ambient_millidegc", wanted.source->ambient_millidegc);
    set(Device::plant, "seed", wanted.source->seed);
  }
  link_->write_angle(owned(std::to_string(wanted.angle_centideg)));
  set(Device::control, "hold_time_ms", wanted.hold_ms);
  set(Device::control, "touch_delay_us", wanted.touch_us);
  set(Device::control, "angle_tolerance_millideg", wanted.tolerance_mdeg);
}

SealedShot IioRig::read_sealed() {
  const std::string text = link_->read(Device::daq, "sealed_shot");
  if (text == "none") return {};
  try {
    return parse_sealed_shot(text);
  } catch (const SealError& e) {
    throw LinkBroken{0, e.what()};
  }
}

std::string IioRig::read_state() {
  std::string state = link_->read(Device::control, "state");
  if (std::find(states.begin(), states.end(), state) == states.end())
    throw LinkBroken{0, "the rig's state is '" + state + "', which is none"};
  return state;
}

/// What the rig has latched is what was asked for. Anything else came from a line that changes bits.
void IioRig::refuse_other_set_points(const SealedShot& s, const Conditions& c) const {
  if (!has_latched(s, shot_set_points(c, link_->has_source())))
    throw LinkBroken{0, "the rig has latched other set-points than those asked for"};
}

/// Everything up to, and without, energising the coil.
void IioRig::arm(OpenShot& shot, Clock::time_point deadline) {
  const std::string whose = claim(std::min(deadline, Clock::now() + lease_patience));
  if (stopped()) throw Failed{Outcome::aborted, std::string(stopped_words)};
  if (!whose.empty()) throw Failed{Outcome::error, whose};
  if (read_state() == "armed")
    link_->write(Device::control, "arm", owned("0"));  // by us, before the link broke
  set_conditions(shot.conditions);
  link_->write(Device::control, "arm", owned("1"));
  const SealedShot latched = read_sealed();
  if (latched.text.empty() && read_state() == "idle")
    throw Failed{Outcome::error, "disarmed before it was fired: " + last_error()};
  if (latched.stage != "armed") throw LinkBroken{0, "the rig does not say what it has armed"};
  refuse_other_set_points(latched, shot.conditions);
  shot.boot = latched.boot;
  shot.number = latched.shot;
}

/// Polls `state`: waiting for a shot is no reason to block in a refill. False: it fires still.
bool IioRig::wait_while_firing(Clock::time_point deadline) {
  auto pause = std::chrono::microseconds(200);
  while (read_state() == "firing") {
    const auto now = Clock::now();
    if (now > deadline) return false;
    if (now - renewed_ > heartbeat) claim(now);
    std::this_thread::sleep_for(pause);
    pause = std::min(pause * 5 / 4, std::chrono::microseconds(10'000));
  }
  return true;
}

/// From an armed shot, or one that may have been fired before the link broke, to its record.
Record IioRig::finish(OpenShot& shot, Clock::time_point deadline) {
  for (;;) {
    const SealedShot s = read_sealed();
    if (s.text.empty() || s.boot != shot.boot || s.shot != shot.number) {
      if (read_state() == "fault" && (s.text.empty() || s.boot == shot.boot)) throw trip();
      throw Failed{Outcome::error,
                   s.text.empty() ? "the shot was cut short: " + last_error()
                                  : "the rig holds another shot: it was restarted or used by somebody else"};
    }
    refuse_other_set_points(s, shot.conditions);
    if (s.complete()) return read_record(s, shot.conditions);
    if (s.stage == "armed") {
      // behind the deadline a record that is there is still read, but nothing is fired
      if (Clock::now() > deadline && read_state() == "armed") give_up();
      if (const std::string whose = claim(Clock::now()); !whose.empty()) throw Failed{Outcome::error, whose};
      if (stopped()) {
        abort();
        throw Failed{Outcome::aborted, std::string(stopped_words)};
      }
      const bool again = shot.may_have_fired;
      shot.may_have_fired = true;
      try {
        link_->write(Device::control, "fire", owned("1"));
      } catch (const Refusal& r) {
        if (!again || r.error != EAGAIN) throw;  // the first one was only late, and has arrived by now
      }
    }
    if (!wait_while_firing(deadline)) give_up();
  }
}

void IioRig::give_up() {
  abort();
  throw Failed{Outcome::timeout, "the rig did not finish in time"};
}

/// The record of a shot that has failed, where the rig has completed it all the same: in the moment between the last
/// look and the stop, or behind an answer that arrived as a refusal.
std::optional<Record> IioRig::kept(const OpenShot& shot) {
  if (!shot.may_have_fired) return std::nullopt;
  if (!link_) throw LinkBroken{0, "the rig went away while it was told to stop"};
  const SealedShot s = read_sealed();
  if (s.boot != shot.boot || s.shot != shot.number || !s.complete()) return std::nullopt;
  refuse_other_set_points(s, shot.conditions);
  return read_record(s, shot.conditions);
}

Record IioRig::read_record(const SealedShot& sealed, const Conditions& conditions) {
  Record record = to_record(sealed);
  record.conditions = conditions;
  const auto samples = static_cast<std::size_t>(sealed.samples);
  std::vector<std::uint8_t> scans = link_->read_scans(samples);
  // opening again rewinds; once is a disturbed line, twice is a fault
  if (crc32(scans) != sealed.record_crc) scans = link_->read_scans(samples);
  if (crc32(scans) != sealed.record_crc)
    throw LinkBroken{0, "the record does not match the checksum in its sealed shot"};
  for (std::size_t c = 0; c < record.channels.size(); ++c) {
    auto& raw = record.channels[c].raw;
    raw.resize(samples);
    for (std::size_t i = 0; i < samples; ++i) {
      const std::uint8_t* at = scans.data() + 2 * (i * channel_count + c);
      raw[i] = static_cast<std::int16_t>(static_cast<std::uint16_t>(at[0] | at[1] << 8));
    }
  }
  return record;
}

std::string IioRig::last_error() {
  return link_->read(Device::control, "last_error");
}

Failed IioRig::trip() {
  std::string why = last_error();
  why = why.substr(0, why.find(", then write 1 to abort"));  // done here
  if (why.starts_with("mains phase"))                        // its edge is withheld
    why = why.substr(0, why.find(": see")) + ", so the coil was not switched on; now " + link_->phase();
  const bool again = may_try_again(std::atoi(link_->read(Device::control, "fault").c_str()));
  if (again) abort();
  return {Outcome::error, "the rig tripped: " + why, true, !again};
}

/// One go at the open shot over the link there is. Throws LinkBroken.
Shot IioRig::attempt(Clock::time_point deadline) {
  Shot shot;
  OpenShot& open = *open_;
  std::optional<Record> record;
  try {
    if (!open.may_have_fired) arm(open, deadline);
    record = finish(open, deadline);
  } catch (const Failed& f) {
    shot.outcome = f.outcome;
    shot.reason = f.reason;
    shot.interlock = f.interlock;
    shot.latched = f.latched;
    record = kept(open);
  } catch (const Refusal& r) {
    const std::string why = last_error();
    const std::string state = read_state();  // an answer out of step would be no state
    shot.outcome = Outcome::error;
    shot.interlock = r.error == EPERM;
    shot.latched = state == "fault";
    shot.reason = sentence(r) + (why.empty() || why == "no error" ? "" : ": " + advice(why));
    record = kept(open);
  }
  if (record) {
    shot = Shot{};
    shot.record = std::move(*record);
    const bool lossy = shot.record.overruns > 0 || !shot.record.gaps.empty();
    shot.outcome = lossy ? Outcome::error : Outcome::pass;
    if (lossy) shot.reason = "samples were lost inside the record";
  }
  open_.reset();
  return shot;
}

Shot IioRig::fire(const Conditions& conditions, milliseconds limit) {
  open_ = OpenShot{conditions, {}, 0, false};
  return *recover(limit);
}

std::optional<Shot> IioRig::recover(milliseconds limit) {
  if (!open_) return std::nullopt;
  const auto deadline = Clock::now() + limit;
  Shot lost;
  lost.rig_lost = true;
  lost.reason = "not connected to the rig";
  auto pause = milliseconds(20);
  for (int breaks = 0; breaks < most_breaks;) {
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - Clock::now());
    if (!link_ && !connect_same(std::min(limit_, std::max(left, least_connection)))) {
      // a shot that was not fired can wait for whoever looks for the rig; one that was is worth looking for
      if (!open_->may_have_fired || Clock::now() + pause > deadline) break;
      std::this_thread::sleep_for(pause);
      pause = std::min(2 * pause, milliseconds(1000));
      continue;
    }
    try {
      return attempt(deadline);
    } catch (const LinkBroken& b) {
      link_.reset();
      ++breaks;
      lost.outcome = b.error == ETIMEDOUT ? Outcome::timeout : Outcome::error;
      lost.reason = b.sentence;
    }
    if (Clock::now() > deadline) break;
  }
  // without a number or a fire nothing can have come of it
  if (!open_->may_have_fired) open_.reset();
  return lost;
}

bool IioRig::abort() {
  if (!link_) return false;
  try {
    link_->write(Device::control, "abort", owned("1"));
    return true;
  } catch (const LinkBroken&) {
    link_.reset();
  } catch (const Refusal&) {
    link_.reset();  // a stop is never refused
  }
  return false;
}

bool IioRig::connect_same(milliseconds limit) {
  const RigInfo before = info_;
  try {
    connect(limit);
  } catch (const RigError&) {
    link_.reset();
    info_ = before;
    return false;
  }
  const bool same = info_.serial == before.serial && info_.model == before.model;
  if (!same) {
    link_.reset();
    info_ = before;
  }
  return same;
}

bool IioRig::reconnect() {
  return connect_same(limit_);
}

}  // namespace

std::unique_ptr<Rig> connect_iio(const std::string& uri, milliseconds limit, milliseconds request) {
  return std::make_unique<IioRig>(uri, limit, request);
}

}  // namespace powbench::rigs
