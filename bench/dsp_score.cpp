#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/dsp_figures.h"
#include "bench/dsp_methods.h"
#include "bench/dsp_metrics.h"
#include "bench/dsp_synth.h"
#include "core/memory.h"
#include "core/phase.h"
#include "dsp/events/extract.h"

/// Speed against error of the contact extraction. Prints one table; `--json PATH` writes it too, and the picture
/// beside it.
/// Usage: bench_dsp_score [--seeds N] [--held-out N] [--angles N] [--rate HZ] [--json PATH] [--case SUBSTRING]
/// [--method SUBSTRING] [--all]

namespace {

using namespace powbench;
using namespace powbench::bench;

double cpu_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Arguments {
  int seeds = 40;
  int held_out = 40, angles = 8;
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
    else if (key == "--held-out")
      a.held_out = std::stoi(value);
    else if (key == "--angles")
      a.angles = std::stoi(value);
    else if (key == "--rate")
      a.rate = std::stod(value);
    else if (key == "--json")
      a.json = value;
    else if (key == "--case")
      a.only_case = value;
    else if (key == "--method")
      a.only_method = value;
    else
      throw std::invalid_argument(
          key + ": allowed --seeds --held-out --angles --rate --json --case --method --all");
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
        if (c != ForceCase::clean || form != PulseForm::half_sine || snr != 40 || a.rate == 100e3) continue;
        s.rate = 100e3;
        cells.push_back({s});
      }
  return cells;
}

/// Records that nobody looked at while the extraction was made: their seeds begin here. To be moved on whenever it
/// changes.
constexpr std::uint64_t unseen_seeds = 1100000;

struct Sample {
  SynthRecord record;
  std::vector<double> bounds;  ///< s, of each contact
};

std::vector<Sample> samples(const Cell& cell, int seeds, bool unseen) {
  std::vector<Sample> out;
  for (int k = 0; k < seeds; ++k) {
    Sample s{synthesise(cell.settings, (unseen ? unseen_seeds : 0) + static_cast<std::uint64_t>(k)), {}};
    for (const TrueContact& c : s.record.contacts)
      s.bounds.push_back(touch_bound(c, cell.settings.form, s.record.noise, cell.settings.rate));
    out.push_back(std::move(s));
  }
  return out;
}

Score run(const std::vector<Sample>& records, const Method& m) {
  Scorer scorer;
  double spent = 0;
  for (const Sample& s : records) {
    const double before = cpu_ms();
    const auto found = m.contacts(s.record.record);
    spent += cpu_ms() - before;
    scorer.add(s.record.contacts, found, s.bounds);
  }
  Score s = scorer.score();
  s.cpu_ms = spent / static_cast<double>(std::max<std::size_t>(1, records.size()));
  return s;
}

/// One printed row.
struct Row {
  Cell cell;
  std::string method;
  bool unseen = false;
  Score score;
};

/// The row of a case at half sine, full chain, unseen records.
const Score* find(const std::vector<Row>& rows, ForceCase c, double snr, double rate) {
  for (const Row& r : rows)
    if (r.unseen && r.cell.settings.force_case == c && r.cell.settings.form == PulseForm::half_sine &&
        r.cell.settings.snr_db == snr && r.cell.settings.rate == rate)
      return &r.score;
  return nullptr;
}

void add_timing(std::vector<Figure>& out, const std::string& what, const Score* s) {
  if (!s) return;
  out.push_back(at_most(what + ": touch rms, us", 1e6 * s->touch_rmse, 4, 1));
  out.push_back(at_most(what + ": release rms, us", 1e6 * s->release_rmse, 4, 1));
  out.push_back(at_most(what + ": duration bias, us", 1e6 * s->duration_bias, 3, 0.5));
  out.push_back(between(what + ": std of error / uncertainty", s->z_std, 0.8, 1.25, 0.9, 1.1));
  out.push_back(at_most(what + ": touch error / Cramer-Rao bound", s->bound_ratio, 2, 1.2));
}

void add_ring(std::vector<Figure>& out, const std::string& what, const Score* s) {
  if (!s) return;
  out.push_back(at_least(what + ": precision", s->precision, 0.98, 0.995));
  out.push_back(at_least(what + ": exact sequence", s->exact, 0.95, 0.99));
  out.push_back(at_most(what + ": touch rms, us", 1e6 * s->touch_rmse, 10, 2));
  out.push_back(between(what + ": std of error / uncertainty", s->z_std, 0.8, 1.25, 0.9, 1.1));
  out.push_back(at_most(what + ": touch error / bound without ringing", s->bound_ratio, 2, 1.2));
}

std::vector<Figure> figures(const std::vector<Row>& rows, double rate) {
  std::vector<Figure> out;
  add_timing(out, "clean 40 dB", find(rows, ForceCase::clean, 40, rate));
  add_timing(out, "hum 40 dB", find(rows, ForceCase::hum, 40, rate));
  add_timing(out, "clean 40 dB at 100 kS/s", find(rows, ForceCase::clean, 40, 100e3));
  add_ring(out, "ringing 20 % in the band 40 dB", find(rows, ForceCase::ring_in_band, 40, rate));
  add_ring(out, "the same from before the first touch", find(rows, ForceCase::ring_overlap, 40, rate));
  if (const Score* s = find(rows, ForceCase::clean, 20, rate)) {
    out.push_back(at_least("clean 20 dB: exact sequence", s->exact, 0.97, 1));
    out.push_back(at_most("clean 20 dB: touch rms, us", 1e6 * s->touch_rmse, 25, 10));
    out.push_back(between("clean 20 dB: std of error / uncertainty", s->z_std, 0.8, 1.25, 0.9, 1.1));
  }
  out.push_back(at_most("5 N plateau behind 5 Hz: error, N", droop_error(), 0.02, 0.02));
  return out;
}

