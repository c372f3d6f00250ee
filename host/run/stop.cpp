#include "host/run/stop.h"

#include <unistd.h>

#include <csignal>

#include "core/outcome.h"

namespace powbench::host {

namespace {
volatile std::sig_atomic_t signals_seen = 0;

void on_signal(int) {
  if (signals_seen != 0) _exit(static_cast<int>(Exit::interrupted));
  signals_seen = 1;
}
}  // namespace

StopOnSignal::StopOnSignal() {
  signals_seen = 0;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

StopOnSignal::~StopOnSignal() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  signals_seen = 0;  // nobody is asked any more
}

bool StopOnSignal::asked() {
  return signals_seen != 0;
}

}  // namespace powbench::host
