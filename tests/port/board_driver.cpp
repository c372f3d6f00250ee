#include "tests/port/board_driver.h"

#include <cmath>
#include <map>
#include <stdexcept>

#include "bench/fault_bench.h"

namespace powbench::test {

using bench::FaultWorld;

namespace {

using Causes = FaultWorld::Causes;
using Act = void (*)(Causes&, bool);

const std::map<std::string, Act> acts{
    {"stop_open", [](Causes& c, bool on) { c.emergency_stop = on; }},
    {"mains_off", [](Causes& c, bool on) { c.mains = on ? 0.0 : 1.0; }},
    {"overcurrent", [](Causes& c, bool on) { c.comparator = c.coil_shorted = on; }},
    {"supply_low", [](Causes& c, bool on) { c.brown_out = on; }},
    {"samples_lost", [](Causes& c, bool on) { c.drop = on; }},
    {"coil_open", [](Causes& c, bool on) { c.coil_open = on; }},
    {"owner_silent", [](Causes& c, bool on) { c.host_silent = on; }},
    {"laser_out", [](Causes& c, bool on) { c.laser_out = on; }},
    {"relay_welded", [](Causes& c, bool on) { c.relay_stuck = on; }},
    {"relay_dead", [](Causes& c, bool on) { c.relay_dead = on; }},
    {"switch_shorted", [](Causes& c, bool on) { c.switch_stuck = on; }},
    {"contact_welded", [](Causes& c, bool on) { c.contact_stuck = on; }},
    {"control_hangs", [](Causes& c, bool on) { c.blocks_stop = on; }}};

std::string path_of(const std::string& attribute) {
  return attribute == "angle" ? "OUTPUT phase0 raw" : attribute;
}

}  // namespace

BoardDriver::BoardDriver(const rigs::BoardOptions& options)
    : board_(rigs::make_board(options, bench::FaultBench::make_config(), {})) {
  scans_.resize(std::size_t{FaultWorld::block_samples} * channel_count);
  previous_ = scans_;
  ask("WRITE contactor-ctl lease 9\r\nt 3600000");
  run(130'000);
}

std::string BoardDriver::ask(const std::string& request) {
  std::string out;
  std::span<const std::uint8_t> rest(reinterpret_cast<const std::uint8_t*>(request.data()), request.size());
  while (!rest.empty()) {
    const auto answer = board_->feed(0, rest);
    out.append(answer.bytes.begin(), answer.bytes.end());
    rest = rest.subspan(answer.used);
    if (answer.status != rigs::Board::Status::ready) throw std::runtime_error("the board closed: " + request);
  }
  return out;
}

std::string BoardDriver::read(const std::string& attribute) {
  std::string answer = ask("READ contactor-ctl " + path_of(attribute) + "\r\n");
  const std::size_t line = answer.find('\n');
  const int length = std::stoi(answer);
  if (length < 0) return std::to_string(length);
  std::string value = answer.substr(line + 1, static_cast<std::size_t>(length));
  while (!value.empty() && value.back() == '\0') value.pop_back();
  return value;
}

int BoardDriver::write(const std::string& attribute, const std::string& value) {
  const std::string text = value + " t";
  return std::stoi(
      ask("WRITE contactor-ctl " + path_of(attribute) + " " + std::to_string(text.size()) + "\r\n" + text));
}

void BoardDriver::cause(const std::string& name, bool begins) {
  const auto act = acts.find(name);
  if (act == acts.end()) throw std::runtime_error("no such cause: " + name);
  act->second(world_.causes, begins);
}

void BoardDriver::step() {
  const auto& report = board_->report();
  const FaultWorld::Told told{report.state != firmware::State::firing, report.relay_closed};
  for (std::size_t i = 0; i < static_cast<std::size_t>(FaultWorld::block_samples); ++i)
    world_.sample(&scans_[i * channel_count], told);
  ++world_.counter;
  if (world_.causes.blocks_stop) return;
  edges_.clear();
  const firmware::Block block = world_.block(scans_, previous_);
  board_->step({&block, 1}, edges_);
  world_.schedule(edges_);
  for (const auto& edge : edges_)
    if (edge.on) on_edge_ = edge.at;
  previous_ = scans_;
}

void BoardDriver::run(double time) {
  for (const double end = now() + time; now() < end;) step();
}

double BoardDriver::angle() const {
  const double sample = static_cast<double>(on_edge_.sample) + on_edge_.fraction / 65536.0;
  return 360.0 * std::fmod(sample / FaultWorld::cycle, 1.0);
}

}  // namespace powbench::test
