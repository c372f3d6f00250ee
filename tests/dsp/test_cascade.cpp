#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <random>

#include "core/units.h"
#include "dsp/filter/cascade.h"
#include "dsp/filter/sos.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

using Long = long double;

std::vector<double> noise(std::size_t n, unsigned seed) {
  std::mt19937_64 bits(seed);
  std::vector<double> x(n);
  for (double& v : x) v = static_cast<double>(bits() >> 11) * 0x1p-53 - 0.5;
  return x;
}

double largest(std::span<const double> x) {
  double m = 0;
  for (const double v : x) m = std::max(m, std::abs(v));
  return m;
}

double difference(std::span<const double> a, std::span<const double> b) {
  double m = 0;
  for (std::size_t i = 0; i < a.size(); ++i) m = std::max(m, std::abs(a[i] - b[i]));
  return m;
}

std::vector<const SosKernel*> kernels() {
  std::vector<const SosKernel*> all{&portable_sos_kernel()};
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) all.push_back(&avx2_sos_kernel());
  if (__builtin_cpu_supports("avx512f")) all.push_back(&avx512_sos_kernel());
#endif
  return all;
}

/// A Butterworth band-pass designed and run on its own in extended precision, transposed direct form II.
std::vector<double> extended_band(int order, Long f1, Long f2, Long rate, const std::vector<double>& x) {
  using C = std::complex<Long>;
  const Long p = std::acos(Long(-1)), w1 = std::tan(p * f1 / rate), w2 = std::tan(p * f2 / rate),
             w0 = std::sqrt(w1 * w2);
  struct Biquad {
    Long g, a1, a2, s1 = 0, s2 = 0;
  };
  std::vector<Biquad> sections;
  const Long at = 2 * std::atan(w0);
  for (int k = 0; k < order; ++k) {
    const C h = std::polar(Long(1), p * static_cast<Long>(2 * k + order + 1) / static_cast<Long>(2 * order)) *
                ((w2 - w1) / 2);
    const C root = std::sqrt(h * h - w0 * w0);
    for (const C s : {h + root, h - root}) {
      if (s.imag() <= 0) continue;
      const C z = (Long(1) + s) / (Long(1) - s), e = std::polar(Long(1), -at);
      Biquad q{1, -2 * z.real(), std::norm(z)};
      q.g = 1 / std::abs((Long(1) - e * e) / (Long(1) + q.a1 * e + q.a2 * e * e));
      sections.push_back(q);
    }
  }
  std::vector<double> y(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    Long v = x[i];
    for (Biquad& q : sections) {
      const Long o = q.g * v + q.s1;
      q.s1 = q.s2 - q.a1 * o;
      q.s2 = -q.g * v - q.a2 * o;
      v = o;
    }
    y[i] = static_cast<double>(v);
  }
  return y;
}

/// Largest error after the switch-on transient, over the peak.
double rounding(int order, double f1, double f2, double dc, const SosKernel& kernel) {
  std::vector<double> x = noise(1'000'000, 1);
  const double f0 = std::sqrt(f1 * f2);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = static_cast<double>(i) * 1e-6;
    x[i] = dc + (t > 0.3 && t < 0.6 ? std::sin(2 * pi * f0 * t) : 0.0) + 1e-3 * x[i];
  }
  const auto reference = extended_band(order, f1, f2, 1e6, x);
  const SosProgram program(to_sections({FilterKind::band, order, f1, f2, 1e6}));
  auto state = program.rest();
  kernel.run_one(program.loop(), state.data(), x.data(), 1, x.size());
  const auto from = static_cast<std::ptrdiff_t>(x.size() * 3 / 10);
  const std::span<const double> a(x.begin() + from, x.end()), b(reference.begin() + from, reference.end());
  return difference(a, b) / largest(b);
}

}  // namespace

TEST_CASE("rounding against extended precision: narrow bands at 1 MS/s, with and without a DC of 1e4") {
  for (const SosKernel* kernel : kernels()) {
    CAPTURE(kernel->name);
    CHECK(rounding(4, 50, 500, 0, *kernel) < 1e-12);
    CHECK(rounding(4, 50, 500, 1e4, *kernel) < 2e-11);
    CHECK(rounding(8, 50, 500, 0, *kernel) < 1e-11);
    CHECK(rounding(4, 500, 5000, 0, *kernel) < 1e-12);
    CHECK(rounding(4, 5e3, 50e3, 0, *kernel) < 1e-12);
    CHECK(rounding(8, 5e3, 50e3, 1e4, *kernel) < 1e-9);
  }
}

