#include "firmware/phase_fit.h"

#include "firmware/math.h"

namespace powbench::firmware {

PhaseFit fit_phase(std::span<const PhasePoint> points, float noise, float expected_rate) {
  const auto count = static_cast<float>(points.size());
  float mean_t = 0.0F;
  float mean_p = 0.0F;
  float extent = 0.0F;
  for (const PhasePoint& point : points) {
    mean_t += point.time;
    mean_p += point.turns;
  }
  mean_t /= count;
  mean_p /= count;
  for (const PhasePoint& point : points) {
    const float t = point.time - mean_t;
    const float size = t < 0.0F ? -t : t;
    if (size > extent) extent = size;
  }
  // u in [-1, 1]; q = u^2 - its mean, so that the constant decouples.
  const float scale = extent > 0.0F ? 1.0F / extent : 0.0F;
  float s2 = 0.0F;
  float s3 = 0.0F;
  float s4 = 0.0F;
  float y1 = 0.0F;
  float y2 = 0.0F;
  float yy = 0.0F;
  for (const PhasePoint& point : points) {
    const float u = (point.time - mean_t) * scale;
    const float p = point.turns - mean_p;
    s2 += u * u;
    s3 += u * u * u;
    s4 += u * u * u * u;
    y1 += u * p;
    y2 += u * u * p;
    yy += p * p;
  }
  const float mean_u2 = s2 / count;
  const float q11 = s2;
  const float q12 = s3;
  // phi = a + b u + c q, c = r extent^2 / 2, so the expectation adds (2 noise / (extent^2 rate))^2 to the
  // curvature's weight.
  const float prior = 2.0F * noise * scale * scale / expected_rate;
  const float q22 = s4 - count * mean_u2 * mean_u2 + prior * prior;
  const float determinant = q11 * q22 - q12 * q12;
  PhaseFit fit;
  if (!(determinant > 0.0F)) {
    fit.turns = mean_p;
    return fit;
  }
  const float b = (y1 * q22 - y2 * q12) / determinant;
  const float c = (y2 * q11 - y1 * q12) / determinant;
  const float u0 = -mean_t * scale;
  fit.turns = mean_p + b * u0 + c * (u0 * u0 - mean_u2);
  fit.hertz = (b + 2.0F * c * u0) * scale;
  fit.rate = 2.0F * c * scale * scale;
  fit.rms = square_root((yy - b * y1 - c * y2) / count);
  return fit;
}

}  // namespace powbench::firmware
