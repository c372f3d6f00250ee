#pragma once

#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>

#include "rigs/qemu_process.h"
#include "rigs/rig.h"
#include "rigs/sim_world.h"

/// The emulated board as the tests need it. A machine without the cross-compiler or the emulator fails these
/// tests, in so many words; POWBENCH_WITHOUT_EMULATOR=1 leaves them out, and nothing in CI sets it.
namespace powbench::test {

inline bool emulator_wanted() {
  const char* without = std::getenv("POWBENCH_WITHOUT_EMULATOR");
  if (without == nullptr || std::string(without) != "1") return true;
  WARN("NOT TESTED: the emulated board is left out on request");
  return false;
}

/// A world and one client of its board.
struct Client {
  explicit Client(const rigs::BoardOptions& options, const rigs::SimRigConfig& config = {})
      : world(config, {}, options) {}

  std::string ask(const std::string& request) {
    std::string out;
    std::span<const std::uint8_t> rest(reinterpret_cast<const std::uint8_t*>(request.data()), request.size());
    while (!rest.empty()) {
      const auto answer = world.board().feed(0, rest);
      out.append(answer.bytes.begin(), answer.bytes.end());
      rest = rest.subspan(answer.used);
      world.notice_commands();
      if (answer.status != rigs::Board::Status::ready) break;
    }
    return out;
  }
  std::string write(const std::string& device, const std::string& attribute, const std::string& value) {
    return ask("WRITE " + device + " " + attribute + " " + std::to_string(value.size()) + "\r\n" + value);
  }
  /// A command of the owner; the first one claims the bench.
  std::string control(const std::string& attribute, const std::string& value) {
    std::string answer = owner_ ? std::string() : write("iio:device1", "lease", "t 3600000");
    owner_ = true;
    return answer + write("iio:device1", attribute, value + " t");
  }

  rigs::SimWorld world;

 private:
  bool owner_ = false;
};

constexpr rigs::BoardOptions native{};
constexpr rigs::BoardOptions counting{rigs::BoardOptions::Kind::emulated, true};

}  // namespace powbench::test