TEST_CASE("every instruction set gives the portable result to rounding, in one lane, in eight, in pieces") {
  for (const int order : {1, 2, 3, 4, 5, 6, 8}) {
    const auto sections = to_sections({FilterKind::band, order, 5e3, 80e3, 1e6});
    const Cascade portable(sections, portable_sos_kernel());
    const auto x = noise(8 * 5003, 7);
    auto y = x, frames = x;
    portable.forward(y);
    portable.forward_frames(frames);
    for (const SosKernel* kernel : kernels()) {
      CAPTURE(order, kernel->name);
      const Cascade c(sections, *kernel);
      auto z = x;
      c.forward(z);
      CHECK(difference(y, z) < 2e-12 * largest(y));
      z = x;
      c.forward_frames(z);
      CHECK(difference(frames, z) < 2e-12 * largest(frames));
    }
  }
}

TEST_CASE("fused versions give the same bits") {
  const auto all = kernels();
  if (all.size() < 3) return;
  const auto sections = to_sections({FilterKind::low, 7, 0, 20e3, 1e6});
  auto a = noise(8 * 4000, 3), b = a;
  Cascade(sections, *all[1]).forward_frames(a);
  Cascade(sections, *all[2]).forward_frames(b);
  CHECK(a == b);
}

TEST_CASE("pieces side by side are the serial result") {
  const FilterSpec spec{FilterKind::band, 4, 2e3, 50e3, 1e6};
  const Cascade c(spec);
  REQUIRE(c.warm_up() > c.memory());
  for (const std::size_t n : {8 * c.warm_up(), 8 * c.warm_up() + 7, 8 * c.warm_up() + 64,
                              8 * c.warm_up() + 77, 20 * c.warm_up() + 1}) {
    auto x = noise(n, 5);
    for (double& v : x) v += 100;
    auto serial = x, back = x;
    filter_forward(c.sections(), serial);
    auto pieces = x;
    c.forward(pieces);
    CHECK(difference(serial, pieces) < 1e-13 * largest(serial));
    // zero phase: the same with time reversed
    auto forward = x;
    c.zero_phase(forward);
    std::reverse(back.begin(), back.end());
    c.zero_phase(back);
    std::reverse(back.begin(), back.end());
    const std::size_t m = c.warm_up();
    const std::span<const double> inside(forward.begin() + static_cast<std::ptrdiff_t>(m),
                                         forward.end() - static_cast<std::ptrdiff_t>(m));
    const std::span<const double> mirrored(back.begin() + static_cast<std::ptrdiff_t>(m),
                                           back.end() - static_cast<std::ptrdiff_t>(m));
    CHECK(difference(inside, mirrored) < 1e-12);
  }
}

TEST_CASE("eight interleaved channels are eight channels") {
  const Cascade c(FilterSpec{FilterKind::low, 5, 0, 9e3, 100e3, true, FilterFamily::elliptic, 0.1, 60});
  const std::size_t frames = 3001;
  const auto x = noise(8 * frames, 11);
  auto together = x, both = x;
  c.forward_frames(together);
  c.zero_phase_frames(both);
  for (std::size_t w = 0; w < 8; ++w) {
    std::vector<double> one(frames);
    for (std::size_t i = 0; i < frames; ++i) one[i] = x[8 * i + w];
    auto two = one;
    filter_forward(c.sections(), one);
    c.zero_phase(two);
    double worst = 0;
    for (std::size_t i = 0; i < frames; ++i)
      worst = std::max({worst, std::abs(one[i] - together[8 * i + w]), std::abs(two[i] - both[8 * i + w])});
    CHECK(worst < 1e-13);
  }
  std::vector<double> odd(13);
  CHECK_THROWS_AS(c.forward_frames(odd), std::invalid_argument);
}

