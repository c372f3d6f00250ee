#pragma once

#include <algorithm>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "dsp/filter/filter_design.h"

/// What the filters are compared with: scipy, run as a child process, or else a textbook cascade and DFT in C++.

namespace powbench::bench {

struct Peer {
  std::string name;                       ///< "scipy 1.10.1" or "textbook C++"
  std::map<std::string, double> seconds;  ///< CPU time of one call, median, by the name of the operation
  std::map<std::string, double> error;  ///< largest error over the peak, where the operation has a reference
};

/// Runs the operations in /usr/bin/python3 with scipy, one thread. Empty name when there is none.
Peer scipy_peer(const std::string& script);

/// The same operations without vectors, blocks or FFTW.
Peer textbook_peer(std::span<const dsp::Section> sections, int repeats);

/// Transposed direct form II, one sample after the other through all sections, in place.
void textbook_sections(std::span<const dsp::Section> sections, std::span<double> x, std::size_t stride);

double cpu_seconds();

/// Median CPU time of `repeats` calls after one that does not count.
template <class Call>
double median_seconds(int repeats, Call call) {
  call();
  std::vector<double> t;
  for (int i = 0; i < repeats; ++i) {
    const double start = cpu_seconds();
    call();
    t.push_back(cpu_seconds() - start);
  }
  std::nth_element(t.begin(), t.begin() + repeats / 2, t.end());
  return t[static_cast<std::size_t>(repeats / 2)];
}

}  // namespace powbench::bench
