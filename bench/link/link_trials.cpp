#include "bench/link/link_trials.h"

#include <chrono>
#include <stdexcept>
#include <thread>

#include "bench/link/plain_client.h"
#include "bench/uart_board.h"
#include "core/phase.h"
#include "core/random.h"
#include "rigs/bridge/bridge.h"
#include "rigs/iio_rig.h"
#include "rigs/iiod_server.h"

namespace powbench::bench {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds shot_limit{4000};
// of one request, and of a connection: a bridge needs the time of its own first look at the board
constexpr milliseconds tcp_request{200}, tcp_connection{600}, serial_request{1000}, serial_connection{3000};
constexpr int stall_ms = 450;
constexpr int different_shots = 5;
constexpr int tcp_rigs = 4;  // side by side: most of a trial is waiting

rigs::SimRigConfig short_record() {
  rigs::SimRigConfig config;
  config.record_length = 0.012;
  config.pretrigger = 0.002;
  return config;
}

Conditions conditions(int i) {
  Conditions c;
  c.closing_angle = radians(67.0 * (i % different_shots));
  c.hold_time = 0.005;
  c.seed = static_cast<std::uint64_t>(i % different_shots) + 1;
  return c;
}

/// Equal in everything but the number of the shot and what that stands in.
bool same(const Record& a, const Record& b) {
  if (a.crc32 != b.crc32 || a.sample_rate != b.sample_rate || a.fire_sample != b.fire_sample ||
      a.fire_offset != b.fire_offset || a.overruns != b.overruns || a.rig != b.rig ||
      a.firmware != b.firmware || a.calibration != b.calibration || a.channels.size() != b.channels.size() ||
      a.gaps.size() != b.gaps.size())
    return false;
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    const ChannelRecord &x = a.channels[c], &y = b.channels[c];
    if (x.raw != y.raw || x.scale != y.scale || x.offset != y.offset || x.delay != y.delay ||
        x.corner_hertz != y.corner_hertz)
      return false;
  }
  return true;
}

/// Over a connection that has all the time it wants.
std::vector<Record> undisturbed(const std::string& uri) {
  constexpr std::chrono::seconds patience{60};
  const auto own = rigs::connect_iio(uri, patience, patience);
  rigs::Rig& rig = *own;
  std::vector<Record> records;
  for (int i = 0; i < different_shots; ++i) {
    const rigs::Shot shot = rig.fire(conditions(i), std::chrono::seconds(30));
    if (shot.outcome != Outcome::pass) throw std::runtime_error("no undisturbed record: " + shot.reason);
    records.push_back(shot.record);
  }
  return records;
}

/// What a trial needs of the line and of the rig behind it.
struct Bed {
  std::function<void(const LineFault&)> set;
  std::function<bool()> struck;
  std::function<std::uint64_t(bool to_rig)> passed;
  std::function<int()> operations;       ///< times the coil was energised
  std::function<bool()> holds_a_record;  ///< complete, of the last shot armed
  std::vector<LineFault::Kind> kinds;
};

void judge(FaultRow& row, const rigs::Shot& shot, const Record& wanted, bool fetched) {
  if (shot.outcome != Outcome::pass) return;
  if (!same(shot.record, wanted))
    ++row.silent;
  else
    ++(fetched ? row.fetched : row.same);
}

/// Length of an undisturbed shot in bytes, either way. The patience of the trials' client is short, so that on a busy
/// machine the line may need another look.
std::array<std::uint64_t, 2> undisturbed_traffic(rigs::Rig& rig, const Bed& bed) {
  constexpr int tries = 50;
  for (int i = 0; i < tries; ++i) {
    bed.set({});
    const rigs::Shot shot = rig.fire(conditions(0), std::chrono::seconds(30));
    if (shot.outcome == Outcome::pass) return {bed.passed(false), bed.passed(true)};
    if (shot.rig_lost) rig.reconnect();
  }
  throw std::runtime_error("no undisturbed shot in " + std::to_string(tries));
}

