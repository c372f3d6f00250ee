#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <complex>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "bench/phase_calibration.h"
#include "bench/phase_peers.h"
#include "core/units.h"
#include "host/import/comtrade.h"
#include "host/import/wav.h"

/// The phase tracker on recordings of mains that nobody here made, beside a SOGI-PLL and a zero-crossing controller:
/// WAV (16 bit, first channel), COMTRADE (first voltage) and lines of single cycles (CSV), in a folder.
/// Usage: bench_real_mains FOLDER
///
/// Each recording is brought to 100 kS/s by band-limited interpolation (a Kaiser-windowed sinc over 64 of its
/// samples; images below -80 dB), scaled to the nominal amplitude and rounded to 12 bits. The reference is the phase
/// of a centred Blackman window over four cycles of the recording itself; how far that over eight cycles differs is
/// the reference's own ambiguity.

namespace {

using namespace powbench;
using namespace powbench::bench;
namespace fs = std::filesystem;

constexpr double settles = 1.0;  ///< s: nothing is judged before

struct Recording {
  std::string name;
  double rate = 0.0, hertz = 50.0;
  std::vector<double> value{};
};

double bessel_i0(double x) {
  double sum = 1.0, term = 1.0;
  for (int k = 1; k < 40; ++k) sum += term *= (0.5 * x / k) * (0.5 * x / k);
  return sum;
}

/// Weights of 64 samples for a place between the two in the middle, in steps of 1/1000.
class Interpolator {
 public:
  static constexpr int half = 32, steps = 1000;

  Interpolator() : weights_(static_cast<std::size_t>(steps + 1) * 2 * half) {
    constexpr double beta = 8.0;
    for (int s = 0; s <= steps; ++s) {
      double sum = 0.0;
      for (int k = 0; k < 2 * half; ++k) {
        const double x = k - (half - 1) - static_cast<double>(s) / steps;
        const double r = x / half,
                     window = std::abs(r) < 1.0 ? bessel_i0(beta * std::sqrt(1.0 - r * r)) : 0.0;
        const double sinc = std::abs(x) < 1e-12 ? 1.0 : std::sin(pi * x) / (pi * x);
        sum += at(s, k) = sinc * window;
      }
      for (int k = 0; k < 2 * half; ++k) at(s, k) /= sum;
    }
  }
  double value(const std::vector<double>& y, double place) const {
    const auto whole = static_cast<std::int64_t>(place);
    const double fine = (place - static_cast<double>(whole)) * steps;
    const int s = std::min(static_cast<int>(fine), steps - 1);
    const double part = fine - s;
    double a = 0.0, b = 0.0;
    for (int k = 0; k < 2 * half; ++k) {
      const double v = y[static_cast<std::size_t>(whole - (half - 1) + k)];
      a += weights_[static_cast<std::size_t>(s * 2 * half + k)] * v;
      b += weights_[static_cast<std::size_t>((s + 1) * 2 * half + k)] * v;
    }
    return a + part * (b - a);
  }

