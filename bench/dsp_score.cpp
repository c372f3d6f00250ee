#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/dsp_methods.h"
#include "bench/dsp_metrics.h"
#include "bench/dsp_synth.h"
#include "core/phase.h"
#include "dsp/extract.h"

/// Speed against error of the contact extraction. Prints one table; `--json PATH` writes it too.
/// Usage: bench_dsp_score [--seeds N] [--rate HZ] [--json PATH] [--case SUBSTRING] [--method SUBSTRING]
/// [--all]

namespace {

using namespace powbench;
using namespace powbench::bench;

double cpu_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Arguments {
  int seeds = 40;
  double rate = 1e6;
  std::string json, only_case, only_method;
  bool all = false;
};

Arguments parse(int argc, char** argv) {
  Arguments a;
  for (int i = 1; i < argc; ++i) {
    const std::string key = argv[i];
    if (key == "--all") {
      a.all = true;
      continue;
    }
    if (i + 1 >= argc) throw std::invalid_argument(key + ": unknown, or its value is missing");
    const std::string value = argv[++i];
    if (key == "--seeds")
      a.seeds = std::stoi(value);
    else if (key == "--rate")
      a.rate = std::stod(value);
    else if (key == "--json")
      a.json = value;
    else if (key == "--case")
      a.only_case = value;
    else if (key == "--method")
      a.only_method = value;
    else
      throw std::invalid_argument(key + ": allowed --seeds --rate --json --case --method --all");
  }
  return a;
}

struct Cell {
  SynthSettings settings;
};

/// The short list shows every case at 40 dB and clean at the other levels; --all is the whole grid.
std::vector<Cell> grid(const Arguments& a) {
  std::vector<Cell> cells;
  constexpr ForceCase cases[] = {
      ForceCase::clean,        ForceCase::hum,          ForceCase::ring_in_band, ForceCase::ring_out_of_band,
      ForceCase::ring_overlap, ForceCase::ring_and_hum, ForceCase::short_pulses, ForceCase::droop,
      ForceCase::clip};
  for (const ForceCase c : cases)
    for (const PulseForm form : {PulseForm::half_sine, PulseForm::hertz, PulseForm::asymmetric})
      for (const double snr : {20.0, 30.0, 40.0, 50.0, 60.0}) {
        const bool usual = (form == PulseForm::half_sine && (snr == 40 || c == ForceCase::clean)) ||
                           (c == ForceCase::clean && snr == 40);
        if (!a.all && !usual) continue;
        if (std::string(name(c)).find(a.only_case) == std::string::npos) continue;
        SynthSettings s;
        s.force_case = c;
        s.form = form;
        s.snr_db = snr;
        s.rate = a.rate;
        cells.push_back({s});
      }
  return cells;
}

Score run(const Cell& cell, const Method& m, int seeds) {
  Scorer scorer;
  double spent = 0;
  for (int k = 0; k < seeds; ++k) {
    const SynthRecord r = synthesise(cell.settings, static_cast<std::uint64_t>(k));
    const double before = cpu_ms();
    const auto found = m.contacts(r.record);
    spent += cpu_ms() - before;
    scorer.add(r.contacts, found);
  }
  Score s = scorer.score();
  s.cpu_ms = spent / seeds;
  return s;
}

nlohmann::json to_json(const Cell& c, const Method& m, const Score& s) {
  return {{"case", name(c.settings.force_case)},
          {"form", name(c.settings.form)},
          {"snr_db", c.settings.snr_db},
          {"rate_hz", c.settings.rate},
          {"method", m.name},
          {"records", s.records},
          {"recall", s.recall},
          {"precision", s.precision},
          {"exact", s.exact},
          {"touch_rmse_s", s.touch_rmse},
          {"touch_bias_s", s.touch_bias},
          {"touch_median_s", s.touch_median},
          {"release_rmse_s", s.release_rmse},
          {"release_bias_s", s.release_bias},
          {"duration_bias_s", s.duration_bias},
          {"peak_bias", s.peak_bias},
          {"z_std", s.z_std},
          {"cpu_ms", s.cpu_ms}};
}

/// Closing angle and whole-record cost on the eight-channel record.
nlohmann::json whole_record(int seeds) {
  nlohmann::json rows = nlohmann::json::array();
  std::printf("\nwhole record, 8 channels, 140 ms, 100 kS/s, raw to events\n%-12s %14s %12s %14s %10s\n",
              "mains Hz", "angle rms deg", "angle z", "seat rms us", "CPU ms");
  for (const double hertz : {49.5, 50.0, 50.5}) {
    double angle2 = 0, z2 = 0, seat2 = 0, spent = 0;
    for (int k = 0; k < seeds; ++k) {
      FullTruth truth;
      const Record r = synthesise_full(100e3, hertz, radians(9.0 * k), static_cast<std::uint64_t>(k), &truth);
      const double before = cpu_ms();
      const Events e = dsp::extract_events(r);
      spent += cpu_ms() - before;
      const double d = wrap_half_turn(e.coil.closing_angle.value - truth.closing_angle);
      angle2 += d * d / seeds;
      z2 += d * d / (e.coil.closing_angle.u * e.coil.closing_angle.u) / seeds;
      seat2 += std::pow(e.core.seat.value - truth.core_seat, 2) / seeds;
    }
    std::printf("%-12.1f %14.4f %12.2f %14.2f %10.2f\n", hertz, degrees(std::sqrt(angle2)), std::sqrt(z2),
                1e6 * std::sqrt(seat2), spent / seeds);
    rows.push_back({{"mains_hz", hertz},
                    {"angle_rms_deg", degrees(std::sqrt(angle2))},
                    {"angle_z", std::sqrt(z2)},
                    {"seat_rms_s", std::sqrt(seat2)},
                    {"cpu_ms", spent / seeds}});
  }
  return rows;
}

void print(const Cell& c, const Method& m, const Score& s) {
  std::printf(
      "%-33s %-10s %3.0f | %-10s | %5.3f %5.3f %5.3f | %7.2f %7.2f %6.2f | %7.2f %7.2f | %7.2f | %6.3f | "
      "%6.2f | %8.2f\n",
      std::string(name(c.settings.force_case)).c_str(), std::string(name(c.settings.form)).c_str(),
      c.settings.snr_db, std::string(m.name).c_str(), s.recall, s.precision, s.exact, 1e6 * s.touch_rmse,
      1e6 * s.touch_bias, 1e6 * s.touch_median, 1e6 * s.release_rmse, 1e6 * s.release_bias,
      1e6 * s.duration_bias, s.peak_bias, s.z_std, s.cpu_ms);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  const Arguments a = parse(argc, argv);
  nlohmann::json out{{"contacts", nlohmann::json::array()}};
  std::printf(
      "contacts of one film at %.0f kS/s, %d records a row; times in us; CPU of one thread per record\n",
      a.rate / 1e3, a.seeds);
  std::printf("%-33s %-10s %3s | %-10s | %5s %5s %5s | %7s %7s %6s | %7s %7s | %7s | %6s | %6s | %8s\n",
              "case", "form", "dB", "method", "recal", "prec", "exact", "touch", "bias", "median", "release",
              "bias", "dur bias", "peak", "z std", "CPU ms");
  for (const Cell& c : grid(a))
    for (const Method& m : methods()) {
      if (std::string(m.name).find(a.only_method) == std::string::npos) continue;
      const Score s = run(c, m, a.seeds);
      print(c, m, s);
      out["contacts"].push_back(to_json(c, m, s));
    }
  out["whole_record"] = whole_record(a.seeds);
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
