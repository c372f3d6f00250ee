#pragma once

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

/// The only place in the tests that reads a clock or sleeps (tests/architecture holds that). A test waits for what it
/// is about: a row in the store, a state of the rig, a byte on the line. No outcome depends on how long that takes.
namespace powbench::test {

/// Looks again and again until `happened()` is true. The deadline ends a hang and nothing else: it is far longer than
/// any wait on the slowest machine. Throws, with `what` in the text, when it is over.
template <class Condition>
void wait_until(const std::string& what, Condition&& happened) {
  constexpr std::chrono::minutes deadline{5};
  const auto end = std::chrono::steady_clock::now() + deadline;
  while (!happened()) {
    if (std::chrono::steady_clock::now() > end) throw std::runtime_error("waited 5 minutes for: " + what);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

}  // namespace powbench::test