TEST_CASE("a stream in blocks of any size is the whole record") {
  const Cascade c(FilterSpec{FilterKind::band, 4, 200, 8000, 1e6});
  auto whole = noise(300'000, 2);
  auto blocks = whole;
  const auto x = whole;
  filter_forward(c.sections(), whole);
  CascadeStream stream(c);
  std::mt19937 bits(4);
  for (std::size_t i = 0; i < blocks.size();) {
    const std::size_t n = std::min<std::size_t>(1 + bits() % 7000, blocks.size() - i);
    stream.push(std::span(blocks).subspan(i, n));
    i += n;
  }
  CHECK(blocks == whole);
  CHECK(stream.position() == 300'000);

  auto expected = x;
  c.zero_phase(expected);
  ZeroPhaseStream zero(c, 50'000);
  std::vector<double> out;
  for (std::size_t i = 0; i < x.size();) {
    const std::size_t n = std::min<std::size_t>(1 + bits() % 90'000, x.size() - i);
    zero.push(std::span(x).subspan(i, n), out);
    i += n;
  }
  zero.finish(out);
  REQUIRE(out.size() == x.size());
  CHECK(zero.finished() == 300'000);
  CHECK(difference(out, expected) < 1e-12 * largest(expected));
}

TEST_CASE("records too short for the filter, one sample, and values that are not finite") {
  const Cascade c(FilterSpec{FilterKind::band, 4, 200, 8000, 1e6});
  std::vector<double> brief(c.memory() - 1, 1.0), one{3.0}, none, exact(c.memory(), 1.0);
  CHECK_THROWS_AS(c.zero_phase(brief), FilterMemoryError);
  CHECK_THROWS_AS(c.zero_phase(one), FilterMemoryError);
  CHECK_THROWS_AS(c.zero_phase(none), FilterMemoryError);
  CHECK_NOTHROW(c.zero_phase(exact));
  CHECK_NOTHROW(c.forward(none));
  c.forward(one);
  CHECK(one[0] == Approx(3.0 * [&] {
          double g = 1;
          for (const Section& q : c.sections()) g *= q.b0;
          return g;
        }()));
  ZeroPhaseStream stream(c);
  std::vector<double> out;
  stream.push(brief, out);
  CHECK_THROWS_AS(stream.finish(out), FilterMemoryError);
  for (const std::size_t n : {std::size_t{5000}, 9 * c.warm_up()}) {
    auto x = noise(n, 1);
    x[n / 3] = std::nan("");
    CHECK_THROWS_AS(c.forward(x), std::invalid_argument);
  }
  Signal s;
  s.dt = 1e-6;
  s.value = noise(100'000, 9);
  s.masked.assign(s.value.size(), mask_none);
  s.value[50'000] = std::nan("");
  s.value[50'001] = INFINITY;
  const auto y = filter_zero_phase(c.sections(), s).signal;
  CHECK(std::isfinite(largest(y.value)));
  CHECK(y.masked[50'000] == mask_gap);
  CHECK(y.masked[50'001] == mask_gap);
  CHECK_THROWS_AS(Cascade(std::vector<Section>{}), std::invalid_argument);
}

TEST_CASE("silence after an impulse becomes exact zeros in all forms") {
  const Cascade c(FilterSpec{FilterKind::band, 4, 10e3, 50e3, 1e6});
  std::vector<double> x(1 << 18, 0.0), f(1 << 20, 0.0);
  x[0] = 1;
  for (std::size_t w = 0; w < 8; ++w) f[w] = 1;
  c.forward(x);
  c.forward_frames(f);
  const auto subnormal = [](double v) { return v != 0 && std::abs(v) < 2.3e-308; };
  CHECK(x.back() == 0.0);
  CHECK(f.back() == 0.0);
  CHECK(std::count_if(x.begin(), x.end(), subnormal) == 0);
  CHECK(std::count_if(f.begin(), f.end(), subnormal) == 0);
}

TEST_CASE("a hundred million samples stream through with the memory of one block and no growing error",
          "[.slow]") {
  const Cascade c(FilterSpec{FilterKind::band, 4, 200, 8000, 1e6});
  // 1 kHz: a period of 1000 samples, so the exact answer is a table times |H|^2
  std::vector<double> period(1000);
  for (std::size_t i = 0; i < 1000; ++i) period[i] = std::sin(2 * pi * static_cast<double>(i) / 1000);
  const double gain = std::norm(response(c.sections(), 1000, 1e6));
  ZeroPhaseStream stream(c);
  std::vector<double> block(1'000'000), out;
  for (std::size_t i = 0; i < block.size(); ++i) block[i] = period[i % 1000];
  const auto edge = static_cast<std::int64_t>(2 * c.warm_up());
  std::int64_t done = 0;
  double early = 0, late = 0;
  std::size_t most = 0, most_early = 0;
  const auto judge = [&] {
    for (std::size_t i = 0; i < out.size(); ++i) {
      const std::int64_t n = done + static_cast<std::int64_t>(i);
      if (n < edge || n >= 100'000'000 - edge) continue;
      double& worst = n < 10'000'000 ? early : late;
      worst = std::max(worst, std::abs(out[i] - gain * period[static_cast<std::size_t>(n % 1000)]));
    }
    done += static_cast<std::int64_t>(out.size());
    most = std::max(most, stream.held_samples() + out.capacity());
    out.clear();
  };
  for (int k = 0; k < 100; ++k) {
    stream.push(block, out);
    judge();
    if (k == 9) most_early = most;
  }
  stream.finish(out);
  judge();
  CHECK(done == 100'000'000);
  CHECK(early < 1e-12);
  CHECK(late < 1e-12);
  CHECK(most < 5'000'000);
  CHECK(most == most_early);  // ten times the record, the same memory
}
