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

void shoot(rigs::SimWorld& world, const std::string& centi_degrees) {
  for (const std::string& request : {std::string("WRITE iio:device1 arm 1\r\n1"),
                                     "WRITE iio:device1 OUTPUT phase0 raw " +
                                         std::to_string(centi_degrees.size()) + "\r\n" + centi_degrees,
                                     std::string("WRITE iio:device1 fire 1\r\n1")}) {
    world.board().feed(0, {reinterpret_cast<const std::uint8_t*>(request.data()), request.size()});
    world.notice_commands();
  }
  while (world.busy()) world.run(0.010);
  if (world.board().report().state != firmware::State::captured)
    throw RigError("the shot whose instructions are counted has failed");
  const std::string read = "PRINT\r\nREAD iio:device0\r\nREAD iio:device1\r\n";  // for the stack
  world.board().feed(0, {reinterpret_cast<const std::uint8_t*>(read.data()), read.size()});
}

}  // namespace

std::vector<CostRow> measure_firmware_cost() {
  rigs::SimWorld world({}, {}, {rigs::BoardOptions::Kind::emulated, true});
  auto& board = dynamic_cast<rigs::QemuBoard&>(world.board());
  board.measure(true);
  shoot(world, "0");
  shoot(world, "9000");
  const auto cost = board.cost();

  // the timer runs at 25 MHz, an instruction takes 64 ns of virtual time
  constexpr double ticks_per_instruction = 1.6;
  const double empty = cost.empty_ticks;
  const auto mean = [&](std::uint64_t ticks, std::uint32_t blocks) {
    return (static_cast<double>(ticks) / blocks - empty) / ticks_per_instruction;
  };
  const double plain = mean(cost.plain_ticks, cost.plain_blocks);
  const double update = mean(cost.update_ticks, cost.update_blocks);
  const double blocks = cost.plain_blocks + cost.update_blocks;
  const double per_block = (plain * cost.plain_blocks + update * cost.update_blocks) / blocks;
  auto section = section_sizes(rigs::find_qemu_image());
  return {
      {"control_path_per_sample", "instructions", per_block * blocks / cost.samples},
      {"control_path_without_estimate_per_sample", "instructions", plain * blocks / cost.samples},
      {"estimate", "instructions", update - plain},
      {"worst_block_of_10_samples", "instructions", (cost.worst_ticks - empty) / ticks_per_instruction},
      {"flash", "B", section[".text"] + section[".ARM.exidx"] + section[".data"]},
      {"static_ram_without_record", "B", section[".data"] + section[".bss"]},
      {"worst_stack", "B", static_cast<double>(cost.stack_bytes)},
  };
}

}  // namespace powbench::bench