/// Trials first, first + step, ... below `count`: what each does depends on its number alone.
std::vector<FaultRow> run_trials(rigs::Rig& rig, const std::vector<Record>& wanted, const Bed& bed, int count,
                                 std::uint64_t seed, const Progress& progress, int first = 0, int step = 1) {
  const std::array<std::uint64_t, 2> traffic = undisturbed_traffic(rig, bed);
  std::vector<FaultRow> rows;
  for (const auto kind : bed.kinds)
    for (const bool to_rig : {false, true}) rows.push_back({.kind = kind, .to_rig = to_rig});
  for (int i = first; i < count; i += step) {
    Random random(seed + static_cast<std::uint64_t>(i));
    FaultRow& row = rows[static_cast<std::size_t>(i) % rows.size()];
    const std::size_t which = random.below(different_shots);
    // one half into the commands and short answers, which are few bytes among those of the record
    std::uint64_t span = traffic[row.to_rig ? 1 : 0];
    if (random.below(2) == 0) span = std::min<std::uint64_t>(span, 3000);
    const LineFault fault{row.kind, row.to_rig, random.below(span), static_cast<int>(random.below(8))};
    const int before = bed.operations();
    bed.set(fault);
    const auto start = Clock::now();
    rigs::Shot shot = rig.fire(conditions(static_cast<int>(which)), shot_limit);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    ++row.tried;
    row.struck += bed.struck() ? 1 : 0;
    bed.set({});
    row.longest = std::max(row.longest, seconds);
    row.late += seconds > trial_deadline() ? 1 : 0;
    const int silent = row.silent;
    judge(row, shot, wanted[which], false);
    std::string said = shot.reason;
    if (shot.rig_lost) {
      // as a campaign does: look for the rig, then for what it may still hold
      for (int tries = 0; tries < 20 && !rig.reconnect(); ++tries) {
      }
      if (auto late = rig.recover(shot_limit)) {
        shot = std::move(*late);
        judge(row, shot, wanted[which], true);
        said += ", then: " + shot.reason;
      }
    }
    const int fired = bed.operations() - before;
    const bool lost = shot.outcome != Outcome::pass && fired > 0 && bed.holds_a_record();
    row.twice += fired > 1 ? 1 : 0;
    row.reported += shot.outcome != Outcome::pass ? 1 : 0;
    if (shot.outcome != Outcome::pass) ++row.reasons[said];
    row.lost += lost ? 1 : 0;
    const bool late = seconds > trial_deadline();
    if (late || lost || fired > 1 || row.silent > silent)
      row.wrong.push_back("trial " + std::to_string(i) + " of seed " + std::to_string(seed) + ", " +
                          std::to_string(seconds) + " s, fired " + std::to_string(fired) + " times" +
                          (lost ? ", record lost" : "") + ": " + said);
    if (progress) progress(i + step, count);
  }
  return rows;
}

/// What a bystander reads, over a connection of its own: the server may hang up on one that was silent for long, as on
/// a busy machine between two looks.
std::string look(const std::string& address, const std::string& attribute) {
  constexpr int tries = 10;
  std::string value;
  for (int i = 0; i < tries; ++i) {
    value = PlainClient(address).read(attribute);
    if (value != PlainClient::gone) return value;
  }
  throw std::runtime_error("the rig on " + address + " does not say its " + attribute);
}

/// One rig, one line and one client.
std::vector<FaultRow> tcp_share(int count, std::uint64_t seed, const Progress& progress, int first) {
  using Kind = LineFault::Kind;
  rigs::LocalRig server(short_record(), {});
  rigs::FaultLine line(server.address(), stall_ms);
  const std::vector<Record> wanted = undisturbed("ip:" + server.address());
  const auto rig = rigs::connect_iio("ip:" + line.address(), tcp_connection, tcp_request);
  const Bed bed{.set = [&](const LineFault& f) { line.set(f); },
                .struck = [&] { return line.struck(); },
                .passed = [&](bool to_rig) { return line.passed(to_rig); },
                .operations = [&] { return std::stoi(look(server.address(), "iio:device1 operations")); },
                .holds_a_record =
                    [&] {
                      return look(server.address(), "iio:device0 sealed_shot").find(" stage=complete ") !=
                             std::string::npos;
                    },
                .kinds = {Kind::flip, Kind::drop, Kind::close, Kind::delay, Kind::stall, Kind::half_open}};
  return run_trials(*rig, wanted, bed, count, seed, progress, first, tcp_rigs);
}

}  // namespace

double trial_deadline() {
  return std::chrono::duration<double>(shot_limit + rigs::least_connection + 2 * serial_request).count();
}

std::vector<FaultRow> tcp_faults(int count, std::uint64_t seed, const Progress& progress) {
  std::array<std::vector<FaultRow>, tcp_rigs> shares;
  std::vector<std::thread> threads;
  for (int t = 0; t < tcp_rigs; ++t)
    threads.emplace_back([&, t] {
      shares[static_cast<std::size_t>(t)] = tcp_share(count, seed, t == 0 ? progress : Progress(), t);
    });
  for (auto& thread : threads) thread.join();
  for (int t = 1; t < tcp_rigs; ++t)
    for (std::size_t r = 0; r < shares[0].size(); ++r) shares[0][r] += shares[static_cast<std::size_t>(t)][r];
  return shares[0];
}

std::vector<FaultRow> serial_faults(int count, std::uint64_t seed, const Progress& progress) {
  using Kind = LineFault::Kind;
  UartBoard board(short_record(), {}, 2e6);
  rigs::BridgeOptions options;
  options.port = board.port();
  options.baud = 2'000'000;
  options.silence = milliseconds(250);
  options.probe = milliseconds(200);
  const rigs::LocalBridge bridge(options);
  const std::vector<Record> wanted = undisturbed("ip:" + bridge.address());
  const auto rig = rigs::connect_iio("ip:" + bridge.address(), serial_connection, serial_request);
  const Bed bed{.set = [&](const LineFault& f) { board.set(f); },
                .struck = [&] { return board.struck(); },
                .passed = [&](bool to_rig) { return board.passed(to_rig); },
                .operations = [&] { return board.operations(); },
                .holds_a_record = [&] { return board.holds_a_record(); },
                .kinds = {Kind::flip, Kind::drop, Kind::delay, Kind::stall}};
  return run_trials(*rig, wanted, bed, count, seed, progress);
}

}  // namespace powbench::bench
