#include "host/store/in_flight.h"

#include <mutex>

namespace powbench::host {
namespace {

struct Program {
  std::mutex mutex;
  std::multiset<std::tuple<std::string, std::int64_t, int>> shots;
};

Program& program() {
  static Program all;
  return all;
}

}  // namespace

InFlight::~InFlight() {
  const std::scoped_lock lock(program().mutex);
  for (const Shot& shot : own_) program().shots.erase(program().shots.find(shot));
}

void InFlight::begin(std::int64_t campaign, int number) {
  const Shot shot{file_, campaign, number};
  if (!own_.insert(shot).second) return;
  const std::scoped_lock lock(program().mutex);
  program().shots.insert(shot);
}

void InFlight::end(std::int64_t campaign, int number) {
  const Shot shot{file_, campaign, number};
  if (own_.erase(shot) == 0) return;
  const std::scoped_lock lock(program().mutex);
  program().shots.erase(program().shots.find(shot));
}

bool InFlight::elsewhere(std::int64_t campaign, int number) const {
  const Shot shot{file_, campaign, number};
  const std::scoped_lock lock(program().mutex);
  return program().shots.count(shot) > own_.count(shot);
}

}  // namespace powbench::host
