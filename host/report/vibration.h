#pragma once

#include <string>
#include <utility>
#include <vector>

/// Core vibration on the films as the report shows it: plain numbers, no signal processing.

namespace powbench::host {

/// What the band finder says about one film.
struct FilmBands {
  std::string film;   ///< `film A`
  std::string basis;  ///< what it rests on, e.g. "coherence with aux over 20 closings"
  std::vector<std::pair<double, double>> core;  ///< Hz, bands in which the core vibrates
  double contact_hertz = 0;                     ///< Hz: the contact force reaches up to here
  double ring_in_contact_db = 0;                ///< dB: vibration inside the contact band; -inf without one
  double pulse_in_core_db = 0;  ///< dB: what band-stops on the core bands would take from a contact
  bool overlaps = false;
  std::string filter;     ///< the plain filter, or why there is none
  std::string canceller;  ///< what the reference explains, or why it was not used
};

struct SpectrumLine {
  std::string label;
  std::vector<double> hertz, db;  ///< dB re 1 N^2/Hz
};

/// dB re 1 N^2/Hz against time and frequency.
struct SpectrumMap {
  std::string title;
  double t0_ms = 0, dt_ms = 0, bin_hertz = 0;
  std::size_t frames = 0, bins = 0;
  std::vector<float> db;  ///< (frames, bins)
};

struct VibrationView {
  int shot = 0;      ///< index of the closing in the pictures, from 1
  double angle = 0;  ///< rad
  double impact_ms = 0;
  std::string film;  ///< in the pictures
  std::vector<FilmBands> films;
  std::vector<SpectrumLine> spectra;
  std::vector<SpectrumMap> maps;
};

}  // namespace powbench::host
