#pragma once

#include "firmware/calibration.h"

/// Two slots that outlive the power, and the draft of what comes into the older one.

namespace powbench::firmware {

/// A port's memory for calibrations. Both calls belong to the main loop; a write may take as long as a page's erasure.
class CalibrationMemory {
 public:
  static constexpr unsigned slots = 2;

  /// slot_bytes bytes as they stand there; empty: they cannot be read.
  virtual std::span<const std::uint8_t> read(unsigned slot) = 0;
  /// Erases the slot and writes it. False: not written, the slot may be damaged, the other one is as it was.
  virtual bool write(unsigned slot, const SlotBytes&) = 0;
  /// The slot holds what an erased memory holds.
  static bool blank(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t b : bytes)
      if (b != 0xFF) return false;
    return !bytes.empty();
  }

 protected:
  ~CalibrationMemory() = default;
};

/// Slots in RAM: of a rig whose board is not there after it has been switched off.
class RamCalibrationMemory final : public CalibrationMemory {
 public:
  RamCalibrationMemory() {
    for (SlotBytes& slot : slots_) slot.fill(0xFF);
  }
  std::span<const std::uint8_t> read(unsigned slot) override { return slots_[slot]; }
  bool write(unsigned slot, const SlotBytes& bytes) override { return slots_[slot] = bytes, true; }

 private:
  std::array<SlotBytes, slots> slots_{};
};

class CalibrationStore {
 public:
  enum class State : std::uint8_t {
    no_memory,  ///< the port keeps none
    none,       ///< both slots are blank
    stored,
    one_slot_damaged,  ///< the other one is in force: it may be older than what was written last
    damaged,           ///< something was stored, and nothing of it can be read
    writing,
    write_failed,  ///< what was in force stays in force
  };

  /// Reads both slots and takes the newer intact one. Once, before anything else.
  void open(CalibrationMemory&);

  State state() const { return state_; }
  /// Something that was stored is lost: a bench whose calibration is not known must not be armed.
  bool intact() const { return intact_; }
  /// Number of the write that is in force; 0: none is.
  std::uint32_t number() const { return number_; }

  /// Behind open(): what is in force; later, what the next write stores.
  StoredCalibration& draft() { return draft_; }
  const StoredCalibration& draft() const { return draft_; }

  /// What open() found is not of this front end.
  void reject() { state_ = State::damaged, intact_ = false; }

  /// The draft is to be stored; refused (false) without a memory or while one is being written.
  bool submit();
  bool due() const { return state_ == State::writing; }
  /// Writes the draft into the slot that is not in force, and reads it back. Long; nothing else may touch the store.
  bool save();

 private:
  CalibrationMemory* memory_ = nullptr;
  StoredCalibration draft_{};
  std::uint32_t number_ = 0;
  unsigned newest_ = 1;  ///< slot in force; the first write goes into slot 0
  State state_ = State::no_memory;
  bool intact_ = true;
};

}  // namespace powbench::firmware
