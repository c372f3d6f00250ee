#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>

#include "core/units.h"
#include "dsp/filter/filter_design.h"
#include "dsp/filter/sos.h"

using namespace powbench;
using namespace powbench::dsp;
using Complex = std::complex<double>;

namespace {

/// Reference numbers: scipy 1.10.1, signal.butter(..., output="zpk"); poles with positive imaginary part and real ones.
struct Oracle {
  FilterSpec spec;
  std::vector<Complex> poles;
  double gain;
};

const std::vector<Oracle> oracles{
    {{FilterKind::low, 4, 0, 10e3, 100e3},
     {{0.52429978818130585, 0.14577410495251691}, {0.66045671540971296, 0.44332349357493978}},
     0.0048243433577162308},
    {{FilterKind::high, 3, 800, 0, 100e3},
     {{0.9509567815010681, 0}, {0.97426140655539784, 0.042446508012410879}},
     0.95097188792340925},
    {{FilterKind::band, 4, 1e3, 10e3, 100e3},
     {{0.59758223137411937, 0.16821855782069522},
      {0.68841950432759791, 0.46198281704203392},
      {0.93553829876563488, 0.033836289956839523},
      {0.97785750891786971, 0.059484108802700317}},
     0.0033628151286823919},
    {{FilterKind::stop, 2, 2e3, 4e3, 100e3},
     {{0.92271646953378261, 0.20900023115707964}, {0.95848790179556864, 0.1288749280964207}},
     0.9149691441130825},
    {{FilterKind::band, 4, 50, 500, 1e6},
     {{0.99772040912762117, 0.0012626398879290433},
      {0.99901639391416253, 0.0029134479873386822},
      {0.99966921990313129, 0.00018344901685155818},
      {0.99989778580251687, 0.00030406829613219283}},
     3.9796632379203308e-12},
};

double nearest(const std::vector<Complex>& all, Complex p) {
  double d = 1e9;
  for (const Complex q : all) d = std::min(d, std::abs(p - q));
  return d;
}

Signal constant_rate(std::size_t n, double rate) {
  Signal s;
  s.dt = 1 / rate;
  s.value.resize(n);
  s.masked.assign(n, 0);
  return s;
}

}  // namespace

TEST_CASE("Butterworth poles and gain agree with the reference to 1e-12") {
  for (const Oracle& o : oracles) {
    const Zpk z = design_zpk(o.spec);
    std::size_t expected = 0;
    for (const Complex p : o.poles) {
      CHECK(nearest(z.poles, p) < 1e-12);
      CHECK(nearest(z.poles, std::conj(p)) < 1e-12);
      expected += p.imag() != 0 ? 2 : 1;
    }
    CHECK(z.poles.size() == expected);
    CHECK(std::abs(z.gain / o.gain - 1) <
          1e-9);  // the 50 .. 500 Hz gain is 4e-12: its own rounding in the reference
  }
}

TEST_CASE("cascade and zeros-poles-gain are the same filter") {
  for (const Oracle& o : oracles) {
    const Zpk z = design_zpk(o.spec);
    const auto sections = to_sections(o.spec);
    for (const double f : {0.001, 0.01, 0.03, 0.1, 0.3}) {
      const Complex at = std::polar(1.0, 2 * pi * f);
      Complex h = z.gain;
      for (std::size_t i = 0; i < z.poles.size(); ++i) h *= (at - z.zeros[i]) / (at - z.poles[i]);
      CHECK(std::abs(response(sections, f * o.spec.rate, o.spec.rate) - h) < 1e-11);
    }
  }
}

TEST_CASE("reference responses of the low-pass to 1e-12") {
  const auto s = to_sections(oracles[0].spec);
  CHECK(std::abs(response(s, 3e3, 100e3) - Complex(0.71815331656028447, -0.69584804275340106)) < 1e-12);
  CHECK(std::abs(response(s, 9e3, 100e3) - Complex(-0.7741602994406156, -0.3325783353906055)) < 1e-12);
  CHECK(std::abs(response(s, 17e3, 100e3) - Complex(0.0054698615383659173, 0.090572828605044453)) < 1e-12);
}

