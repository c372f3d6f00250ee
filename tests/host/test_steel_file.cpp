#include "host/config/steel_file.h"

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/units.h"
#include "host/config/bad_input.h"
#include "host/config/specimen_file.h"
#include "sim/magnetics/circuit/lumped_magnet.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Matchers::Contains;

namespace {

/// The built-in curve `team20` as a CSV file, B and H in other units.
std::string sheet(const std::string& header, double b_unit, double h_unit, bool b_first = false) {
  std::string text = header + "\n";
  const auto steel = sim::builtin_steel("team20");
  for (const auto& k : steel.knots()) {
    if (k.b > 2.0) break;
    char line[80];
    const double b = k.b / b_unit, h = k.h / h_unit;
    std::snprintf(line, sizeof line, "%.10g, %.10g\n", b_first ? b : h, b_first ? h : b);
    text += line;
  }
  return text;
}

std::string errors_of(const std::string& text) {
  try {
    static_cast<void>(parse_steel(text, "lab.csv"));
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / "powbench_steel_file_test";
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path / name, std::ios::binary) << text;
  }
};

}  // namespace

TEST_CASE("a B-H sheet means the same in every unit and order of columns", "[config]") {
  const double oersted = 1e3 / (4 * pi);
  const auto truth = sim::builtin_steel("team20");
  for (const auto& text : {sheet("H (A/m), B (T)", 1, 1), sheet("B [T], H [kA/m]", 1, 1e3, true),
                           sheet("H in Oe, B in G", 1e-4, oersted), sheet("H_A_per_m, B_mT", 1e-3, 1),
                           sheet("Field strength (A/cm), Flux density (kG)", 0.1, 100)}) {
    INFO(text.substr(0, 40));
    const auto s = parse_steel(text, "some/lab.csv");
    CHECK(s.name == "lab");
    CHECK_FALSE(s.fitted.smoothed);
    const auto curve = sim::Steel::table("x", s.fitted.rows);
    for (const double b : {0.1, 0.7, 1.2, 1.6, 1.9}) CHECK(curve.h(b) == Approx(truth.h(b)).epsilon(2e-3));
  }
}

TEST_CASE("the polarisation and other columns", "[config]") {
  std::string text = "no;H (A/m);J (T);loss (W/kg)\n";
  const auto steel = sim::builtin_steel("team20");
  int n = 0;
  for (const double b : {0.1, 0.4, 0.8, 1.2, 1.5, 1.8, 2.0}) {
    char line[100];
    std::snprintf(line, sizeof line, "%d;%.12g;%.12g;1\n", ++n, steel.h(b), b - sim::mu0 * steel.h(b));
    text += line;
  }
  const auto s = parse_steel(text, "lab.csv");
  REQUIRE(s.measured.size() == 7);
  CHECK(s.measured.back().b == Approx(2.0));
  CHECK(s.notes.size() == 2);
}

TEST_CASE("slips of a B-H sheet are refused with the reason and what would fit", "[config]") {
  CHECK_THAT(errors_of(sheet("H (A/m), B (T)", 1, 1e3)),
             Contains("lab.csv:1: columns 'H (A/m)' and 'B (T)'") && Contains("H in kA/m"));
  CHECK_THAT(errors_of(sheet("H (A/m), B (T)", 1e-4, 1)), Contains("B - mu0 H reaches 2e+04 T") &&
                                                              Contains("iron saturates at 2.2 T") &&
                                                              Contains("B in G"));
  CHECK_THAT(errors_of(sheet("B (T), H (A/m)", 1, 1)), Contains("the columns swapped"));
  CHECK_THAT(errors_of(sheet("H, B (T)", 1, 1)), Contains("'H': has no unit") && Contains("kA/m"));
  CHECK_THAT(errors_of(sheet("H (A), B (Gs)", 1, 1)),
             Contains("unit 'A' is not known") && Contains("unit 'Gs'"));
  CHECK_THAT(errors_of(sheet("H (A/m), current (A)", 1, 1)),
             Contains("no column B or J") && Contains("'current (A)'"));
  CHECK_THAT(errors_of("H (A/m), B (T)\n10, 0.1\n20, 0.4\n"), Contains("2 rows") && Contains("at least 4"));
}

TEST_CASE("a sheet under the unit of another one is told that one, and no other way to read it", "[config]") {
  const auto under_oe = errors_of(sheet("H (Oe), B (T)", 1, 1));
  CHECK_THAT(under_oe, Contains("H in A/m") && !Contains("column J"));
  CHECK_THAT(errors_of(sheet("H (kA/m), B (T)", 1, 1)), Contains("H in A/m") && !Contains("column J"));
  CHECK_THAT(errors_of(sheet("H (A/m), B (G)", 1, 1)), Contains("B in T"));
  // read as a polarisation it passes for a bad steel: then that is said
  const auto s = parse_steel(sheet("H (A/m), J (T)", 1, 0.1), "lab.csv");
  REQUIRE(s.notes.size() == 1);
  CHECK_THAT(s.notes[0], Contains("is the unit right?"));
}

