#pragma once

/// Second-order generalised integrator with an offset state, followed by a phase-locked loop.

namespace powbench::firmware {

/// Follows v(t) = A sin(2 pi theta) + offset, in units of the nominal amplitude.
///
///   e = v - x1 - d,   x1 += k w T e,   d += k_d w T e,   then (x1, x2) turns by w T,
///   theta' = f + k_p s,   f' = k_i s,   s = sin(2 pi (phi - theta)) from (x1, x2) = A (sin phi, -cos phi).
///
/// The integrator pair is turned exactly, so no frequency is warped; after a push the state stands one sample
/// ahead and the accessors bring it back. Source: the usual SOGI-PLL of the grid-converter literature,
/// discretised by rotation.
class SogiPll {
 public:
  struct Config {
    float rate = 10000.0F;        ///< Hz
    float nominal_hertz = 50.0F;  ///< Hz, start of the loop
    float gain = 1.41421356F;     ///< k: band width of the integrator, of its frequency
    float offset_gain = 0.25F;    ///< k_d; 0 switches the offset state off
    float loop_hertz = 8.0F;      ///< natural frequency of the loop, damping 0.707
  };

  explicit SogiPll(const Config& config);
  void reset();
  void push(float value);

  float turns() const;  ///< [0, 1) at the last pushed sample
  float hertz() const { return hertz_; }
  float amplitude() const;  ///< of the nominal amplitude, peak
  float offset() const { return offset_; }

 private:
  Config config_;
  float period_;  ///< s
  float proportional_;
  float integral_;
  float direct_ = 0;
  float quadrature_ = 0;
  float offset_ = 0;
  float theta_ = 0;  ///< turns, one sample ahead
  float hertz_ = 0;
  bool lost_ = true;  ///< no input worth following
};

}  // namespace powbench::firmware
