#pragma once

#include <ctime>

/// CPU time for tables of speed, s.

namespace powbench {

namespace detail {
inline double clock_seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
}  // namespace detail

inline double thread_cpu_seconds() {
  return detail::clock_seconds(CLOCK_THREAD_CPUTIME_ID);
}
/// Of all threads.
inline double process_cpu_seconds() {
  return detail::clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
}

}  // namespace powbench