TEST_CASE("rows that say little of the steel are refused, or said to", "[config]") {
  const std::string head = "H (A/m), B (T)\n";
  CHECK_THAT(errors_of(head + "10, 1.2\n100, 1.2\n1000, 1.2\n5000, 1.21\n"), Contains("hardly rises"));
  const auto low = parse_steel(head + "20, 0.05\n40, 0.12\n80, 0.32\n130, 0.56\n", "lab.csv");
  REQUIRE(low.notes.size() == 1);
  CHECK_THAT(low.notes[0], Contains("end at 0.56 T") && Contains("guess"));
  CHECK(parse_steel(sheet("H (A/m), B (T)", 1, 1), "lab.csv").notes.empty());
  const auto lines = parse_steel(sheet("H (A/m), B (T)", 1, 1) + "nan, 1.9\n9000, inf\n", "lab.csv");
  REQUIRE(lines.notes.size() == 1);
  CHECK_THAT(lines.notes[0], Contains("line ") && Contains(" and 1 more") && Contains("passed over"));
  CHECK_THAT(errors_of(head + "10, 0.1\n50, 0.5\n-300, -0.9\n800, 1.4\n2000, 1.6\n"),
             Contains("lab.csv:4: B = -0.9 T"));
  for (const char* header : {"H / (A/m), B / T", "H / A/m, B / T"})
    CHECK(parse_steel(sheet(header, 1, 1), "lab.csv").measured.size() > 4);
  CHECK_THAT(errors_of(""), Contains("is empty"));
}

TEST_CASE("a specimen takes its steel from a sheet beside it, and its stored text holds the rows",
          "[config]") {
  const Folder folder;
  folder.write("lab.csv", sheet("H (A/m), B (T)", 1, 1));
  folder.write("c.specimen.toml", "[magnet]\nsteel = \"lab.csv\"\n");
  const auto s = read_specimen(folder.path / "c.specimen.toml");
  CHECK(s.magnet.steel == "lab");
  CHECK(sim::steel_of(s.magnet).h(1.5) == Approx(2130));
  const auto again = parse_specimen(resolved_text(s), "stored");  // from another folder, without the sheet
  CHECK(again.magnet.steel_b == s.magnet.steel_b);
  CHECK(again.magnet.steel_h == s.magnet.steel_h);
  CHECK(resolved_text(again) == resolved_text(s));
  CHECK_THAT(resolved_text(s), !Contains("bh_"));
  const auto named = parse_specimen("[magnet]\nsteel = \"m700-100a\"\n", "s.toml");
  CHECK(sim::steel_of(named.magnet).name() == "m700-100a");
  CHECK(resolved_text(parse_specimen(resolved_text(named), "x")) == resolved_text(named));
}

TEST_CASE("mistakes about a specimen's steel", "[config]") {
  const auto errors = [](const std::string& text) {
    try {
      static_cast<void>(parse_specimen(text, "s.toml"));
    } catch (const BadInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(errors("[magnet]\nsteel = \"wood\"\n"),
             Contains("s.toml:2") && Contains("unknown") && Contains("team20"));
  CHECK_THAT(errors("[magnet]\nsteel = \"none.csv\"\n"), Contains("none.csv: cannot be read"));
  CHECK_THAT(errors("[magnet]\nsteel = \"team20\"\nbh_exponent = 9\n"),
             Contains("s.toml:3") && Contains("leave out"));
  CHECK_THAT(errors("[magnet]\nsteel_B_T = [1, 2]\n"), Contains("belongs to a steel"));
  CHECK_THAT(errors("[magnet]\nsteel = \"x\"\nsteel_B_T = [0.5, 1, 1.5]\nsteel_H_A_per_m = [100, 50, 300]\n"),
             Contains("H must increase"));
}

TEST_CASE("circuit and plane field of a specimen carry the same measured steel", "[config]") {
  auto s = parse_specimen("[magnet]\nsteel = \"m530-50a\"\n", "s.toml");
  const sim::MagneticCircuit circuit(s.magnet, s.core.travel);
  const double phi = 1.6 * s.magnet.pole_area;
  const auto closed = circuit.field(phi, s.magnet.shaded_share * phi, 0);
  const auto air = [&] {
    auto bare = s.magnet;
    bare.iron_length = 1e-12;
    return sim::MagneticCircuit(bare, s.core.travel).field(phi, s.magnet.shaded_share * phi, 0).mmf;
  }();
  CHECK(closed.mmf - air == Approx(s.magnet.iron_length * sim::builtin_steel("m530-50a").h(1.6)));
  // the energy is the integral of the mmf, and its slope that of the mmf
  const double step = 1e-4 * phi;
  const double share = s.magnet.shaded_share * phi;
  const double difference =
      (circuit.field(phi + step, share, 0).energy - circuit.field(phi - step, share, 0).energy) / (2 * step);
  CHECK(difference == Approx(closed.mmf).epsilon(1e-6));
  CHECK(circuit.field(-phi, -share, 0).mmf == -closed.mmf);
}
