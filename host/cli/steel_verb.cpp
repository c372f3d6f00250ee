#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/cli/named_steel.h"
#include "host/cli/verbs.h"
#include "host/config/bad_input.h"
#include "host/export/steel_svg.h"
#include "host/export/write_file.h"
#include "host/export/xml_text.h"
#include "host/report/markup.h"
#include "host/store/store.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/steel_rows.h"

namespace powbench::host {
namespace {

constexpr double shown[] = {0.2, 0.5, 1.0, 1.3, 1.5, 1.7, 1.9, 2.1};  // T

Exit list_steels(bool json) {
  if (json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const auto& name : sim::builtin_steel_names()) {
      const auto s = sim::builtin_steel(name);
      list.push_back({{"name", name},
                      {"source", sim::builtin_steel_source(name)},
                      {"H_at_1.5T_A_per_m", s.h(1.5)},
                      {"largest_permeability", s.peak_permeability()}});
    }
    fmt::print("{}\n", list.dump(2));
    return Exit::pass;
  }
  fmt::print("{:<16}{:>12}{:>12}{:>10}  {}\n", "steel", "H at 1 T", "H at 1.5 T", "mu_r max", "source");
  for (const auto& name : sim::builtin_steel_names()) {
    const auto s = sim::builtin_steel(name);
    fmt::print("{:<16}{:>12.4g}{:>12.4g}{:>10.0f}  {}\n", name, s.h(1), s.h(1.5), s.peak_permeability(),
               sim::builtin_steel_source(name));
  }
  return Exit::pass;
}

double saturation(const sim::Steel& s) {
  const double b = std::max(s.straight_from(), 3.0);
  return b - sim::mu0 * s.h(b);
}

void print_text(const NamedSteel& n, const std::string& file) {
  const auto& s = n.steel;
  if (n.sheet) {
    double low = 1e300, high = 0, top = 0;
    for (const auto& r : n.sheet->measured) {
      low = std::min(low, r.h);
      high = std::max(high, r.h);
      top = std::max(top, r.b);
    }
    fmt::print("{}: {} rows, H {:.4g} .. {:.4g} A/m, B up to {:.4g} T\n", n.name, n.sheet->measured.size(),
               low, high, top);
    const auto& f = n.sheet->fitted;
    if (f.smoothed)
      fmt::print(
          "  smoothed: the curve misses the rows by {:.3g} T rms, by {:.3g} T at most (H = {:.4g} A/m)\n",
          f.rms, f.worst, f.worst_h);
    else
      fmt::print("  no noise: the curve goes through every row\n");
  } else {
    fmt::print("{}: {}\n", n.name, sim::builtin_steel_source(n.name));
  }
  fmt::print("  relative permeability {:.4g} at the start, {:.4g} at most\n", 1 / (sim::mu0 * s.dh_db(0)),
             s.peak_permeability());
  if (s.data_end() < s.straight_from())
    fmt::print("  data end at {:.4g} T; beyond them by the saturation law, to B - mu0 H = {:.4g} T\n",
               s.data_end(), saturation(s));
  else
    fmt::print("  B - mu0 H = {:.4g} T in saturation\n", saturation(s));
  fmt::print("  {:>6}{:>12}\n", "B T", "H A/m");
  for (const double b : shown)
    fmt::print("  {:>6.1f}{:>12.5g}{}\n", b, s.h(b), b > s.data_end() ? "  extrapolated" : "");
  fmt::print("{}\n", file);
}

void print_json(const NamedSteel& n, const std::string& file) {
  const auto& s = n.steel;
  nlohmann::ordered_json out{{"steel", n.name}};
  if (n.sheet) {
    const auto& f = n.sheet->fitted;
    out["rows"] = n.sheet->measured.size();
    out["smoothed"] = f.smoothed;
    out["residual_rms_T"] = f.rms;
    out["residual_worst_T"] = f.worst;
    out["notes"] = n.sheet->notes;
  } else {
    out["source"] = sim::builtin_steel_source(n.name);
  }
  out["initial_permeability"] = 1 / (sim::mu0 * s.dh_db(0));
  out["largest_permeability"] = s.peak_permeability();
  out["data_end_T"] = s.data_end();
  out["saturation_T"] = saturation(s);
  out["curve"] = nlohmann::ordered_json::array();
  for (const double b : shown)
    out["curve"].push_back({{"B_T", b}, {"H_A_per_m", s.h(b)}, {"extrapolated", b > s.data_end()}});
  out["picture"] = file;
  fmt::print("{}\n", out.dump(2));
}

}  // namespace

NamedSteel named_steel(const std::string& word) {
  if (names_steel_file(word)) {
    auto sheet = read_steel(word);
    auto steel = sim::Steel::table(sheet.name, sheet.fitted.rows);
    return {sheet.name, std::move(steel), std::move(sheet)};
  }
  try {
    return {word, sim::builtin_steel(word), {}};
  } catch (const std::invalid_argument& error) {
    throw BadInput({std::string(error.what()) + "; a sheet of your own is a file, such as " + word + ".csv"});
  }
}

Exit show_steel(const SteelArgs& args) {
  if (args.steel.empty()) return list_steels(args.json);
  const auto named = named_steel(args.steel);
  if (named.sheet)
    for (const auto& note : named.sheet->notes) fmt::print(stderr, "{}: {}\n", args.steel, note);
  const std::string file = args.picture.empty() ? named.name + ".svg" : args.picture;
  write_file(file, steel_svg(named.steel, named.sheet ? named.sheet->measured : std::vector<sim::BhRow>{},
                             escaped(named.name)));
  args.json ? print_json(named, file) : print_text(named, file);
  return Exit::pass;
}

}  // namespace powbench::host