nlohmann::json to_json(const Row& row) {
  const Cell& c = row.cell;
  const Score& s = row.score;
  return {{"records_set", row.unseen ? "unseen" : "tuning"},
          {"bound_ratio", s.bound_ratio},
          {"case", name(c.settings.force_case)},
          {"form", name(c.settings.form)},
          {"snr_db", c.settings.snr_db},
          {"rate_hz", c.settings.rate},
          {"method", row.method},
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

void print(const Row& row) {
  const Score& s = row.score;
  std::printf(
      "%-33s %-10s %3.0f %5.0f %-6s | %-10s | %5.3f %5.3f %5.3f | %7.2f %7.2f %6.2f %5.2f | %7.2f %7.2f | "
      "%7.2f | %6.3f | "
      "%6.2f | %8.2f\n",
      std::string(name(row.cell.settings.force_case)).c_str(),
      std::string(name(row.cell.settings.form)).c_str(), row.cell.settings.snr_db,
      row.cell.settings.rate / 1e3, row.unseen ? "unseen" : "tuning", row.method.c_str(), s.recall,
      s.precision, s.exact, 1e6 * s.touch_rmse, 1e6 * s.touch_bias, 1e6 * s.touch_median, s.bound_ratio,
      1e6 * s.release_rmse, 1e6 * s.release_bias, 1e6 * s.duration_bias, s.peak_bias, s.z_std, s.cpu_ms);
  std::fflush(stdout);
}

/// Every cell with every method on the tuning records, and the full chain on records nobody tuned for.
std::vector<Row> score_contacts(const Arguments& a) {
  std::printf(
      "contacts of one film; %d tuning records and %d unseen ones a row; times in us; CPU of one thread per "
      "record\n",
      a.seeds, a.held_out);
  std::printf(
      "%-33s %-10s %3s %5s %-6s | %-10s | %5s %5s %5s | %7s %7s %6s %5s | %7s %7s | %7s | %6s | %6s | %8s\n",
      "case", "form", "dB", "kS/s", "set", "method", "recal", "prec", "exact", "touch", "bias", "median",
      "bound", "release", "bias", "dur bias", "peak", "z std", "CPU ms");
  std::vector<Row> rows;
  for (const Cell& c : grid(a))
    for (const bool unseen : {false, true}) {
      const auto records = samples(c, unseen ? a.held_out : a.seeds, unseen);
      for (const Method& m : methods()) {
        if (std::string(m.name).find(a.only_method) == std::string::npos) continue;
        if (records.empty() || (unseen && m.name != methods().back().name)) continue;
        rows.push_back({c, std::string(m.name), unseen, run(records, m)});
        print(rows.back());
      }
    }
  return rows;
}

std::vector<Mark> marks(const std::vector<Row>& rows) {
  std::vector<Mark> out;
  for (const Row& r : rows) {
    const auto& s = r.cell.settings;
    const bool ring = s.force_case == ForceCase::ring_in_band;
    if (r.unseen || s.snr_db != 40 || s.form != PulseForm::half_sine || s.rate != 1e6) continue;
    if (ring || s.force_case == ForceCase::clean)
      out.push_back({r.method, ring, r.score.cpu_ms, 1e6 * r.score.touch_rmse});
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) try {
  powbench::keep_freed_memory();  // as the program does
  const Arguments a = parse(argc, argv);
  const std::vector<Row> rows = score_contacts(a);
  nlohmann::json out{{"contacts", nlohmann::json::array()}};
  for (const Row& r : rows) out["contacts"].push_back(to_json(r));
  out["whole_record"] = whole_record(a.seeds);
  const RigScore rig = score_rig(a.angles);
  out["simulated_rig"] = rig.json;
  std::vector<Figure> all = figures(rows, a.rate);
  double worst = 0;
  for (const auto& row : out["whole_record"]) worst = std::max(worst, row["angle_rms_deg"].get<double>());
  all.push_back(at_most("closing angle rms at 50 Hz +- 0.5, degrees", worst, 0.1, 0.05));
  all.push_back(at_most("simulated rig: closing angle rms, degrees", rig.angle_deg, 0.1, 0.05));
  all.push_back(at_most("simulated rig: six channels, 100 ms, 200 kS/s, CPU ms", rig.cpu_ms, 50, 50));
  out["figures"] = print(all);
  if (!a.json.empty()) {
    std::ofstream file(a.json);
    file << out.dump(1) << '\n';
    if (!file) throw std::invalid_argument("--json " + a.json + ": cannot be written");
    write_picture(a.json.substr(0, a.json.rfind('.')) + ".svg", marks(rows));
  }
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 2;
}
