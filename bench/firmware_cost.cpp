#include "bench/firmware_cost.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <span>

#include "rigs/qemu_board.h"
#include "rigs/rig.h"
#include "rigs/sim_world.h"

namespace powbench::bench {

namespace {

using rigs::RigError;

/// Section sizes of a 32-bit little-endian ELF file. Reference: "Tool Interface Standard ELF Specification",
/// 1.2.
std::map<std::string, double> section_sizes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string file{std::istreambuf_iterator<char>(in), {}};
  const auto word = [&](std::size_t at, std::size_t bytes) {
    if (at + bytes > file.size()) throw RigError(path + " is no ELF image");
    std::uint32_t value = 0;
    std::memcpy(&value, file.data() + at, bytes);
    return value;
  };
  if (!file.starts_with("\x7f"
                        "ELF\x01\x01"))
    throw RigError(path + " is no 32-bit ELF image");
  const std::size_t table = word(32, 4), entry = word(46, 2), count = word(48, 2), names = word(50, 2);
  const std::size_t name_table = word(table + names * entry + 16, 4);
  std::map<std::string, double> sizes;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = table + i * entry;
    sizes[file.c_str() + name_table + word(at, 4)] = word(at + 20, 4);
  }
  return sizes;
}

using firmware::lockstep::Cost;

constexpr double ticks_per_instruction =
    1.6;  // the timer runs at 25 MHz, an instruction takes 64 ns of virtual time

/// Instructions a sample of the control path between two readings.
double control_path(const Cost& from, const Cost& to) {
  const double ticks = static_cast<double>(to.control_ticks - from.control_ticks) -
                       static_cast<double>(to.empty_ticks) * (to.blocks - from.blocks);
  return ticks / ticks_per_instruction / (to.samples - from.samples);
}

/// The parts of a shot, with what the processor has done up to the end of each.
struct Shot {
  Cost before, armed, waited, energised, ended;
};

Shot shoot(rigs::SimWorld& world, rigs::QemuBoard& board, const std::string& centi_degrees) {
  const auto ask = [&](const std::string& request) {
    board.feed(0, {reinterpret_cast<const std::uint8_t*>(request.data()), request.size()});
    world.notice_commands();
  };
  Shot shot;
  shot.before = board.cost();
  const std::string angle = centi_degrees + " t";
  ask("WRITE iio:device1 lease 9\r\nt 3600000");
  ask("WRITE iio:device1 OUTPUT phase0 raw " + std::to_string(angle.size()) + "\r\n" + angle);
  ask("WRITE iio:device1 arm 3\r\n1 t");
  shot.armed = board.cost();
  ask("WRITE iio:device1 fire 3\r\n1 t");
  while (world.busy() && !board.report().gate_on) world.run(0.0001);
  shot.waited = board.cost();
  while (board.report().gate_on) world.run(0.0001);
  shot.energised = board.cost();
  while (world.busy()) world.run(0.0001);
  shot.ended = board.cost();
  if (board.report().state != firmware::State::captured)
    throw RigError("the shot whose instructions are counted has failed");
  ask("PRINT\r\nREAD iio:device0\r\nREAD iio:device1\r\n");  // for the stack
  return shot;
}

}  // namespace

std::vector<CostRow> measure_firmware_cost() {
  rigs::SimWorld world({}, {}, {rigs::BoardOptions::Kind::emulated, true, {}});
  auto& board = dynamic_cast<rigs::QemuBoard&>(world.board());
  board.measure(true);
  const Shot shot = shoot(world, board, "0");
  shoot(world, board, "9000");
  const Cost cost = board.cost();

  const double empty = cost.empty_ticks;
  const auto mean = [&](std::uint64_t ticks, std::uint32_t blocks) {
    return (static_cast<double>(ticks) / blocks - empty) / ticks_per_instruction;
  };
  const auto once = [&](std::uint32_t ticks) { return (ticks - empty) / ticks_per_instruction; };
  const double plain = mean(cost.background_ticks, cost.blocks - cost.update_blocks);
  const double update = mean(cost.update_ticks, cost.update_blocks);
  const double all = static_cast<double>(cost.control_ticks + cost.background_ticks + cost.update_ticks) -
                     2 * empty * cost.blocks;
  auto section = section_sizes(rigs::find_qemu_image());
  return {
      {"control_path_per_sample", "instructions", control_path({}, cost), 150},
      {"control_path_armed_per_sample", "instructions", control_path(shot.before, shot.armed), 150},
      {"control_path_waiting_per_sample", "instructions", control_path(shot.armed, shot.waited), 150},
      {"control_path_energised_per_sample", "instructions", control_path(shot.waited, shot.energised), 150},
      {"control_path_worst_block_of_10", "instructions", once(cost.worst_control_ticks), 3000},
      {"background_per_block_of_10", "instructions", plain, 2000},
      {"estimate_per_update", "instructions", update - plain, 15000},
      {"background_worst_block_of_10", "instructions", once(cost.worst_background_ticks), 25000},
      {"all_levels_per_sample", "instructions", all / ticks_per_instruction / cost.samples, 500},
      {"flash", "B", section[".text"] + section[".ARM.exidx"] + section[".data"], 0},
      {"static_ram_without_record", "B", section[".data"] + section[".bss"], 0},
      {"worst_stack", "B", static_cast<double>(cost.stack_bytes), 0},
  };
}

}  // namespace powbench::bench
