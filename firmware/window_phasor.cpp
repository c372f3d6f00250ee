#include "firmware/window_phasor.h"

#include "firmware/math.h"

namespace powbench::firmware {

WindowPhasor window_phasor(const MainsRing& mains, float cycle, int middle) {
  const auto whole = static_cast<int>(cycle);
  const float part = cycle - static_cast<float>(whole);
  // h turns once in two cycles: the Hann weight is 1 + Re h, the reference is h^2.
  const float step_c = cos_turns(0.5F / cycle);
  const float step_s = sin_turns(0.5F / cycle);
  float h_c = step_c;
  float h_s = step_s;
  const float centre = mains.back(middle);
  float weight = 2.0F;
  float sum = 2.0F * centre;
  float square = 2.0F * centre * centre;
  float re = 2.0F * centre;
  float im = 0.0F;
  float late_re = 0.5F * centre;
  float late_im = 0.0F;
  float last_re = 0.0F;
  float last_im = 0.0F;
  for (int i = 1; i <= whole; ++i) {
    const float newer = mains.back(middle - i);
    const float older = mains.back(middle + i);
    const float c = h_c * h_c - h_s * h_s;
    const float s = 2.0F * h_c * h_s;
    const float w = 1.0F + h_c;
    const float both = newer + older;
    weight += w + w;
    sum += w * both;
    square += w * (newer * newer + older * older);
    re += w * c * both;
    im += w * s * (newer - older);
    last_re = c * newer;
    last_im = s * newer;
    late_re += last_re;
    late_im += last_im;
    const float next = h_c * step_c - h_s * step_s;
    h_s = h_c * step_s + h_s * step_c;
    h_c = next;
  }
  // The last point counts half for what lies before it; behind it a part of an interval is left, a straight line.
  const float end = mains.back(middle - whole - 1);
  const float end_share = 0.5F * part * part;
  const float last_share = part - end_share - 0.5F;
  late_re += last_share * last_re + end_share * end * (h_c * h_c - h_s * h_s);
  late_im += last_share * last_im + end_share * end * (2.0F * h_c * h_s);
  // x = A sin(phase_m + 2 pi f (t - t_m)) makes Z = (A / 2) sum w (sin phase_m, cos phase_m).
  WindowPhasor phasor;
  phasor.turns = wrap_turns(atan2_turns(re, im));
  phasor.late_turns = wrap_turns(atan2_turns(late_re, late_im) + 0.5F);
  phasor.amplitude = 2.0F * square_root(re * re + im * im) / weight;
  phasor.offset = sum / weight;
  const float fundamental = 0.5F * phasor.amplitude * phasor.amplitude;
  const float rest = square / weight - phasor.offset * phasor.offset - fundamental;
  phasor.residual = rest < 1.0e6F * fundamental ? square_root(rest / (fundamental + 1.0e-12F)) : 1000.0F;
  return phasor;
}

}  // namespace powbench::firmware
