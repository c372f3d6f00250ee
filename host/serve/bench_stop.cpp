#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/serve/bench_impl.h"

/// The stop: nothing is fired from its arrival on, and only the rig's own word ends it.

namespace powbench::host {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds stop_time{2000};

double seconds_since(std::chrono::steady_clock::time_point t) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count();
}

/// A confirmation is true of its moment.
std::string time_of_day() {
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  return fmt::format("{:%H:%M:%S} UTC", fmt::gmtime(std::chrono::system_clock::to_time_t(now)));
}

/// The newest conversion of the coil current, in words. A rig that cannot tell has confirmed its state all the same;
/// a line that breaks is made anew.
std::string coil_current(std::unique_ptr<rigs::RigWatch>& line, const rigs::RigInfo& rig) try {
  const auto channel = std::find_if(rig.channels.begin(), rig.channels.end(),
                                    [](const auto& c) { return c.id == info(Channel::coil_current).iio_id; });
  if (channel == rig.channels.end()) return "coil current not known";
  return fmt::format("coil current {:.1f} mA",
                     1e3 * std::fabs(channel->scale * line->newest(Channel::coil_current)));
} catch (const rigs::RigError&) {
  line.reset();
  return "coil current not read";
}

/// Why what answers at the address is not the rig that the bench has: only that one can confirm its coil. "" = it is.
std::string another_rig(const rigs::RigInfo& there, const rigs::RigInfo& expected) {
  if (there.model == expected.model && there.serial == expected.serial && there.boot_id == expected.boot_id)
    return {};
  return fmt::format("{} {} (boot {}) answers in the place of {} {} (boot {})", there.model, there.serial,
                     there.boot_id, expected.model, expected.serial, expected.boot_id);
}

}  // namespace

StopAnswer Bench::Impl::stop() {
  const auto begun = std::chrono::steady_clock::now();
  struct Stopping {
    explicit Stopping(std::atomic<int>& n) : count(n) { ++count; }
    ~Stopping() { --count; }
    std::atomic<int>& count;
  } const under_way(stopping);
  stop_flag = true;  // from here on nothing is fired; what is in flight is stopped below
  stopped_at = now();
  const std::scoped_lock one(stop_mutex);
  StopAnswer answer;
  answer.text = "the rig has not confirmed that its coil is off";
  rigs::RigInfo expected;  // the rig that may be energised: the job's, else the one on the page
  std::string late;
  {
    const std::scoped_lock lock(mutex);  // whoever waits has seen the flag, or sleeps and is woken
    expected = job ? job_rig : rig_now();
    if (job && !job->shots.empty() && job->done - job->cut == job->shots.size()) {
      job->stopped_late = true;
      late = "; all closings were already fired";
    }
  }
  wake.notify_all();
  std::string another;
  while (seconds_since(begun) < std::chrono::duration<double>(stop_time).count()) {
    try {
      if (!stop_line) {
        stop_line = std::make_unique<rigs::RigWatch>(endpoint.uri, milliseconds(500));
        another = another_rig(stop_line->info(), expected);
      }
      stop_line->stop();
      if (!another.empty()) throw rigs::RigError(another);
      const bool nobody = !inside;  // before the rig is asked: nothing can arm it afterwards
      const std::string state = stop_line->state();
      if (nobody && rigs::coil_off(state)) {
        answer.off = true;
        looker->coil_is_off(state);
        answer.ms = 1e3 * seconds_since(begun);
        answer.text = fmt::format("coil off, confirmed by the rig: gate off, {}, at {}{}",
                                  coil_current(stop_line, expected), time_of_day(), late);
        break;
      }
    } catch (const rigs::RigError& e) {
      stop_line.reset();
      answer.text = std::string("THE RIG DOES NOT ANSWER, the coil may be on: ") + e.what();
      std::this_thread::sleep_for(milliseconds(50));
    }
    std::this_thread::sleep_for(milliseconds(1));
  }
  if (!answer.off) answer.ms = 1e3 * seconds_since(begun);
  {
    const std::scoped_lock lock(mutex);
    last_stop = answer;
    log_line(fmt::format("STOP after {:.0f} ms: {}", answer.ms, answer.text));
  }
  changed();
  return answer;
}

/// The line of the thread that fires holds the lease, so nobody else's `abort` ends a fault; no job begins meanwhile.
void Bench::Impl::acknowledge(int number) {
  const auto latched = [&]() -> std::optional<rigs::RigStatus> {
    const auto status = looker->look().status;
    if (!status) throw NotNow("the rig does not answer");
    if (status->state != "fault") return std::nullopt;
    return status;
  };
  struct InUse {
    Impl& bench;
    ~InUse() {
      const std::scoped_lock lock(bench.mutex);
      bench.acknowledging = false;
    }
  };
  {
    const std::scoped_lock lock(mutex);
    if (job) throw NotNow("a job is on: " + job->doing + "; stop it or wait for its end");
    if (stopping > 0) throw NotNow("a stop is under way");
    if (acknowledging) throw NotNow("a fault of the rig is being acknowledged");
    acknowledging = true;
  }
  const InUse in_use(*this);
  const auto before = latched();
  if (!before) return;
  if (std::atoi(before->fault.c_str()) != number)
    throw NotNow(fmt::format("the rig's fault is another one by now: {}", before->fault));
  if (!rig->abort() && !(rig->reconnect() && rig->abort())) throw NotNow("the rig does not answer");
  const auto begun = std::chrono::steady_clock::now();
  for (auto after = before; after; after = latched()) {
    if (seconds_since(begun) > std::chrono::duration<double>(stop_time).count())
      throw NotNow(fmt::format("fault {} remains: {}", after->fault, rigs::advice(after->last_error)));
    std::this_thread::sleep_for(milliseconds(10));
  }
  say(fmt::format("fault {} acknowledged", before->fault));
}

}  // namespace powbench::host
