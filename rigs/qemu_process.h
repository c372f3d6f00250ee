#pragma once

#include <sys/types.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace powbench::rigs {

/// `qemu-system-arm` running an image, with a pipe in each direction. Ends with the object, and by itself
/// when this process ends: the image stops at the end of its input.
class QemuProcess {
 public:
  /// `count_instructions`: virtual time is the number of instructions (64 ns each) and nothing else. Throws
  /// RigError with one sentence.
  QemuProcess(const std::string& image, bool count_instructions);
  ~QemuProcess();
  QemuProcess(const QemuProcess&) = delete;
  QemuProcess& operator=(const QemuProcess&) = delete;

  /// Throws RigError when the emulator has ended.
  void send(std::span<const std::uint8_t> bytes);
  /// Appends what is there, waiting for at least one byte. Throws RigError when none comes within 30 s or the
  /// emulator has ended.
  void receive(std::vector<std::uint8_t>& to);

  /// Puts the calling thread on the emulator's core. The two take turns, and waking a sleeper on another core
  /// costs several times the work in between.
  void share_core() const;

  /// Time the emulator has had on a processor so far, s (Linux; resolution 10 ms).
  double processor_seconds() const;

  /// Ends the line; the exit code of the emulator, or -1 when it had to be killed.
  int finish();

 private:
  [[noreturn]] void gone();

  pid_t pid_ = -1;
  int to_ = -1, from_ = -1;
  int core_ = -1;
};

/// The image of the emulated board: $POWBENCH_FIRMWARE, or `powbench-qemu.elf` beside the running program, or
/// the one this program was built with. Throws RigError when there is none.
std::string find_qemu_image();

}  // namespace powbench::rigs
