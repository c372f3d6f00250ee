#pragma once

#include <string>
#include <vector>

/// The interlocks of the firmware as a person reads them: the table of firmware/faults.h in words.

namespace powbench::rigs {

struct InterlockLine {
  int number = 0;
  std::string name, watched, reaction;
  std::string limit;    ///< time from the cause until the coil is off, "120 us", or "at once"
  std::string when;     ///< in a shot, always, command, start
  std::string cleared;  ///< what ends it once it has latched
  std::string advice;   ///< what happened and what to do, one sentence
};

/// In the order of their numbers, of the firmware that this program was built with.
std::vector<InterlockLine> interlock_list();

/// Mains, phase, samples, host or sensors were at fault, not the coil's circuit: the next shot may be tried. Any other
/// fault stays latched for a person to read, and every shot is refused until then.
bool may_try_again(int fault);

}  // namespace powbench::rigs