TEST_CASE("forward filtering gives the reference samples to 1e-12") {
  std::vector<double> x(64, 0.0);
  x[3] = 1;
  std::fill(x.begin() + 10, x.begin() + 20, 0.5);
  filter_forward(to_sections(oracles[2].spec), x);
  CHECK(std::abs(x[3] - 0.0033628151286823919) < 1e-12);
  CHECK(std::abs(x[4] - 0.021517964923130208) < 1e-12);
  CHECK(std::abs(x[7] - 0.15133151675094914) < 1e-12);
  CHECK(std::abs(x[11] - -0.051523460807993721) < 1e-12);
  CHECK(std::abs(x[20] - 0.114128685608265) < 1e-12);
  CHECK(std::abs(x[40] - 0.031300274119473857) < 1e-12);
  CHECK(std::abs(x[63] - 0.083401766045933606) < 1e-12);
}

TEST_CASE("zero-phase filtering agrees with the reference away from the edges to 1e-12") {
  Signal s = constant_rate(400, 100e3);
  for (std::size_t i = 0; i < 400; ++i) {
    const double n = static_cast<double>(i);
    s.value[i] = std::sin(2 * pi * 1234 * n / 1e5) + 0.3 * std::cos(2 * pi * 23456 * n / 1e5);
  }
  const auto y = filter_zero_phase(to_sections(oracles[0].spec), s);
  CHECK(std::abs(y.signal.value[200] - 0.1997789524754755) < 1e-12);
  CHECK(std::abs(y.signal.value[237] - -0.45640845085298481) < 1e-12);
  CHECK(std::abs(y.signal.value[150] - -0.80527519358036448) < 1e-12);
}

TEST_CASE("no section has a tiny gain, and each band-pass section has zeros at +1 and -1") {
  for (const FilterSpec spec :
       {FilterSpec{FilterKind::band, 8, 50, 60, 1e6}, FilterSpec{FilterKind::band, 8, 50, 500, 1e6}}) {
    const auto sections = to_sections(spec);
    CHECK(sections.size() == 8);
    for (const Section& q : sections) {
      CHECK(std::abs(q.b0) > 1e-6);
      CHECK(std::abs(q.b1()) < 1e-12 * q.b0);
      CHECK(q.b2() == Approx(-q.b0));
    }
    for (std::size_t k = 1; k < sections.size(); ++k) CHECK(sections[k].a2() <= sections[k - 1].a2() + 1e-12);
  }
}

TEST_CASE("a large DC level costs no more than rounding: below 1e-10 of the largest value") {
  // 50 .. 500 Hz at 1 MS/s, 8 poles, DC of 1e4 on a unit sine: the difference to the same sine without DC.
  const auto sections = to_sections({FilterKind::band, 4, 50, 500, 1e6});
  std::vector<double> with(400000), without(400000);
  for (std::size_t i = 0; i < with.size(); ++i) {
    without[i] = std::sin(2 * pi * 160 * static_cast<double>(i) * 1e-6);
    with[i] = without[i] + 1e4;
  }
  std::vector<double> step(with.size(), 1e4);
  filter_forward(sections, with);
  filter_forward(sections, without);
  filter_forward(sections, step);
  double worst = 0, peak = 0;
  for (std::size_t i = 0; i < with.size(); ++i) {
    worst = std::max(worst, std::abs(with[i] - without[i] - step[i]));
    peak = std::max(peak, std::abs(with[i]));
  }
  CHECK(worst < 1e-10 * peak);
  CHECK(std::abs(step.back()) < 1e-6);  // and the step itself has died out
}

TEST_CASE("two-pass correction puts -3 dB where it is asked for") {
  for (const FilterKind kind : {FilterKind::low, FilterKind::high, FilterKind::band, FilterKind::stop}) {
    const auto s = to_sections({kind, 4, 2e3, 9e3, 100e3, true});
    if (kind != FilterKind::high && kind != FilterKind::band && kind != FilterKind::stop)
      CHECK(std::norm(response(s, 9e3, 100e3)) == Approx(std::sqrt(0.5)).margin(1e-9));
    if (kind == FilterKind::high)
      CHECK(std::norm(response(s, 2e3, 100e3)) == Approx(std::sqrt(0.5)).margin(1e-9));
    if (kind == FilterKind::band || kind == FilterKind::stop) {
      CHECK(std::norm(response(s, 2e3, 100e3)) == Approx(std::sqrt(0.5)).margin(1e-9));
      CHECK(std::norm(response(s, 9e3, 100e3)) == Approx(std::sqrt(0.5)).margin(1e-9));
    }
  }
}

