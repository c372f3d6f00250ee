#include <array>
#include <atomic>
#include <cstdint>
#include <string_view>

#include "core/crc32.h"
#include "core/version.h"
#include "firmware/bench_devices.h"
#include "firmware/controller.h"
#include "firmware/port/common/gate_timer.h"
#include "firmware/port/common/progress.h"
#include "firmware/port/common/uart_link.h"
#include "firmware/port/stm32g474/board.h"
#include "firmware/port/stm32g474/calibration_flash.h"
#include "firmware/port/stm32g474/clock.h"
#include "firmware/port/stm32g474/converters.h"
#include "firmware/port/stm32g474/front_end.h"
#include "firmware/port/stm32g474/gate_output.h"
#include "firmware/port/stm32g474/guard.h"
#include "firmware/port/stm32g474/registers/core.h"
#include "firmware/port/stm32g474/serial.h"
#include "firmware/text.h"

extern "C" const std::uint32_t flash_end[];  // from link.ld

/// The bench on the board. Four levels: the samples interrupt collects a block, the control interrupt runs the
/// controller on it, the background renews the phase estimate and the checksums, the main loop answers the serial port.

namespace powbench::firmware::stm32g474 {
namespace {

[[gnu::section(".record")]] std::array<std::int16_t, (record_length + block_samples) * channel_count>
    record_memory;

constexpr ControllerConfig configuration = controller_config();

struct Board {
  CalibrationFlash calibrations;
  Controller controller{configuration, record_memory};
  BenchDevices devices{controller};
  std::array<const iiod::Device*, 3> device_list{&devices.daq(), &devices.control(), &devices.trigger()};
  port::Progress progress;
  Converters converters;
  Converters::Queue queue;
  port::GateTimer gate{time_base};
  Serial serial{progress};
  port::AbortScan aborts;
  bool may_fire = false;                  ///< the crystal runs
  std::atomic<bool> gate_refused{false};  ///< an on edge met an active cut-off
};

Board& board() {
  static Board instance;
  return instance;
}

/// Full tick count now, from the counter and the samples collected so far.
std::int64_t now(const Board& b) {
  // the samples interrupt may come between the two halves of the index: read until it stays
  std::int64_t samples = b.converters.samples();
  for (std::int64_t again;; samples = again) {
    asm volatile("" : : : "memory");
    again = b.converters.samples();
    if (again == samples) return time_base.unwrap(gate_counter(), samples - 1);
  }
}

void drive_gate(Board& b) {
  for (;;) {
    const auto action = b.gate.poll(now(b));
    if (action.write == port::GateTimer::Write::nothing) return;
    if (!write_gate(action)) b.gate_refused = true;
  }
}

/// Off, and nothing left that could go on again, whenever the controller says that the gate must be low: an edge it has
/// given out stays in the timer for up to 300 us. After every block and every command.
void hold_inhibited_gate(Board& b) {
  if (!b.controller.fire_control().gate_inhibited() || (b.gate.idle() && !gate_open())) return;
  b.gate.cancel();
  gate_off();
}

/// Around every access of the main loop to the controller.
void controller_lock(bool held) {
  if (!held) hold_inhibited_gate(board());
  hold_off_controller(held);
}

/// What a client sees of the board itself. The texts live as long as the program.
struct Identity {
  TextOf<96> serial, boot, fault;
  std::array<iiod::ContextAttribute, 9> attributes{};
};

std::span<const iiod::ContextAttribute> identify(Identity& id, bool crystal, std::string_view cause) {
  // the chip's own 96-bit number
  const auto* unique = reinterpret_cast<const std::uint32_t*>(std::uintptr_t{0x1FFF'7590});
  for (int word = 2; word >= 0; --word) id.serial.put_hex32(unique[word]);
  id.boot.put_unsigned(postmortem.boots);
  id.fault.put_unsigned(postmortem.exception).put(" pc ").put_hex32(postmortem.program_counter);
  id.fault.put(" lr ").put_hex32(postmortem.link_register).put(" cfsr ").put_hex32(postmortem.fault_status);
  id.attributes = {{{"bench,kind", "board"},
                    {"boot_id", id.boot.view()},
                    {"clock", crystal ? "crystal" : "internal, firing is blocked"},
                    {"fw_version", program_version},
                    {"hw_model", "NUCLEO-G474RE"},
                    {"hw_serial", id.serial.view()},
                    {"last_fault", postmortem.exception != 0 ? id.fault.view() : std::string_view("none")},
                    {"protocol_version", "1"},
                    {"reset_cause", cause}}};
  return id.attributes;
}

/// An abort is heard at any time: while the estimate is computed, while a record is on its way out for half a second.
/// On the level of the control step, which nothing that touches the controller interrupts.
void listen(Board& b) {
  for (auto bytes = b.serial.overheard(); !bytes.empty(); bytes = b.serial.overheard()) {
    for (const std::uint8_t byte : bytes)
      if (b.aborts.take(byte))
        b.controller.fire_control().stop();  // what goes beyond stopping, the request does in its turn
  }
  hold_inhibited_gate(b);
}

/// CRC-32 of the program in flash, the same as of board.bin.
std::uint32_t image_crc32() {
  const auto end = reinterpret_cast<std::uintptr_t>(flash_end);
  return crc32({reinterpret_cast<const std::uint8_t*>(flash_start), end - flash_start});
}

/// While the gate is off and the supply stands; the controller runs on meanwhile, the serial port waits.
void store_calibration(Board& b) {
  if (!b.controller.calibrations().due() || !b.controller.fire_control().flash_writes_allowed()) return;
  const bool saved = b.controller.save_calibration();
  controller_lock(true);
  b.controller.take_calibration(saved);
  controller_lock(false);
}

[[noreturn]] void serve(Board& b, const iiod::Context& context) {
  iiod::Responder responder(context);
  port::UartLink link(responder);
  for (;;) {
    if (b.serial.line_error()) link.line_error();
    const auto bytes = b.serial.received();
    if (!bytes.empty()) link.take(bytes, b.serial);
    store_calibration(b);
    b.progress.moved(port::Progress::main_loop);
  }
}

}  // namespace
}  // namespace powbench::firmware::stm32g474

using namespace powbench::firmware;
using namespace powbench::firmware::stm32g474;

/// The converters have filled half of their buffers.
extern "C" void samples_handler() {
  Board& b = board();
  const bool refused = b.gate_refused.exchange(false);
  const port::Alarms alarms{.stop_open = stop_open() || cut_by(Cut::stop),
                            .supply_low = supply_low() || cut_by(Cut::supply),
                            .cut_off = cut_off_tripped() || refused,
                            .no_crystal = !b.may_fire,
                            .relay_in = relay_in()};
  b.converters.collect(b.queue, alarms);
  b.progress.moved(port::Progress::samples);
  scb().icsr.write(Scb::icsr_pendsv_set);
}

/// The controller's turn: every block in the queue, and the gate after each.
extern "C" void control_handler() {
  Board& b = board();
  while (const auto* slot = b.queue.front()) {
    Block block = slot->block();
    block.late = b.converters.samples() - block.first_sample - block.samples();
    for (const GateEdge& edge : b.controller.control(block)) b.gate.take(edge);
    // the controller has seen it: no edge of before is left
    const bool cut_known = slot->alarms.stop_open || slot->alarms.supply_low;
    b.queue.release();
    hold_inhibited_gate(b);
    drive_gate(b);
    if (cut_known) forget_cut();
    // out of a shot the relay drops: a coil that stays on with its gate off has no other way to go off
    if (b.controller.fire_control().relay_closed()) pump_safety_relay();
    b.progress.moved(port::Progress::control);
    nvic().pend(irq_background);
  }
  listen(b);  // a line that is never idle
  if (b.progress.may_feed()) feed_watchdog();
}

/// The line has been idle for the time of a byte.
extern "C" void serial_handler() {
  Board& b = board();
  b.serial.note_idle();
  listen(b);
}

/// What may take longer than a block.
extern "C" void background_handler() {
  Board& b = board();
  b.controller.background();
  b.progress.moved(port::Progress::background);
}

extern "C" [[noreturn]] void run_bench() {
  const auto cause = take_reset_cause();
  start_watchdog();
  const bool crystal = start_clock();
  start_supply_monitor();
  set_up_gate();
  enable_cuts();
  feed_watchdog();

  static Identity identity;
  Board& b = board();
  b.may_fire = crystal;
  b.controller.use_memory(b.calibrations);
  b.controller.fire_control().boot({.cause = reset_cause(cause),
                                    .survivor = &survivor,
                                    .stored_config_intact = b.controller.calibrations().intact(),
                                    .unfit = option_byte_error()});
  const iiod::Context context{.description = "powbench on NUCLEO-G474RE",
                              .attributes = identify(identity, crystal, cause),
                              .devices = b.device_list,
                              .lock = controller_lock};
  b.devices.identify(context.attributes);
  b.controller.identify(
      {.commit = POWBENCH_COMMIT, .board_id = identity.serial.view(), .image_crc32 = image_crc32()});
  scb().shpr[2].change(0xFFU << 16, std::uint32_t{priority_control} << 16);  // PendSV
  nvic().enable(irq_background, priority_background);
  nvic().enable(irq_usart2, priority_control);
  b.converters.set_up();
  b.serial.set_up();
  start_sampling();
  serve(b, context);
}
