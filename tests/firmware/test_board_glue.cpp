#include <catch2/catch.hpp>
#include <deque>

#include "core/random.h"
#include "firmware/port/common/scan_queue.h"
#include "firmware/port/stm32g474/front_end.h"

/// What the board port decides and computes, apart from its registers.

using namespace powbench;
using namespace powbench::firmware;
namespace board = powbench::firmware::stm32g474;

// --- blocks from converter buffers ---

TEST_CASE("converter buffers become scans in the record's order") {
  // every converter counts in its own hundred, so that a mixed-up channel or rank shows
  constexpr std::size_t samples = 4;
  std::array<std::array<std::uint16_t, 2 * samples>, board::converters> buffers{};
  std::array<port::ConverterHalf, board::converters> halves;
  for (std::size_t c = 0; c < board::converters; ++c) {
    const std::uint8_t ranks = board::sequences[c].ranks;
    for (std::size_t i = 0; i < samples * ranks; ++i)
      buffers[c][i] = static_cast<std::uint16_t>(1000 * (c + 1) + 100 * (i % ranks) + i / ranks);
    halves[c] = {buffers[c].data(), ranks};
  }
  std::array<std::int16_t, samples * channel_count> scans{};
  port::assemble(halves, board::channel_sources, scans);
  const Block block{.scans = scans};
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(samples); ++i) {
    CHECK(block.at(i, Channel::pvdf_a) == 1000 + i - 32768);
    CHECK(block.at(i, Channel::pvdf_b) == 2000 + i - 32768);
    CHECK(block.at(i, Channel::coil_current) == 2 * (3000 + i) - 32768);
    CHECK(block.at(i, Channel::aux) == 2 * (3100 + i) - 32768);
    CHECK(block.at(i, Channel::coil_voltage) == 2 * (4000 + i) - 32768);
    CHECK(block.at(i, Channel::mains_voltage) == 2 * (4100 + i) - 32768);
    CHECK(block.at(i, Channel::laser) == 5000 + i);
    CHECK(block.at(i, Channel::contact_a) == 5100 + i);
  }
}

TEST_CASE("the converter's range fits the record's numbers") {
  constexpr port::ChannelSource wide{.shift = 0, .bipolar = true}, narrow{.shift = 1, .bipolar = true};
  constexpr port::ChannelSource one_sided{.shift = 1, .bipolar = false};
  // 16 or 8 samples of 12 bits: 65520 and 32760 at most; mid-range is zero
  CHECK(port::to_counts(0, wide) == -32768);
  CHECK(port::to_counts(32768, wide) == 0);
  CHECK(port::to_counts(65520, wide) == 32752);
  CHECK(port::to_counts(16384, narrow) == 0);
  CHECK(port::to_counts(32760, narrow) == 32752);
  CHECK(port::to_counts(0, one_sided) == 0);
  CHECK(port::to_counts(32760, one_sided) == 32760);
}

TEST_CASE("halves are taken in turn and a missed one is noticed") {
  using Due = port::HalfOrder::Due;
  port::HalfOrder order;
  CHECK(order.next(false, false) == Due::nothing);
  CHECK(order.next(true, false) == Due::first);
  CHECK(order.next(false, true) == Due::second);
  CHECK(order.next(true, false) == Due::first);
  CHECK(order.next(true, true) == Due::lost);  // the second half ended, and then the first again
  CHECK(order.next(false, true) == Due::second);
  CHECK(order.next(false, true) == Due::lost);  // the first half's flag never came
  CHECK(order.next(true, false) == Due::first);
}

