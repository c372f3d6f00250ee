#pragma once

#include "dsp/signal/signal.h"

namespace powbench::dsp {

/// A laser slower than the record, with its own clock put right.
struct Unheld {
  Signal signal;  ///< straight lines between the laser's own values
  double late =
      0;  ///< s: standard uncertainty of when a value was new; 0 where the clock was found or nothing is held
};

/// Each value of a slow laser is held until the next one, and the record shows when it is new to one of its samples
/// only. Where the two rates beat, a core under way seems to gain that sample and to lose it again. The laser's clock
/// runs evenly: its period (record samples) and phase are a straight line through the record samples at which the
/// value changed between t1 and t2, and the values are put back to the middle of their hold on that line. Where the
/// changes do not keep to one (more than a twentieth is further off than a record sample), the signal stays as it is
/// and `late` is a record sample over sqrt(12). Record and laser rates must differ by a factor of more than two.
Unheld unheld(const Signal&, double t1, double t2);

}  // namespace powbench::dsp
