#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <functional>

namespace powbench::test {

/// Runs `act` in a process of its own, which ends without a word; returns its exit code, or -1.
inline int in_another_process(const std::function<void()>& act) {
  const pid_t child = fork();
  if (child == 0) {
    try {
      act();
    } catch (...) {
      _exit(1);
    }
    _exit(0);
  }
  int status = 0;
  return waitpid(child, &status, 0) == child ? status : -1;
}

}  // namespace powbench::test
