#include <catch2/catch.hpp>
#include <vector>

#include "core/random.h"
#include "firmware/port/qemu/exit_codes.h"
#include "firmware/port/qemu/lockstep_board.h"
#include "rigs/qemu_board.h"
#include "tests/pil/emulated.h"
#include "tests/places.h"

/// The line between plant and board: what is not a frame in its turn is refused, and a board that ends is
/// noticed.

using namespace powbench;
using namespace powbench::rigs;
using namespace powbench::test;
namespace lockstep = firmware::lockstep;

namespace {

const firmware::Identity identity{"test", "model", "serial", "0", "specimen"};

firmware::ControllerConfig small_config() {
  firmware::ControllerConfig config;
  config.record_length = 100;
  config.pretrigger = 10;
  return config;
}

/// A frame that asks for the cost; nothing changes when it is accepted.
std::vector<std::uint8_t> cost_frame(std::uint32_t sequence) {
  std::vector<std::uint8_t> memory(lockstep::largest_frame);
  lockstep::Writer writer(memory);
  writer.begin(lockstep::Kind::cost);
  const auto frame = writer.finish(sequence);
  return {frame.begin(), frame.end()};
}

/// The board's end of the line in this process, without an emulator.
struct Local final : lockstep::Platform {
  void send(std::span<const std::uint8_t> frame) override {
    lockstep::Reader reader(frame);
    last = reader.header().kind;
    if (last == lockstep::Kind::refused) why = reader.get<lockstep::Refused>();
  }
  std::span<const firmware::GateEdge> run_block(firmware::Bench& b, const firmware::Block& block,
                                                bool) override {
    return b.step(block);
  }
  lockstep::Cost cost() const override { return {}; }

  lockstep::Kind last{};
  lockstep::Refused why{};
  std::vector<std::int16_t> storage = std::vector<std::int16_t>(2000);
  std::vector<std::uint8_t> out = std::vector<std::uint8_t>(lockstep::largest_frame);
  lockstep::LockstepBoard board{*this, storage, out};
};

std::vector<std::uint8_t> configure_frame(std::int64_t record_length, std::uint32_t phase_bytes) {
  const firmware::ControllerConfig config = small_config();
  std::vector<std::uint8_t> memory(lockstep::largest_frame);
  lockstep::Writer writer(memory);
  writer.begin(lockstep::Kind::configure);
  writer.put(lockstep::Configure{config.sample_rate,
                                 record_length,
                                 10,
                                 sizeof config.calibration,
                                 phase_bytes,
                                 sizeof config.fire,
                                 sizeof config.interlocks,
                                 lockstep::block_input_bytes,
                                 sizeof(lockstep::Answer),
                                 sizeof(firmware::GateEdge),
                                 {1, 1, 1, 1, 1, 1, 1},
                                 {}});
  writer.put(config.calibration);
  writer.put(config.phase);
  writer.put(config.fire);
  writer.put(config.interlocks);
  writer.put("abcdefg", 7);
  const auto frame = writer.finish(0);
  return {frame.begin(), frame.end()};
}

}  // namespace

TEST_CASE("a frame with any one byte changed is refused", "[pil]") {
  const auto good = configure_frame(100, sizeof(firmware::PhaseTrackerConfig));
  for (std::size_t i = 0; i < good.size(); ++i) {
    auto bad = good;
    bad[i] ^= 0x40;
    Local local;
    INFO("byte " << i);
    REQUIRE_FALSE(local.board.handle(bad));
    REQUIRE(local.why == lockstep::Refused::damaged);
  }
  Local local;
  CHECK(local.board.handle(good));
  CHECK(local.last == lockstep::Kind::answer);
}

TEST_CASE("a board takes no frame twice, none too early and none of other sources", "[pil]") {
  const std::uint32_t layout = sizeof(firmware::PhaseTrackerConfig);
  const auto configure = configure_frame(100, layout);
  SECTION("before it is configured") {
    Local local;
    CHECK_FALSE(local.board.handle(cost_frame(0)));
    CHECK(local.why == lockstep::Refused::unknown_kind);
  }
  SECTION("twice, or one left out") {
    for (const std::uint32_t sequence : {0U, 2U, 0xFFFFFFFFU}) {
      Local local;
      REQUIRE(local.board.handle(configure));
      CHECK_FALSE(local.board.handle(cost_frame(sequence)));
      CHECK(local.why == lockstep::Refused::out_of_step);
    }
  }
  SECTION("of another layout") {
    Local local;
    CHECK_FALSE(local.board.handle(configure_frame(100, layout + 4)));
    CHECK(local.why == lockstep::Refused::other_layout);
  }
  SECTION("a record that does not fit") {
    Local local;
    CHECK_FALSE(local.board.handle(configure_frame(200, layout)));
    CHECK(local.why == lockstep::Refused::too_long);
  }
}

