#pragma once

#include <string>

#include "firmware/port/qemu/frame.h"
#include "rigs/board.h"
#include "rigs/qemu_process.h"

namespace powbench::rigs {

/// The firmware on an emulated Cortex-M4F, in lock-step: every call is one frame there and one answer back.
/// All calls throw RigError when the emulator has ended or refuses.
class QemuBoard final : public Board {
 public:
  QemuBoard(bool count_instructions, const firmware::ControllerConfig&, const firmware::Identity&,
            const std::string& image = find_qemu_image());

  void step(std::span<const firmware::Block> blocks, std::vector<firmware::GateEdge>& edges) override;
  const firmware::BenchReport& report() const override { return report_; }
  void publish(const firmware::SetPoints&, const firmware::PlantTruth&) override;
  Answer feed(unsigned connection, std::span<const std::uint8_t> bytes) override;
  Answer resume(unsigned connection) override;
  Answer expire(unsigned connection) override;
  void close(unsigned connection) override;
  void rest(std::int64_t ms) override;
  void adopt_thread() override { process_.share_core(); }

  /// From now on every block's instructions are counted (meaningful when the emulator counts them, too).
  void measure(bool on) { measure_ = on; }
  firmware::lockstep::Cost cost();

  /// Sends bytes as they are and gives the board's refusal, for tests of the line itself.
  firmware::lockstep::Refused send_raw(std::span<const std::uint8_t> bytes);
  /// Sequence number of the next frame.
  std::uint32_t sequence() const { return sequence_; }
  /// Time the emulator has had on a processor so far, s.
  double processor_seconds() const { return process_.processor_seconds(); }
  /// Closes the line; the emulator's exit code.
  int finish() { return process_.finish(); }

 private:
  void begin(firmware::lockstep::Kind kind, unsigned connection = 0);
  Answer exchange(std::vector<firmware::GateEdge>* edges = nullptr);
  std::span<const std::uint8_t> receive_frame();

  QemuProcess process_;
  std::vector<std::uint8_t> outgoing_, incoming_;
  firmware::lockstep::Writer frame_;
  std::size_t taken_ = 0;  ///< bytes at the front of `incoming_` that are done with
  std::uint32_t sequence_ = 0;
  bool measure_ = false;
  firmware::BenchReport report_;
  firmware::lockstep::Cost cost_{};
};

}  // namespace powbench::rigs