TEST_CASE("filter memory is the length of the impulse response") {
  const auto sections = to_sections({FilterKind::band, 4, 50, 500, 1e6});
  const std::size_t memory = filter_memory(sections, 1e-6);
  CHECK(memory > 120000);
  CHECK(memory < 150000);  // about 135 000 samples
  std::vector<double> h(200000, 0.0);
  h[0] = 1;
  filter_forward(sections, h);
  double peak = 0, tail = 0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    peak = std::max(peak, std::abs(h[i]));
    if (i >= memory) tail = std::max(tail, std::abs(h[i]));
  }
  CHECK(tail <= 1e-6 * peak);
}

TEST_CASE("the narrowest band reports its memory of millions of samples", "[.slow]") {
  const std::size_t memory = filter_memory(to_sections({FilterKind::band, 8, 50, 60, 1e6}), 1e-6);
  CHECK(memory > 2'000'000);
  CHECK(memory < 3'000'000);
}

TEST_CASE("zero-phase edges are masked and a record shorter than the memory is refused") {
  const auto sections = to_sections({FilterKind::low, 4, 0, 10e3, 100e3});
  Signal s = constant_rate(500, 100e3);
  const auto y = filter_zero_phase(sections, s);
  CHECK(y.memory > 5);
  CHECK(y.signal.masked.front() == mask_edge);
  CHECK(y.signal.masked[y.memory - 1] == mask_edge);
  CHECK(y.signal.masked[y.memory] == mask_none);
  CHECK(y.signal.masked.back() == mask_edge);
  CHECK_THROWS_AS(filter_zero_phase(sections, constant_rate(y.memory - 1, 100e3)), FilterMemoryError);
  CHECK_THROWS_AS(filter_zero_phase(sections, constant_rate(0, 100e3)), FilterMemoryError);
}

TEST_CASE("zero phase: a symmetric pulse stays symmetric, a constant stays") {
  const auto sections = to_sections({FilterKind::low, 4, 0, 5e3, 100e3, true});
  Signal s = constant_rate(1001, 100e3);
  s.value[500] = 1;
  const auto y = filter_zero_phase(sections, s).signal.value;
  for (std::size_t k = 1; k < 200; ++k) CHECK(std::abs(y[500 - k] - y[500 + k]) < 1e-12);
  std::fill(s.value.begin(), s.value.end(), 7.0);
  for (const double v : filter_zero_phase(sections, s).signal.value) CHECK(std::abs(v - 7.0) < 1e-11);
}

TEST_CASE("impossible filters are refused") {
  const double nan = std::nan("");
  CHECK_THROWS_AS(to_sections({FilterKind::band, 4, 500, 50, 1e6}), std::invalid_argument);
  CHECK_THROWS_AS(to_sections({FilterKind::band, 4, 50, 50, 1e6}), std::invalid_argument);
  CHECK_THROWS_AS(to_sections({FilterKind::low, 4, 0, 50e3, 100e3}), std::invalid_argument);
  CHECK_THROWS_AS(to_sections({FilterKind::low, 4, 0, nan, 100e3}), std::invalid_argument);
  CHECK_THROWS_AS(to_sections({FilterKind::high, 4, 0, 0, 100e3}), std::invalid_argument);
  CHECK_THROWS_AS(to_sections({FilterKind::low, 0, 0, 1e3, 100e3}), std::invalid_argument);
  CHECK_THROWS_AS(to_sections({FilterKind::low, 17, 0, 1e3, 100e3}), std::invalid_argument);
  CHECK_THROWS_AS(to_sections({FilterKind::low, 4, 0, 1e3, nan}), std::invalid_argument);
}

TEST_CASE("silence after an impulse ends in exact zeros, not in subnormal numbers") {
  std::vector<double> x(3'000'000, 0.0);
  x[0] = 1;
  filter_forward(to_sections({FilterKind::band, 4, 200, 8000, 1e6}), x);
  CHECK(x.back() == 0.0);
}