 private:
  double& at(int s, int k) { return weights_[static_cast<std::size_t>(s * 2 * half + k)]; }
  std::vector<double> weights_;
};

/// Turns of the deviation from `hertz` t, unwrapped, at every sample; NaN where the window does not fit.
std::vector<double> reference(const Recording& r, double cycles) {
  const auto reach = static_cast<std::int64_t>(0.5 * cycles * r.rate / r.hertz);
  std::vector<double> turns(r.value.size(), std::nan(""));
  double before = 0.0;
  bool first = true;
  for (std::int64_t n = reach; n + reach < static_cast<std::int64_t>(r.value.size()); ++n) {
    std::complex<double> sum = 0.0;
    for (std::int64_t i = -reach; i <= reach; ++i) {
      const double x = pi * static_cast<double>(i) / (static_cast<double>(reach) + 1.0);
      const double w = 0.42 + 0.5 * std::cos(x) + 0.08 * std::cos(2 * x);
      const double t = static_cast<double>(n + i) / r.rate;
      sum += w * r.value[static_cast<std::size_t>(n + i)] *
             std::polar(1.0, -2 * pi * std::fmod(r.hertz * t, 1.0));
    }
    double now = std::arg(sum) / (2 * pi) + 0.25;  // the sine's phase
    if (!first) now += std::round(before - now);
    turns[static_cast<std::size_t>(n)] = before = now;
    first = false;
  }
  return turns;
}

struct Score {
  ErrorSum now[3], ahead[3];
  Calibration u_now, u_ahead;
  std::int64_t judged = 0, valid = 0, beyond = 0;
};

double signed_degrees(double a, double b) {
  const double turns = a - b;
  return (turns - std::floor(turns + 0.5)) * 360.0;
}

/// Truth: turns as a function of the time; NaN where it is not known.
template <class Input, class Truth>
Score judge(double seconds, const Input& input, const Truth& truth) {
  OurTracker ours;
  SogiPeer sogi;
  ZeroCrossPeer crossing;
  Score score;
  for (std::int64_t n = 0; n < static_cast<std::int64_t>(seconds * mains_rate); ++n) {
    const double t = static_cast<double>(n) / mains_rate;
    const double steps = std::round(input(t) * mains_counts / 16.0);
    const auto counts = static_cast<std::int16_t>(std::clamp(steps, -2048.0, 2047.0) * 16.0);
    ours.push(counts);
    sogi.push(counts);
    crossing.push(counts);
    if ((n + 1) % samples_per_say != 0 || t < settles) continue;
    const double there = truth(t), later = truth(t + look_ahead);
    if (std::isnan(there) || std::isnan(later)) continue;
    const PhaseSay says[3] = {ours.say(), sogi.say(), crossing.say()};
    const auto& estimate = ours.tracker.estimate();
    ++score.judged;
    const auto predicted = [&](const PhaseSay& s) {
      return s.turns + s.hertz * look_ahead + 0.5 * s.rate * look_ahead * look_ahead;
    };
    for (int i = 1; i < 3; ++i) {
      score.now[i].add(signed_degrees(says[i].turns, there));
      score.ahead[i].add(signed_degrees(predicted(says[i]), later));
    }
    if (!estimate.valid()) continue;
    ++score.valid;
    const double now = signed_degrees(says[0].turns, there),
                 ahead = signed_degrees(predicted(says[0]), later);
    score.now[0].add(now);
    score.ahead[0].add(ahead);
    score.beyond += std::abs(ahead) > stated_tolerance ? 1 : 0;
    score.u_now.add(now, 360.0 * static_cast<double>(estimate.deviation(0.0F)));
    score.u_ahead.add(ahead, 360.0 * static_cast<double>(estimate.deviation(static_cast<float>(look_ahead))));
  }
  return score;
}

void print(const std::string& name, double seconds, const Score& s, double ambiguity) {
  fmt::print(
      "{:<26} {:>5.0f} | {:>6.3f} {:>6.3f} {:>6.2f} | {:>6.3f} {:>6.3f} {:>6.2f} | {:>6.3f} {:>6.3f} | "
      "{:>5.1f} "
      "{:>6} | {:>5.2f} {:>5.1f} | {:>6.3f}\n",
      name, seconds, s.now[0].rms(), s.ahead[0].rms(), s.ahead[0].worst, s.now[1].rms(), s.ahead[1].rms(),
      s.ahead[1].worst, s.now[2].rms(), s.ahead[2].rms(),
      100.0 * static_cast<double>(s.valid) / static_cast<double>(std::max<std::int64_t>(s.judged, 1)),
      s.beyond, s.u_ahead.deviation(), 100.0 * s.u_ahead.coverage(), ambiguity);
}

void run(const Recording& r) {
  const std::vector<double> four = reference(r, 4.0), eight = reference(r, 8.0);
  double square = 0.0;
  std::int64_t both = 0;
  for (std::size_t i = 0; i < four.size(); ++i) {
    if (std::isnan(four[i]) || std::isnan(eight[i])) continue;
    const double d = signed_degrees(four[i], eight[i]);
    square += d * d;
    ++both;
  }
  double peak = 0.0;
  for (const double v : r.value) peak += v * v;
  peak = std::sqrt(2.0 * peak / static_cast<double>(r.value.size()));
  const Interpolator between;
  // the interpolation needs samples on either side: time 0 is behind the first of them
  const double first = Interpolator::half;
  const double seconds = (static_cast<double>(r.value.size()) - 2.0 * first - 2.0) / r.rate;
  const auto truth = [&](double t) {
    const double place = first + t * r.rate;
    const auto k = static_cast<std::size_t>(place);
    if (k + 1 >= four.size()) return std::nan("");
    const double deviation = four[k] + (place - static_cast<double>(k)) * (four[k + 1] - four[k]);
    return deviation + std::fmod(r.hertz * place / r.rate, 1.0);
  };
  const Score score = judge(
      seconds, [&](double t) { return between.value(r.value, first + t * r.rate) / peak; }, truth);
  print(r.name, seconds, score, std::sqrt(square / static_cast<double>(std::max<std::int64_t>(both, 1))));
}

std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Recording read_wav(const fs::path& path) {
  const host::CsvTable table = host::parse_wav(bytes_of(path), path.string());
  Recording r{.name = path.filename().string(), .value = table.columns[1]};
  const std::vector<double>& time = table.columns[0];
  r.rate = static_cast<double>(time.size() - 1) / (time.back() - time.front());
  for (double& v : r.value) v *= 32768;
  return r;
}

Recording read_relay(const fs::path& path) {
  const host::Comtrade c = host::read_comtrade(path);
  Recording r{.name = path.stem().string(), .hertz = c.line_hertz};
  for (const auto& channel : c.channels) {
    if (channel.unit != "V" && channel.unit != "kV") continue;
    r.value = channel.value;
    break;
  }
  r.rate = static_cast<double>(c.time.size() - 1) / (c.time.back() - c.time.front());
  return r;
}

/// Each line a cycle, repeated for three seconds by its own Fourier series: its phase is exact.
void run_cycles(const fs::path& path, double hertz) {
  std::ifstream in(path);
  double best_now = 1e9, worst_now = 0.0, worst_ahead = 0.0, best_peer = 1e9, worst_peer = 0.0;
  std::int64_t judged = 0, valid = 0;
  int cycles = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#')) continue;
    std::vector<double> y;
    for (const char *at = line.data(), *end = at + line.size(); at < end;) {
      double v = 0;
      const auto [rest, error] = std::from_chars(at, end, v);
      if (error != std::errc()) break;
      y.push_back(v);
      at = rest < end ? rest + 1 : end;
    }
    if (y.size() < 16) continue;
    constexpr int points = 5000;  // of three cycles of 60 Hz at 100 kS/s
    const int orders = static_cast<int>(y.size()) / 2 - 1;
    std::vector<double> wave(points, 0.0);
    std::complex<double> fundamental;
    for (int k = 0; k <= orders; ++k) {
      std::complex<double> z = 0.0;
      for (std::size_t i = 0; i < y.size(); ++i)
        z += y[i] * std::polar(1.0, -2 * pi *
                                        std::fmod(static_cast<double>(k) * static_cast<double>(i) /
                                                      static_cast<double>(y.size()),
                                                  1.0));
      z *= (k == 0 ? 1.0 : 2.0) / static_cast<double>(y.size());
      if (k == 1) fundamental = z;
      const std::complex<double> step = std::polar(1.0, 2 * pi * 3.0 * k / points);
      std::complex<double> turn = z;
      for (double& w : wave) {
        w += turn.real();
        turn *= step;
      }
    }
    const double peak = std::abs(fundamental), start = std::arg(fundamental) / (2 * pi) + 0.25;
    const double rate_per_point = 3.0 / points;
    const Score s = judge(
        3.0,
        [&](double t) {
          return wave[static_cast<std::size_t>(std::llround(t * hertz / rate_per_point)) % points] / peak;
        },
        [&](double t) { return start + std::fmod(hertz * t, 1.0); });
    ++cycles;
    judged += s.judged;
    valid += s.valid;
    best_now = std::min(best_now, s.now[0].worst);
    worst_now = std::max(worst_now, s.now[0].worst);
    worst_ahead = std::max(worst_ahead, s.ahead[0].worst);
    best_peer = std::min(best_peer, s.now[1].worst);
    worst_peer = std::max(worst_peer, s.now[1].worst);
  }
  fmt::print(
      "\n{}: {} cycles of {:.0f} Hz, each repeated for 3 s; largest error of each, best .. worst cycle\n"
      "tracker {:.3f} .. {:.3f} deg now, {:.3f} deg 20 ms ahead, valid {:.1f} %; SOGI-PLL {:.3f} .. {:.3f} "
      "deg now\n",
      path.filename().string(), cycles, hertz, best_now, worst_now, worst_ahead,
      100.0 * static_cast<double>(valid) / static_cast<double>(std::max<std::int64_t>(judged, 1)), best_peer,
      worst_peer);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || !fs::is_directory(argv[1])) {
    fmt::print(stderr,
               "usage: bench_real_mains FOLDER with .wav, .cfg and .dat, .csv of single 60 Hz cycles\n");
    return 2;
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(argv[1])) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  fmt::print(
      "Recorded mains; errors in deg: rms now, rms and worst 20 ms ahead. The tracker where it is valid, the "
      "others always\n"
      "error/u and within 1.96 u: 20 ms ahead; reference: rms difference of windows over four and eight "
      "cycles\n"
      "{:<26} {:>5} | {:^20} | {:^20} | {:^13} | {:>5} {:>6} | {:>5} {:>5} | {:>6}\n",
      "recording", "s", "tracker", "SOGI-PLL", "zero-cross", "valid", "> 1deg", "e/u", "in %", "refer.");
  for (const fs::path& file : files) {
    if (file.extension() == ".wav") run(read_wav(file));
    if (file.extension() == ".cfg") run(read_relay(file));
  }
  for (const fs::path& file : files)
    if (file.extension() == ".csv") run_cycles(file, 60.0);
  return 0;
}
