#pragma once

#include <functional>
#include <string>
#include <vector>

/// Files as other instruments write them, made here, of two channels with known numbers. Tests, fuzz and benchmark
/// use them.

namespace powbench::host {

struct Waves {
  double start = -0.02, step = 1e-5;
  std::vector<double> ch1, ch2;  ///< V
};
/// Numbers that every format can carry without loss: multiples of 1/1024 V below 16 V.
Waves waves(std::uint64_t seed, std::size_t samples);

struct Foreign {
  std::string name;  ///< of the kind
  std::string file;  ///< with the ending that says the format
  std::string bytes;
  std::string header;  ///< of formats with a second file (Yokogawa): x.hdr
  int channels = 2;
};

/// Every text dialect of an oscilloscope.
std::vector<Foreign> scope_texts(const Waves&);
/// TDMS, MAT 5, Yokogawa, in several variants each.
std::vector<Foreign> binary_files(const Waves&);
/// WAV with floats (its clock begins at 0) and LVM.
std::vector<Foreign> logger_files(const Waves&);

}  // namespace powbench::host
