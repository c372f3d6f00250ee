#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

#include "bench/fault_bench.h"
#include "firmware/bench_devices.h"
#include "firmware/iiod/responder.h"

/// One input of the fuzzer: bytes as a host might send them to a bench that holds a record, or, if the first
/// byte is 0x02, to one that is armed. The byte 0x01 is not sent: there a block of samples passes (eight times
/// at most). Ends the program when something is wrong.
namespace powbench::fuzz {

class ResponderCase {
 public:
  ResponderCase() : captured_((shoot(), bench_.save())), armed_((bench_.arm(), bench_.save())) {}

  void run(std::span<const std::uint8_t> input) {
    const bool armed = !input.empty() && input.front() == 2;
    bench_.restore(armed ? armed_ : captured_);
    firmware::iiod::Connection connection;
    Counter out;
    int blocks = 0;
    while (!input.empty()) {
      if (connection.status() == Status::closed) connection = {};
      if (connection.status() == Status::pending) expire(connection);
      if (input.front() == 1) {
        input = input.subspan(1);
        if (++blocks <= 8) pass();
        continue;
      }
      std::size_t length = 0;
      while (length < input.size() && input[length] != 1) ++length;
      const std::size_t used = responder_.feed(connection, input.first(length), out);
      must(used > 0 && used <= length);
      input = input.subspan(used);
    }
    if (connection.status() == Status::pending) expire(connection);
    fresh_connection_answers();
    pass();
  }

 private:
  using Status = firmware::iiod::Connection::Status;
  struct Counter final : firmware::iiod::ByteSink {
    std::size_t count = 0;
    void put(std::span<const std::uint8_t> bytes) override { count += bytes.size(); }
  };
  struct Keeper final : firmware::iiod::ByteSink {
    std::string text;
    void put(std::span<const std::uint8_t> bytes) override { text.append(bytes.begin(), bytes.end()); }
  };

  /// A short record, so that reading it takes no longer than the rest.
  static firmware::ControllerConfig config() {
    auto c = bench::FaultBench::make_config();
    c.record_length = 100;
    c.pretrigger = 20;
    return c;
  }
  static void must(bool holds) {
    if (!holds) std::abort();
  }

  void shoot() {
    bench_.arm();
    must(bench_.fire_control().fire() == firmware::Refusal::accepted);
    while (bench_.fire_control().state() == firmware::State::firing) bench_.step();
    must(bench_.fire_control().state() == firmware::State::captured);
  }

  void pass() {
    bench_.step();
    const auto& f = bench_.fire_control();
    must(!bench_.world.pin || f.state() == firmware::State::firing);
    must(f.hold_time_ms() >= 1 && f.hold_time_ms() <= 10'000);
    must(f.closing_angle() >= 0 && f.closing_angle() < 36'000);
    must(f.touch_delay_us() >= 0 && f.touch_delay_us() <= 50'000);
  }
  /// A READBUF that waits is answered with one number: come again, or 0 behind the last scan.
  void expire(firmware::iiod::Connection& connection) {
    Keeper answer;
    responder_.expire(connection, firmware::iiod::eagain, answer);
    must((answer.text == "-11\n" || answer.text == "0\n") && connection.status() == Status::ready);
  }
  void fresh_connection_answers() {
    static constexpr std::string_view ask = "VERSION\r\n";
    firmware::iiod::Connection connection;
    Keeper answer;
    responder_.feed(connection, {reinterpret_cast<const std::uint8_t*>(ask.data()), ask.size()}, answer);
    must(answer.text == "0.24.v0.24  \n");
  }

  bench::FaultBench bench_{config()};
  bench::FaultBench::Snapshot captured_, armed_;
  firmware::BenchDevices devices_{bench_.controller};
  std::array<const firmware::iiod::Device*, 3> list_{&devices_.daq(), &devices_.control(),
                                                     &devices_.trigger()};
  firmware::iiod::Context context_{.description = "fuzz", .attributes = {}, .devices = list_};
  firmware::iiod::Responder responder_{context_};
};

}  // namespace powbench::fuzz
