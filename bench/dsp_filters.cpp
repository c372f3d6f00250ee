#include <cmath>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/dsp_filters_peer.h"
#include "bench/dsp_synth.h"
#include "core/units.h"
#include "dsp/filter/cascade.h"
#include "dsp/signal/spectrum.h"

/// Speed and rounding of the filters beside scipy in the same run. Prints one table; `--json PATH` writes it too.
/// Usage: bench_dsp_filters [--repeats N] [--plan quick|thorough] [--json PATH]

namespace {

using namespace powbench;
using namespace powbench::dsp;
using namespace powbench::bench;

constexpr std::size_t samples = std::size_t{1} << 20;

/// What scipy does, operation by operation, on one thread. The repeats are put in front.
constexpr const char* script = R"(
import time, numpy as np, scipy, scipy.signal as ss, scipy.fft as sf
def t(name, f):
    f(); v = []
    for _ in range(repeats):
        s = time.process_time(); f(); v.append(time.process_time() - s)
    print('time', name, sorted(v)[repeats // 2])
n = 1 << 20; fs = 1e6
x = np.random.default_rng(0).standard_normal(n)
x8 = np.random.default_rng(1).standard_normal((8, n // 8))
sos = ss.butter(4, [2000, 50000], 'bandpass', fs=fs, output='sos')
t('forward1', lambda: ss.sosfilt(sos, x))
t('forward8', lambda: ss.sosfilt(sos, x8, axis=-1))
t('zero1', lambda: ss.sosfiltfilt(sos, x))
t('zero8', lambda: ss.sosfiltfilt(sos, x8, axis=-1))
s = np.zeros(n); s[0] = 1
t('silence', lambda: ss.sosfilt(sos, s))
t('welch', lambda: ss.welch(x, fs, nperseg=4096))
t('coherence', lambda: ss.coherence(x, x[::-1].copy(), fs, nperseg=4096))
narrow = ss.butter(4, [50, 500], 'bandpass', fs=fs, output='sos')
for name, dc in (('dc0', 0.0), ('dc1e4', 1e4)):
    u = np.fromfile(path + name + '.in'); r = np.fromfile(path + name + '.ref')
    e = np.abs(ss.sosfilt(narrow, u) - r)[300000:].max() / np.abs(r[300000:]).max()
    print('error', name, e)
print('version', scipy.__version__)
)";

struct Arguments {
  int repeats = 9;
  FftEffort effort = FftEffort::thorough;
  std::string json;
};

Arguments parse(int argc, char** argv) {
  Arguments a;
  for (int i = 1; i < argc; ++i) {
    const std::string key = argv[i];
    if (i + 1 >= argc) throw std::invalid_argument(key + ": unknown, or its value is missing");
    const std::string value = argv[++i];
    if (key == "--repeats")
      a.repeats = std::stoi(value);
    else if (key == "--plan" && (value == "quick" || value == "thorough"))
      a.effort = value == "quick" ? FftEffort::quick : FftEffort::thorough;
    else if (key == "--json")
      a.json = value;
    else
      throw std::invalid_argument(key + " " + value +
                                  ": allowed --repeats N, --plan quick|thorough, --json PATH");
  }
  if (a.repeats < 1 || a.repeats > 99) throw std::invalid_argument("--repeats: allowed 1 .. 99");
  return a;
}

std::vector<double> noise(std::size_t n) {
  Random random(1);
  std::vector<double> x(n);
  for (double& v : x) v = random.normal();
  return x;
}

/// Butterworth 50 .. 500 Hz at 1 MS/s, 8 poles, in extended precision from the design on.
std::vector<double> extended_reference(const std::vector<double>& x) {
  using Long = long double;
  using C = std::complex<Long>;
  const Long p = std::acos(Long(-1)), w1 = std::tan(p * 50 / 1e6L), w2 = std::tan(p * 500 / 1e6L);
  const Long w0 = std::sqrt(w1 * w2);
  std::vector<double> y = x;
  std::vector<Long> v(x.begin(), x.end());
  for (int k = 0; k < 4; ++k) {
    const C h = std::polar(Long(1), p * static_cast<Long>(2 * k + 5) / 8) * ((w2 - w1) / 2);
    const C root = std::sqrt(h * h - w0 * w0);
    for (const C s : {h + root, h - root}) {
      if (s.imag() <= 0) continue;
      const C z = (Long(1) + s) / (Long(1) - s), e = std::polar(Long(1), -2 * std::atan(w0));
      const Long a1 = -2 * z.real(), a2 = std::norm(z);
      const Long g = 1 / std::abs((Long(1) - e * e) / (Long(1) + a1 * e + a2 * e * e));
      Long s1 = 0, s2 = 0;
      for (Long& in : v) {
        const Long out = g * in + s1;
        s1 = s2 - a1 * out;
        s2 = -g * in - a2 * out;
        in = out;
      }
    }
  }
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = static_cast<double>(v[i]);
  return y;
}

double error_after_start(const std::vector<double>& y, const std::vector<double>& reference) {
  double worst = 0, peak = 0;
  for (std::size_t i = 300'000; i < y.size(); ++i) {
    worst = std::max(worst, std::abs(y[i] - reference[i]));
    peak = std::max(peak, std::abs(reference[i]));
  }
  return worst / peak;
}

void write_binary(const std::string& path, const std::vector<double>& x) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(x.data()),
             static_cast<std::streamsize>(x.size() * sizeof(double)));
}

struct Row {
  std::string key, text;
  double megasamples = 0;  ///< of one call
  double must = 0, goal = 0;
};

const std::vector<Row>& rows() {
  constexpr double m = static_cast<double>(samples) / 1e6;
  static const std::vector<Row> table{{"forward1", "sections forward, 8 poles, 1 ch", m, 2, 5},
                                      {"forward8", "sections forward, 8 poles, 8 ch", m, 10, 14},
                                      {"zero1", "zero phase, 8 poles, 1 ch", m, 4, 6.5},
                                      {"zero8", "zero phase, 8 poles, 8 ch", m, 12, 19},
                                      {"silence", "sections forward, impulse and silence", m, 0, 0},
                                      {"welch", "Welch density, pieces of 4096", m, 4, 8},
                                      {"coherence", "coherence, pieces of 4096", m, 4, 8}};
  return table;
}

Peer ours(const Arguments& a) {
  Peer out;
  const Cascade c(FilterSpec{FilterKind::band, 4, 2e3, 50e3, 1e6});
  out.name = c.kernel().name;
  const auto x = noise(samples), x8 = noise(samples);
  auto y = x, y8 = x8;
  // in place on the same data again and again would fade; every call starts from a fresh copy, not timed
  const auto timed = [&](const char* key, const std::vector<double>& in, std::vector<double>& work,
                         auto call) {
    std::vector<double> t;
    for (int i = 0; i <= a.repeats; ++i) {
      std::copy(in.begin(), in.end(), work.begin());
      const double start = cpu_seconds();
      call();
      if (i) t.push_back(cpu_seconds() - start);
    }
    std::nth_element(t.begin(), t.begin() + a.repeats / 2, t.end());
    out.seconds[key] = t[static_cast<std::size_t>(a.repeats / 2)];
  };
  timed("forward1", x, y, [&] { c.forward(y); });
  timed("forward8", x8, y8, [&] { c.forward_frames(y8); });
  timed("zero1", x, y, [&] { c.zero_phase(y); });
  timed("zero8", x8, y8, [&] { c.zero_phase_frames(y8); });
  std::vector<double> impulse(samples, 0.0);
  impulse[0] = 1;
  timed("silence", impulse, y, [&] { c.forward(y); });
  SpectrumEstimator estimator(4096, 1e6, a.effort);
  out.seconds["welch"] = median_seconds(a.repeats, [&] { estimator.welch(x); });
  const std::span<const double> other(x8.data(), samples);
  out.seconds["coherence"] = median_seconds(a.repeats, [&] { estimator.coherence(x, other); });
  return out;
}

/// Rounding of 50 .. 500 Hz at 1 MS/s, 8 poles, ours and textbook; leaves the inputs for scipy at `path`.
void measure_rounding(Peer& own, Peer& textbook, const std::string& path) {
  const Cascade c(FilterSpec{FilterKind::band, 4, 50, 500, 1e6});
  const auto small = noise(1'000'000);
  for (const auto& [key, dc] : {std::pair("dc0", 0.0), std::pair("dc1e4", 1e4)}) {
    std::vector<double> x(small.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double t = static_cast<double>(i) * 1e-6;
      x[i] = dc + (t > 0.3 && t < 0.6 ? std::sin(2 * pi * 158.1 * t) : 0.0) + 1e-3 * small[i];
    }
    const auto reference = extended_reference(x);
    write_binary(path + key + ".in", x);
    write_binary(path + key + ".ref", reference);
    auto y = x;
    CascadeStream(c).push(y);
    own.error[key] = error_after_start(y, reference);
    textbook_sections(c.sections(), x, 1);
    textbook.error[key] = error_after_start(x, reference);
  }
}

nlohmann::json print(const Peer& own, const Peer& peer) {
  nlohmann::json out{{"kernel", own.name}, {"peer", peer.name}, {"speed", nlohmann::json::array()}};
  std::printf("filters (%s) beside %s in the same run: CPU time of one thread, median\n", own.name.c_str(),
              peer.name.c_str());
  std::printf("%-40s %10s %10s %7s %6s %6s\n", "", "MS/s", "peer MS/s", "ratio", "must", "goal");
  for (const Row& r : rows()) {
    const double mine = r.megasamples / own.seconds.at(r.key);
    const auto found = peer.seconds.find(r.key);
    const double theirs = found == peer.seconds.end() ? std::nan("") : r.megasamples / found->second;
    std::printf("%-40s %10.0f %10.0f %7.1f %6.3g %6.3g\n", r.text.c_str(), mine, theirs, mine / theirs,
                r.must, r.goal);
    out["speed"].push_back({{"operation", r.text},
                            {"megasamples_per_s", mine},
                            {"peer_megasamples_per_s", theirs},
                            {"ratio", mine / theirs},
                            {"must", r.must},
                            {"goal", r.goal}});
  }
  std::printf("\n");
  std::printf("%-40s %10s %10s %10s %8s %8s\n", "largest error / peak, 50-500 Hz, 1 MS/s", "ours", "peer",
              "textbook", "must", "goal");
  return out;
}

void print_errors(const Peer& own, const Peer& peer, const Peer& textbook, nlohmann::json& out) {
  struct Limit {
    const char *key, *text;
    double must, goal;
  };
  for (const Limit& l : {Limit{"dc0", "8 poles, no constant", 2e-11, 1e-12},
                         Limit{"dc1e4", "8 poles, constant 1e4 x the signal", 1e-10, 2e-11}}) {
    const auto found = peer.error.find(l.key);
    const double theirs = found == peer.error.end() ? std::nan("") : found->second;
    std::printf("%-40s %10.1e %10.1e %10.1e %8.0e %8.0e\n", l.text, own.error.at(l.key), theirs,
                textbook.error.at(l.key), l.must, l.goal);
    out["rounding"].push_back({{"case", l.text},
                               {"error", own.error.at(l.key)},
                               {"peer_error", theirs},
                               {"textbook_error", textbook.error.at(l.key)},
                               {"must", l.must},
                               {"goal", l.goal}});
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const Arguments a = parse(argc, argv);
  char folder[] = "/tmp/bench_dsp_filters.XXXXXX";
  if (!::mkdtemp(folder)) throw std::runtime_error("no temporary folder");
  const std::string path = std::string(folder) + "/";
  Peer own = ours(a), textbook;
  measure_rounding(own, textbook, path);
  Peer peer = scipy_peer("repeats = " + std::to_string(a.repeats) + "\npath = '" + path + "'\n" + script);
  std::filesystem::remove_all(folder);
  if (peer.name.empty()) peer = textbook_peer(to_sections({FilterKind::band, 4, 2e3, 50e3, 1e6}), a.repeats);
  nlohmann::json out = print(own, peer);
  print_errors(own, peer, textbook, out);
  if (!a.json.empty()) {
    std::ofstream file(a.json);
    file << out.dump(1) << '\n';
    if (!file) throw std::invalid_argument("--json " + a.json + ": cannot be written");
  }
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 2;
}
