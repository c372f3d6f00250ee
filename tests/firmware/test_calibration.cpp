#include <catch2/catch.hpp>

#include "tests/firmware/bench_fixture.h"

/// The calibration: two slots under a checksum, written by wire, in force at once, and lost loudly.

using namespace powbench;
using namespace powbench::firmware;

namespace {

StoredCalibration sample() {
  StoredCalibration c;
  for (std::size_t n = 0; n < channel_count; ++n)
    c.rows[n] = {.scale_pico = 1'000'000'000 + static_cast<std::int64_t>(n),
                 .delay_ns = 3500 + static_cast<std::int64_t>(n),
                 .corner_microhertz = 482'000,
                 .film_area_pico = 25'000'000,
                 .sensitivity_femto = 21'000,
                 .zero_counts = static_cast<std::int64_t>(n) - 4};
  for (const char letter : std::string_view("PB-7")) c.certificate.id[c.certificate.id_size++] = letter;
  c.certificate.date = 20301231;
  c.certificate.expires = 20311231;
  c.switch_delay_ns = 20'000;
  return c;
}

/// A memory whose writes can be cut short.
struct Slots final : CalibrationMemory {
  Slots() {
    for (auto& s : bytes) s.fill(0xFF);
  }
  std::span<const std::uint8_t> read(unsigned slot) override {
    if (unreadable == static_cast<int>(slot)) return {};
    return bytes[slot];
  }
  bool write(unsigned slot, const SlotBytes& data) override {
    bytes[slot].fill(0xFF);
    std::copy_n(data.begin(), cut, bytes[slot].begin());
    return cut == data.size();
  }
  std::array<SlotBytes, 2> bytes;
  std::size_t cut = slot_bytes;
  int unreadable = -1;
};

void store(Slots& memory, std::string_view id) {
  CalibrationStore s;
  s.open(memory);
  s.draft() = sample();
  s.draft().certificate.id_size = 0;
  for (const char letter : id) s.draft().certificate.id[s.draft().certificate.id_size++] = letter;
  s.submit();
  s.save();
}

ControllerConfig watched() {
  ControllerConfig c = test::Bench::make_config();
  for (auto& row : c.calibration) row = {.scale_pico = 1'000'000'000, .film_area_pico = 25'000'000};
  c.interlocks.contact_open_counts = 10'000;
  c.interlocks.travel_least_counts = 100;
  c.interlocks.travel_most_counts = 20'000;
  c.interlocks.travel_open_counts = 1'000;
  c.interlocks.travel_closed_counts = 9'000;
  return c;
}

}  // namespace

TEST_CASE("a slot comes back as it went, and no bit of it may differ", "[calibration]") {
  SlotBytes bytes;
  encode_slot(sample(), 7, bytes);
  const auto back = decode_slot(bytes);
  REQUIRE(back);
  CHECK(back->number == 7);
  CHECK(back->calibration.certificate.name() == "PB-7");
  CHECK(back->calibration.certificate.expires == 20311231);
  CHECK(back->calibration.switch_delay_ns == 20'000);
  CHECK(rows_crc32(back->calibration.rows) == rows_crc32(sample().rows));
  CHECK(back->calibration.rows[2].zero_counts == -2);
  std::size_t accepted = 0;
  for (std::size_t bit = 0; bit < 8 * slot_bytes; ++bit) {
    SlotBytes damaged = bytes;
    damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ 1U << bit % 8);
    accepted += decode_slot(damaged).has_value();
  }
  CHECK(accepted == 0);
  CHECK_FALSE(decode_slot(std::span(bytes).first(100)));
}

TEST_CASE("days are days of the calendar", "[calibration]") {
  for (const std::int64_t day : {20000101, 20240229, 21991231, 20300630}) CHECK(is_day(day));
  for (const std::int64_t day : {0, 19991231, 20230229, 21000229, 20301301, 20300631, 20300100, 22000101})
    CHECK_FALSE(is_day(day));
}

TEST_CASE("of two slots the newer one counts; a write that is cut anywhere leaves the older one",
          "[calibration]") {
  Slots memory;
  CalibrationStore blank;
  blank.open(memory);
  CHECK(blank.state() == CalibrationStore::State::none);
  CHECK(blank.intact());
  store(memory, "first");
  store(memory, "second");
  CalibrationStore two;
  two.open(memory);
  CHECK(two.number() == 2);
  CHECK(two.draft().certificate.name() == "second");
  for (const std::size_t cut : {0U, 1U, 8U, 100U, 440U, 447U}) {
    Slots torn = memory;
    torn.cut = cut;
    store(torn, "third");
    CalibrationStore after;
    after.open(torn);
    CHECK(after.intact());
    CHECK(after.draft().certificate.name() == "second");
    CHECK(after.state() ==
          (cut == 0 ? CalibrationStore::State::stored : CalibrationStore::State::one_slot_damaged));
    torn.cut = slot_bytes;
    store(torn, "fourth");  // into the damaged one
    CalibrationStore healed;
    healed.open(torn);
    CHECK(healed.state() == CalibrationStore::State::stored);
    CHECK(healed.draft().certificate.name() == "fourth");
  }
  memory.unreadable = 1;
  CalibrationStore half;
  half.open(memory);
  CHECK(half.draft().certificate.name() == "first");
  CHECK(half.state() == CalibrationStore::State::one_slot_damaged);
}

TEST_CASE("a calibration that is lost is a fault until another one is stored", "[calibration][fault]") {
  Slots memory;
  store(memory, "only");
  memory.bytes[0][60] ^= 1;
  std::vector<std::int16_t> storage(4000 * channel_count);
  Controller controller(watched(), storage);
  controller.use_memory(memory);
  CHECK_FALSE(controller.calibrations().intact());
  FireControl& fire = controller.fire_control();
  fire.boot({.stored_config_intact = controller.calibrations().intact()});
  std::int64_t next = 0;
  const auto run = [&](int blocks) {
    for (; blocks > 0; --blocks, next += 10) {
      std::vector<std::int16_t> scans(10 * channel_count);
      for (std::size_t i = 0; i < 10; ++i) {
        scans[i * channel_count] = static_cast<std::int16_t>((next + static_cast<std::int64_t>(i)) % 1000);
        scans[i * channel_count + index(Channel::contact_a)] = 15'000;
        scans[i * channel_count + index(Channel::laser)] = 500;
      }
      controller.step({.first_sample = next, .scans = scans});
    }
  };
  CHECK(fire.fault() == Fault::config_corrupt);
  run(500);  // many rounds of the checksum over the configuration in RAM, which is intact
  fire.abort();
  CHECK(fire.fault() == Fault::config_corrupt);
  CHECK(fire.arm() == Refusal::faulted);

  for (std::size_t n = 0; n < channel_count; ++n)
    CHECK(controller.draft(n, sample().rows[n]) == Refusal::accepted);
  CHECK(controller.propose(sample().certificate, 0) == Refusal::accepted);
  REQUIRE(controller.calibrations().due());
  controller.take_calibration(controller.save_calibration());
  run(2);
  fire.abort();
  run(2);
  CHECK(fire.fault() == Fault::none);
  CHECK(controller.config().calibration_id == "PB-7");
  CHECK(fire.arm() == Refusal::accepted);
  CHECK(controller.draft(0, sample().rows[0]) == Refusal::wrong_state);
  CHECK(controller.propose(sample().certificate, 0) == Refusal::wrong_state);
}

TEST_CASE("thresholds stay where they are in SI when gain and zero change", "[calibration]") {
  ControllerConfig c = watched();
  StoredCalibration k = sample();
  for (auto& row : k.rows) row = {.scale_pico = 1'000'000'000, .film_area_pico = 25'000'000};
  k.rows[index(Channel::coil_current)].scale_pico = 950'000'000;
  k.rows[index(Channel::coil_current)].zero_counts = 40;
  k.rows[index(Channel::contact_a)].scale_pico = 1'050'000'000;
  k.rows[index(Channel::contact_a)].zero_counts = -30;
  k.rows[index(Channel::laser)].zero_counts = 500;
  const InterlockConfig i = calibrated(c.interlocks, c.calibration, k.rows);
  CHECK(i.overcurrent_counts == 21053);  // 20000 / 0.95
  CHECK(i.no_current_counts == 105);
  CHECK(i.current_zero_counts == 40);
  CHECK(i.contact_open_counts == 9494);  // 10000 / 1.05 - 30
  CHECK(i.travel_open_counts == 1500);
  CHECK(i.travel_most_counts == 20'000);  // the sensor's own range
  CHECK(i.mains_lost_counts == c.interlocks.mains_lost_counts);
  CHECK(calibration_error(c, k).empty());

  const auto refused = [&](auto change) {
    StoredCalibration bad = k;
    change(bad);
    return !calibration_error(c, bad).empty();
  };
  CHECK(refused([](auto& b) { b.rows[index(Channel::coil_current)].scale_pico = 880'000'000; }));
  CHECK(refused([](auto& b) { b.rows[index(Channel::coil_current)].scale_pico = 999'999'999'999'999'999; }));
  CHECK(refused([](auto& b) { b.rows[index(Channel::coil_current)].scale_pico = 0; }));
  CHECK(refused([](auto& b) { b.rows[index(Channel::laser)].scale_pico = 450'000'000; }));
  CHECK_FALSE(refused([](auto& b) { b.rows[index(Channel::pvdf_a)].scale_pico = 600'000'000; }));
  CHECK(refused([](auto& b) { b.rows[index(Channel::aux)].zero_counts = 3001; }));
  CHECK(refused([](auto& b) { b.rows[index(Channel::aux)].delay_ns = 1'000'001; }));
  CHECK(refused(
      [](auto& b) { b.rows[index(Channel::mains_voltage)].delay_ns = -30'000; }));  // the edge would be late
  CHECK(refused([](auto& b) { b.rows[index(Channel::pvdf_b)].film_area_pico = 0; }));
  CHECK(refused([](auto& b) { b.switch_delay_ns = -1; }));
}

TEST_CASE(
    "a calibration is written by wire: the owner's, complete, at rest, and the record of before is gone",
    "[calibration]") {
  test::Bench b;
  RamCalibrationMemory memory;
  b.controller.use_memory(memory);
  const auto write = [&](std::string_view name, std::string value) {
    return b.ask("WRITE contactor-ctl " + std::string(name) + " " + std::to_string(value.size()) + "\r\n" +
                 value);
  };
  const auto read = [&](std::string_view what) {
    const std::string answer = b.ask("READ " + std::string(what) + "\r\n");
    const std::size_t line = answer.find('\n') + 1;
    return answer.substr(line, answer.find('\0') - line);
  };
  CHECK(read("contactor-ctl calibration_store") == "none 0");
  CHECK(read("contactor-daq calibration_expires") == "none");
  CHECK(write("calibration_draft", "laser:0:5:-1000:0:0:0") == "-16\n");  // nobody's
  CHECK(write("calibration_draft", "laser:0:5:-1000:0:0 t") == "-22\n");
  CHECK(write("calibration_draft", "lasr:0:5:-1000:0:0:0 t") == "-22\n");
  CHECK(write("calibration_draft", "laser:0:5:-1000:0:0:0:0 t") == "-22\n");
  CHECK(write("calibration_draft", "laser:0:5:-1000:0:0:0 t") == "23\n");
  const std::string sum = read("contactor-ctl calibration_draft");
  const std::string good = "lab:20300101:20310101:2500:" + sum + " t";
  CHECK(write("calibration_store", "lab:20300101:20310101:2500:00000000 t") == "-22\n");
  CHECK(write("calibration_store", "lab:20300101:20291231:2500:" + sum + " t") == "-34\n");
  CHECK(write("calibration_store", ":20300101:20310101:2500:" + sum + " t") == "-22\n");
  // a shot whose record is there, and one under way
  b.fire_control().set_hold_time_ms(10);
  REQUIRE(b.fire_control().arm() == Refusal::accepted);
  b.run(0.2);
  CHECK(write("calibration_store", good) == "-16\n");
  CHECK(write("calibration_draft", "laser:0:6:0:0:0:0 t") == "-16\n");
  REQUIRE(b.fire_control().fire() == Refusal::accepted);
  b.run(0.3);
  REQUIRE(b.fire_control().state() == State::captured);
  CHECK(write("calibration_store", good) == std::to_string(good.size()) + "\n");
  CHECK(read("contactor-ctl calibration_store") == "writing 0");
  CHECK(b.fire_control().arm() == Refusal::wrong_state);
  b.controller.take_calibration(b.controller.save_calibration());
  CHECK(read("contactor-ctl calibration_store") == "stored 1");
  CHECK(read("contactor-daq calibration") == "lab");
  CHECK(read("contactor-daq calibration_date") == "20300101");
  CHECK(read("contactor-daq calibration_expires") == "20310101");
  CHECK(read("contactor-daq INPUT " + std::string(channel_table[index(Channel::laser)].iio_id) + " offset") ==
        "-5");
  CHECK(b.fire_control().state() == State::idle);
  CHECK(read("contactor-daq sealed_shot") == "none");
  CHECK(b.controller.config().fire.gate_delay_samples_256 == 64);  // 2.5 us
  REQUIRE(b.fire_control().arm() == Refusal::accepted);
  b.run(0.2);
  REQUIRE(b.fire_control().fire() == Refusal::accepted);
  b.run(0.3);
  CHECK(b.fire_control().state() == State::captured);
  CHECK(read("contactor-daq sealed_shot").find(" calibration=lab ") != std::string::npos);
}
