#pragma once

#include "dsp/signal/signal.h"

namespace powbench::dsp {

/// What the zero of a film did, N.
struct Zero {
  double largest = 0;  ///< error found; 0 = none
  double wander =
      0;  ///< rms: how far it went within a millisecond while nothing touched, beyond model and noise
};

/// Takes out what moves the zero of a film slowly: hum that jumped at switch-on or could not be fitted, pyroelectric
/// drift, a base line that wanders. The record is cut into blocks of 0.1 ms. A block is open when it is one of
/// four in a row that scatter like noise about one straight line, or one of two or three with a contact on either side,
/// and its mean is where the zero may have gone since the last open one. A trough of vibration is neither.
/// Through the open blocks before and after switch-on goes a level, a slope and mains with its third harmonic each;
/// what is left of it is followed from block to block in straight lines and stays after the last. Nothing changes
/// where no millisecond of open time is off zero by five standard uncertainties and half the noise.
/// `noise`: N, one sample.
Zero follow_zero(Signal&, double noise, double mains_hertz);

}  // namespace powbench::dsp
