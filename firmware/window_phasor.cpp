#include "firmware/window_phasor.h"

#include "firmware/math.h"

namespace powbench::firmware {

WindowPhasor window_phasor(const MainsRing& mains, float cycle) {
  const float length = window_cycles * cycle;
  const auto last = static_cast<int>(length);
  // h turns once in the window: the Hann weight is 1 + Re h, the reference exp(j 2 pi f (age - age_m)) is
  // h^2.
  const float step_c = cos_turns(1.0F / length);
  const float step_s = sin_turns(1.0F / length);
  float h_c = -1.0F;
  float h_s = 0.0F;
  float re = 0.0F;
  float im = 0.0F;
  float sum = 0.0F;
  float square = 0.0F;
  float weight = 0.0F;
  for (int age = 0; age <= last; ++age) {
    const float w = 1.0F + h_c;
    const float x = mains.back(age);
    const float wx = w * x;
    weight += w;
    sum += wx;
    square += wx * x;
    re += wx * (h_c * h_c - h_s * h_s);
    im += wx * (2.0F * h_c * h_s);
    const float next = h_c * step_c - h_s * step_s;
    h_s = h_c * step_s + h_s * step_c;
    h_c = next;
  }
  // x = A sin(phase_m - 2 pi f (age - age_m)) makes Z = (A / 2j) exp(j phase_m) sum w.
  WindowPhasor phasor;
  phasor.turns = wrap_turns(atan2_turns(re, -im));
  phasor.age = 0.5F * length;
  phasor.amplitude = 2.0F * square_root(re * re + im * im) / weight;
  phasor.offset = sum / weight;
  const float fundamental = 0.5F * phasor.amplitude * phasor.amplitude;
  const float rest = square / weight - phasor.offset * phasor.offset - fundamental;
  phasor.residual = rest < 1.0e6F * fundamental ? square_root(rest / (fundamental + 1.0e-12F)) : 1000.0F;
  return phasor;
}

}  // namespace powbench::firmware