TEST_CASE("the block queue keeps order, and drops the newest when the reader is behind") {
  port::BlockQueue<2, 4> queue;
  Random random(7);
  std::deque<std::int64_t> model;
  std::int64_t sample = 0;
  std::uint32_t dropped = 0;
  for (int i = 0; i < 10'000; ++i) {
    if (random.below(2) == 0) {
      auto* slot = queue.free_slot();
      CHECK((slot == nullptr) == (model.size() == 4));
      if (slot != nullptr) {
        slot->first_sample = sample;
        slot->scans.fill(static_cast<std::int16_t>(sample % 1000));
        queue.commit();
        model.push_back(sample);
      } else {
        ++dropped;
      }
      sample += 2;
    } else {
      const auto* slot = queue.front();
      REQUIRE((slot == nullptr) == model.empty());
      if (slot == nullptr) continue;
      CHECK(slot->first_sample == model.front());
      CHECK(slot->block().at(1, Channel::aux) == model.front() % 1000);
      queue.release();
      model.pop_front();
    }
  }
  CHECK(queue.dropped() == dropped);
  CHECK(dropped > 100);
}

TEST_CASE("any alarm reaches the controller as an open stop chain") {
  using port::Alarms;
  port::BlockQueue<2, 2> queue;
  for (const Alarms& alarms :
       {Alarms{}, Alarms{.stop_open = true}, Alarms{.supply_low = true}, Alarms{.cut_off = true},
        Alarms{.no_crystal = true}, Alarms{.relay_in = true}}) {
    auto* slot = queue.free_slot();
    REQUIRE(slot != nullptr);
    slot->alarms = alarms;
    queue.commit();
    const auto block = queue.front()->block();
    CHECK(block.emergency_stop == alarms.stop_open);
    CHECK(block.brown_out == alarms.supply_low);
    CHECK(block.comparator_trip == alarms.cut_off);
    CHECK(block.clock_failed == alarms.no_crystal);
    CHECK(block.relay_in == alarms.relay_in);
    queue.release();
  }
  CHECK_FALSE(Alarms{}.any());
  CHECK(Alarms{.cut_off = true}.any());
}

// --- front end ---

TEST_CASE("the board's configuration agrees with its circuit") {
  constexpr ControllerConfig c = board::controller_config();
  // 2 A are 1.5 V of 3.3 V in 16 bits
  CHECK(2e3 / (1e-12 * static_cast<double>(c.calibration[index(Channel::coil_current)].scale_pico)) ==
        Approx(65536 * 1.5 / 3.3).epsilon(1e-6));
  // 600 V likewise
  CHECK(600e3 / (1e-12 * static_cast<double>(c.calibration[index(Channel::mains_voltage)].scale_pico)) ==
        Approx(65536 * 1.5 / 3.3).epsilon(1e-6));
  // 100 N on the film: 2.1 nC on 3.3 nF
  const double kilopascal = 100.0 / 25e-6 / 1e3;
  const double counts =
      kilopascal / (1e-12 * static_cast<double>(c.calibration[index(Channel::pvdf_a)].scale_pico));
  CHECK(counts / 65536 * 3.3 == Approx(2.1e-9 / 3.3e-9).epsilon(1e-6));
  CHECK(static_cast<double>(c.calibration[index(Channel::pvdf_a)].corner_microhertz) * 1e-6 ==
        Approx(0.48229).epsilon(1e-4));
  // software trips before hardware, and both inside the range
  CHECK(c.interlocks.overcurrent_counts < 1.9 * 0.75 / 3.3 * 65536);
  CHECK(board::comparator_level(board::cut_off_ampere) < 4096);
  CHECK(board::comparator_level(board::cut_off_ampere) + board::comparator_level(-board::cut_off_ampere) ==
        4096);
  // 16 samples of 19 cycles at 42.5 MHz: the first of two inputs is taken 3.58 us before the second
  const auto delay = [&](Channel x) { return c.calibration[index(x)].delay_ns; };
  CHECK(delay(Channel::coil_voltage) - delay(Channel::mains_voltage) ==
        Approx(8 * 19 / 42.5e6 * 1e9).margin(1));
  // the pre-trigger and the record fit the memory that the linker script gives
  CHECK(c.record_length * 16 < 110'000);
  CHECK(c.pretrigger < c.record_length);
}