TEST_CASE("correctly sealed nonsense is refused or answered, and never runs beyond its frame", "[pil]") {
  const auto configure = configure_frame(100, sizeof(firmware::PhaseTrackerConfig));
  Random random(11);
  std::vector<std::uint8_t> memory(lockstep::largest_frame);
  int answered = 0, refused = 0;
  for (int i = 0; i < 3000; ++i) {
    Local local;
    REQUIRE(local.board.handle(configure));
    lockstep::Writer writer(memory);
    const auto kind = static_cast<lockstep::Kind>(random.next() % 10);
    writer.begin(kind, static_cast<std::uint16_t>(random.next() % 20));
    const std::size_t n = random.next() % 400;
    for (std::size_t b = 0; b < n; ++b) writer.put(static_cast<std::uint8_t>(random.next() % 4));
    ++(local.board.handle(writer.finish(1)) ? answered : refused);
    CHECK((local.last == lockstep::Kind::answer || local.last == lockstep::Kind::refused));
  }
  CHECK(answered > 100);
  CHECK(refused > 100);
}

TEST_CASE("the emulated board refuses damage and gaps, and ends", "[pil]") {
  if (!emulator_wanted()) return;
  QemuBoard board(false, small_config(), identity);
  auto frame = cost_frame(board.sequence());
  SECTION("damaged") {
    frame[12] ^= 1;
    CHECK(board.send_raw(frame) == lockstep::Refused::damaged);
  }
  SECTION("not a frame at all") {
    CHECK(board.send_raw(std::vector<std::uint8_t>(64, 'x')) == lockstep::Refused::damaged);
  }
  SECTION("one left out") {
    CHECK(board.send_raw(cost_frame(board.sequence() + 1)) == lockstep::Refused::out_of_step);
  }
  CHECK_THROWS_AS(board.cost(), RigError);
}

TEST_CASE("the end of the plant is the normal end of the emulated board", "[pil]") {
  if (!emulator_wanted()) return;
  QemuBoard board(false, small_config(), identity);
  CHECK(board.finish() == static_cast<int>(firmware::exit_end_of_plant));
}

TEST_CASE("an emulated board that cannot be had is one sentence", "[pil]") {
  if (!emulator_wanted()) return;
  auto config = small_config();
  config.record_length = lockstep::longest_record;
  CHECK_THROWS_WITH(QemuBoard(false, config, identity), Catch::Contains("longer than its memory"));
  CHECK_THROWS_WITH(QemuBoard(false, small_config(), identity, test::source_dir() + "/no-such-image.elf"),
                    Catch::Contains("ended"));
}

TEST_CASE("an emergency stop reaches the emulated board", "[pil]") {
  if (!emulator_wanted()) return;
  auto config = small_config();
  config.interlocks = {.overcurrent_counts = 1000,
                       .no_current_counts = 10,
                       .no_current_samples = 800,
                       .stuck_on_samples = 2500,
                       .mains_lost_counts = 1,
                       .mains_lost_samples = 100'000};
  QemuBoard board(false, config, identity);
  const std::string arm = "WRITE iio:device1 lease 9\r\nt 3600000WRITE iio:device1 arm 3\r\n1 t";
  board.feed(0, {reinterpret_cast<const std::uint8_t*>(arm.data()), arm.size()});
  REQUIRE(board.report().state == firmware::State::armed);
  // a front end that lives: samples that differ
  std::vector<std::int16_t> scans(10 * channel_count);
  for (std::size_t i = 0; i < scans.size(); ++i) scans[i] = static_cast<std::int16_t>(i % 7);
  std::vector<firmware::GateEdge> edges;
  const firmware::Block calm{.first_sample = 0, .scans = scans, .owner_present = true};
  board.step({&calm, 1}, edges);
  REQUIRE(board.report().state == firmware::State::armed);
  const firmware::Block stop{
      .first_sample = 10, .scans = scans, .emergency_stop = true, .owner_present = true};
  board.step({&stop, 1}, edges);
  CHECK(board.report().state == firmware::State::fault);
  CHECK(edges.empty());
}
