#include "bench/dsp_filters_peer.h"

#include <cmath>
#include <complex>
#include <cstdio>
#include <ctime>
#include <sstream>

#include "core/units.h"

namespace powbench::bench {

namespace {

using Complex = std::complex<double>;

std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return text;
  char buffer[4096];
  while (std::fgets(buffer, sizeof buffer, pipe)) text += buffer;
  return ::pclose(pipe) == 0 ? text : std::string();
}

/// Recursive radix-2 transform, as in every textbook.
void fft(std::vector<Complex>& x) {
  const std::size_t n = x.size();
  if (n == 1) return;
  std::vector<Complex> even(n / 2), odd(n / 2);
  for (std::size_t i = 0; i < n / 2; ++i) even[i] = x[2 * i], odd[i] = x[2 * i + 1];
  fft(even);
  fft(odd);
  for (std::size_t k = 0; k < n / 2; ++k) {
    const Complex t = std::polar(1.0, -2 * pi * static_cast<double>(k) / static_cast<double>(n)) * odd[k];
    x[k] = even[k] + t;
    x[k + n / 2] = even[k] - t;
  }
}

}  // namespace

double cpu_seconds() {
  timespec t{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

Peer scipy_peer(const std::string& script) {
  Peer peer;
  const std::string command =
      "OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 /usr/bin/python3 - 2>/dev/null <<'END_OF_SCRIPT'\n" + script +
      "\nEND_OF_SCRIPT\n";
  std::istringstream lines(output_of(command));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind, key;
    double value = 0;
    if (!(words >> kind >> key)) continue;
    if (kind == "version") peer.name = "scipy " + key;
    if (kind == "time" && words >> value) peer.seconds[key] = value;
    if (kind == "error" && words >> value) peer.error[key] = value;
  }
  return peer;
}

void textbook_sections(std::span<const dsp::Section> sections, std::span<double> x, std::size_t stride) {
  struct Biquad {
    double b0, b1, b2, a1, a2, s1 = 0, s2 = 0;
  };
  std::vector<Biquad> all;
  for (const dsp::Section& q : sections) all.push_back({q.b0, q.b1(), q.b2(), q.a1(), q.a2()});
  for (std::size_t i = 0; i < x.size(); i += stride) {
    double v = x[i];
    for (Biquad& q : all) {
      const double y = q.b0 * v + q.s1;
      q.s1 = q.b1 * v - q.a1 * y + q.s2;
      q.s2 = q.b2 * v - q.a2 * y;
      v = y;
    }
    x[i] = v;
  }
}

Peer textbook_peer(std::span<const dsp::Section> sections, int repeats) {
  Peer peer;
  peer.name = "textbook C++";
  std::vector<double> x(std::size_t{1} << 20, 0.5);
  const auto forward = [&](std::size_t channels) {
    for (std::size_t w = 0; w < channels; ++w) textbook_sections(sections, std::span(x).subspan(w), channels);
  };
  const auto zero = [&](std::size_t channels) {
    forward(channels);
    std::reverse(x.begin(), x.end());
    forward(channels);
    std::reverse(x.begin(), x.end());
  };
  peer.seconds["forward1"] = median_seconds(repeats, [&] { forward(1); });
  peer.seconds["forward8"] = median_seconds(repeats, [&] { forward(8); });
  peer.seconds["zero1"] = median_seconds(repeats, [&] { zero(1); });
  peer.seconds["zero8"] = median_seconds(repeats, [&] { zero(8); });
  std::vector<Complex> piece(4096);
  const double one = median_seconds(repeats, [&] { fft(piece); });
  peer.seconds["welch"] = one * (1 << 20) / 2048;
  peer.seconds["coherence"] = 2 * one * (1 << 20) / 2048;
  return peer;
}

}  // namespace powbench::bench
