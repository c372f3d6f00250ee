#include "firmware/calibration_store.h"

namespace powbench::firmware {

void CalibrationStore::open(CalibrationMemory& memory) {
  memory_ = &memory;
  unsigned damaged = 0;
  for (unsigned slot = 0; slot < CalibrationMemory::slots; ++slot) {
    const auto bytes = memory.read(slot);
    if (CalibrationMemory::blank(bytes)) continue;
    const auto found = decode_slot(bytes);
    if (!found) {
      ++damaged;
    } else if (found->number > number_) {
      number_ = found->number;
      newest_ = slot;
      draft_ = found->calibration;
    }
  }
  intact_ = damaged == 0 || number_ != 0;
  state_ = number_ != 0 ? (damaged != 0 ? State::one_slot_damaged : State::stored)
                        : (damaged != 0 ? State::damaged : State::none);
}

bool CalibrationStore::submit() {
  if (!memory_ || state_ == State::writing) return false;
  state_ = State::writing;
  return true;
}

bool CalibrationStore::save() {
  const unsigned slot = 1 - newest_;
  SlotBytes bytes;
  encode_slot(draft_, number_ + 1, bytes);
  bool same = memory_->write(slot, bytes);
  const auto back = memory_->read(slot);
  same = same && back.size() == bytes.size();
  for (std::size_t i = 0; same && i < bytes.size(); ++i) same = back[i] == bytes[i];
  state_ = same ? State::stored : State::write_failed;
  if (!same) return false;
  intact_ = true;
  newest_ = slot;
  ++number_;
  return true;
}

}  // namespace powbench::firmware
