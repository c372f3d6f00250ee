#include "firmware/math.h"

namespace powbench::firmware {

namespace {

/// arctan(t) / (2 pi) for 0 <= t <= 1: beyond tan(pi/8), arctan t = pi/4 + arctan((t - 1)/(t + 1)); then an
/// odd polynomial.
float arctan_turns(float t) {
  float offset = 0.0F;
  if (t > 0.41421356F) {
    t = (t - 1.0F) / (t + 1.0F);
    offset = 0.125F;
  }
  const float z = t * t;
  const float tail =
      (((8.05374449538e-2F * z - 1.38776856032e-1F) * z + 1.99777106478e-1F) * z - 3.33329491539e-1F) * z;
  return offset + (tail * t + t) * 0.159154943F;
}

}  // namespace

float wrap_turns(float x) {
  const auto whole = static_cast<float>(static_cast<std::int32_t>(x));
  const float rest = x - whole;
  if (rest >= 0.0F) return rest;
  const float up = rest + 1.0F;
  return up < 1.0F ? up : 0.0F;  // a tiny negative rest rounds up to 1
}

float wrap_half(float x) {
  const float turns = wrap_turns(x);
  return turns < 0.5F ? turns : turns - 1.0F;
}

float sin_turns(float x) {
  float t = wrap_half(x);
  if (t > 0.25F) t = 0.5F - t;
  if (t < -0.25F) t = -0.5F - t;
  const float a = t * 6.28318531F;
  const float z = a * a;
  const float tail =
      ((((-2.50521084e-8F * z + 2.75573192e-6F) * z - 1.98412698e-4F) * z + 8.33333333e-3F) * z -
       1.66666667e-1F) *
      z;
  return tail * a + a;
}

float cos_turns(float x) {
  return sin_turns(wrap_half(x) + 0.25F);
}

float atan2_turns(float y, float x) {
  const float ax = x < 0.0F ? -x : x;
  const float ay = y < 0.0F ? -y : y;
  if (ax == 0.0F && ay == 0.0F) return 0.0F;
  float angle = ay <= ax ? arctan_turns(ay / ax) : 0.25F - arctan_turns(ax / ay);
  if (x < 0.0F) angle = 0.5F - angle;
  return y < 0.0F ? -angle : angle;
}

float square_root(float x) {
  return x > 0.0F ? __builtin_sqrtf(x) : 0.0F;  // the root of IEEE 754, one instruction on every target
}

}  // namespace powbench::firmware
