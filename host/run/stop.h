#pragma once

namespace powbench::host {

/// Ctrl-C and SIGTERM while an object of this class lives: the first asks for a stop after the shot in flight (the coil
/// is switched off by then), the second ends the program at once.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  static bool asked();  ///< false where no object of this class lives
};

}  // namespace powbench::host
