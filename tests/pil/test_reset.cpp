#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>

#include "tests/pil/emulated.h"
#include "tests/places.h"

using namespace powbench;

/// Processor faults, the watchdog and a serial port on the emulated processor: an image of its own, without a plant.

namespace {

struct Run {
  int exit_code;
  std::string output;
};

/// `input`: what the serial port receives.
Run run_check_image(const std::string& mode, const std::string& input = {}, const std::string& options = {}) {
  const std::string in = "check_image_" + mode + ".in";
  std::ofstream(in, std::ios::binary) << input;
  const std::string command =
      "timeout 60 qemu-system-arm -M mps2-an386 -display none -monitor none -serial stdio "
      "-kernel " +
      test::reset_image() + " -semihosting-config enable=on,target=native,arg=" + mode + options + " <" + in +
      " 2>&1";
  Run run{-1, {}};
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  char data[4096];
  for (std::size_t n; (n = std::fread(data, 1, sizeof data, pipe)) > 0;) run.output.append(data, n);
  const int status = pclose(pipe);
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  std::remove(in.c_str());
  return run;
}

}  // namespace

TEST_CASE("the control step may interrupt the background anywhere", "[pil]") {
  if (!test::emulator_wanted()) return;
  // time by instructions, so that every run interrupts at the same places
  const Run run = run_check_image("preempt", {}, " -icount shift=6,align=off,sleep=off");
  INFO(run.output);
  CHECK(run.exit_code == 0);
}

TEST_CASE("a processor fault while energised: off, a note, a new start, and a latched fault",
          "[pil][fault]") {
  if (!test::emulator_wanted()) return;
  for (const std::string mode : {"undefined", "bus"}) {
    const Run run = run_check_image(mode);
    INFO(mode << ": " << run.output);
    CHECK(run.exit_code == 0);
    CHECK(run.output.find("start 2: fault crash_reset cause 1 pc ") != std::string::npos);
    CHECK(run.output.find("pc 00000000") == std::string::npos);
  }
}

TEST_CASE("a stack that overflows while energised runs into nothing and is a fault like the others",
          "[pil][fault]") {
  if (!test::emulator_wanted()) return;
  const Run run = run_check_image("overflow");
  INFO(run.output);
  CHECK(run.exit_code == 0);
  CHECK(run.output.find("start 2: fault crash_reset cause 7") != std::string::npos);
}

TEST_CASE("a main loop that hangs while energised is ended by the watchdog", "[pil][fault]") {
  if (!test::emulator_wanted()) return;
  const Run run = run_check_image("watchdog");
  INFO(run.output);
  CHECK(run.exit_code == 0);
  CHECK(run.output.find("start 2: fault watchdog_reset") != std::string::npos);
}

TEST_CASE("a shot that nothing kills is told from a reset", "[pil]") {
  if (!test::emulator_wanted()) return;
  CHECK(run_check_image("nothing").exit_code == 7);
}

TEST_CASE("the emulated serial port speaks the protocol", "[pil]") {
  if (!test::emulator_wanted()) return;
  const Run run = run_check_image("uart", "VERSION\r\nREAD iio:device1 state\r\nPRINT\r\nNONSENSE\r\n\x04");
  INFO(run.output.substr(0, 300));
  CHECK(run.exit_code == 0);
  CHECK(run.output.starts_with("0.24.v0.24  \n"));
  CHECK(run.output.find("5\nidle") != std::string::npos);
  CHECK(run.output.find("</context>") != std::string::npos);
  CHECK(run.output.size() > 4000);
  CHECK(run.output.ends_with("-22\n"));
}
